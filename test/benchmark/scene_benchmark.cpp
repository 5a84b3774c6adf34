// Time per state of a robot's clearance, beside FCL: the same precomputed poses for every library, interleaved round by
// round. What is timed is the update with the poses and one question; forward kinematics is not. The results go into a
// JSON file, with how the pairs were settled, and how far FCL's answers lie from ours. ./dev bench scene runs it
// pinned.
#include "benchmark/agreement.h"
#include "benchmark/benchmark_main.h"
#include "benchmark/motions.h"
#include "benchmark/timing.h"
#include "peers/cells.h"
#include "peers/fcl_scene.h"
#include "peers/robots.h"
#include "peers/scene_library.h"
#include "proximity_server/scene/derivative/constraint_rows.h"
#include "proximity_server/scene/guaranteed/guaranteed_distances.h"
#include "proximity_server/scene/model/kinematics.h"
#include "scene/posed_scene.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <functional>
#include <iostream>
#include <map>
#include <memory>

namespace proximity_server::benchmark {

using namespace scene;
using namespace peers;
namespace {

using nlohmann::json;
using Model = std::shared_ptr<const SceneModel>;

constexpr int kRounds = 5;
constexpr double kRoundSeconds = 0.2;  // of one library in one round, more or less; fewer states if that takes longer
constexpr std::size_t kBlock = 20;     // so many successive states are timed together
constexpr int kScalingStates = 200;

enum class Motion { Coherent, Cold };
constexpr Motion kMotions[] = {Motion::Coherent, Motion::Cold};
std::string nameOf(Motion motion) { return motion == Motion::Cold ? "cold" : "coherent"; }

std::vector<BodyPoses> statesOf(const RobotModel& robot, Motion motion, int states) {
  return motion == Motion::Cold ? randomStates(robot, states) : coherentMotion(robot, states);
}

struct NamedLibrary {
  std::string name;
  /// `objects` is nullptr if there are none.
  std::function<std::unique_ptr<SceneLibrary>(const Model& model, const std::shared_ptr<const Objects>& objects)> make;
};

NamedLibrary ours(const std::string& name, Skipping skipping) {
  return {name, [skipping](const Model& model, const std::shared_ptr<const Objects>& objects) {
            return std::make_unique<OurScene>(model, skipping, objects);
          }};
}

NamedLibrary fclBy(const std::string& name, FclScene::Method method) {
  return {name, [method](const Model& model, const std::shared_ptr<const Objects>& objects) {
            return std::make_unique<FclScene>(*model, method, objects.get());
          }};
}

/// The others are compared with the first.
std::vector<NamedLibrary> allLibraries() {
  return {ours("ours", Skipping::On), ours("ours, no skipping", Skipping::Off),
          fclBy("FCL hulls", FclScene::Method::HullsLibccd), fclBy("FCL hulls, INDEP", FclScene::Method::HullsIndep),
          fclBy("FCL triangles", FclScene::Method::Triangles)};
}

std::vector<NamedLibrary> scalingLibraries() {
  const std::vector<NamedLibrary> all = allLibraries();
  return {all[0], all[2], all[4]};
}

/// One question about one robot in each of its states.
struct Row {
  const NamedRobot& robot;
  Motion motion;
  SceneQuestion question;
  const std::vector<BodyPoses>& states;
  std::shared_ptr<const Objects> objects = nullptr;

  std::string name() const { return robot.name + ", " + nameOf(question) + ", " + nameOf(motion); }
};

/// A library at work on a row.
class Run {
 public:
  Run(const NamedLibrary& library, const Row& row)
      : name_(library.name),
        row_(row),
        library_(library.make(row.robot.model, row.objects)),
        answers_(row.states.size()) {
    chooseStates();
    record();
  }

  const std::vector<std::size_t>& states() const { return states_; }
  bool asks(std::size_t state) const { return std::binary_search(states_.begin(), states_.end(), state); }
  const std::vector<PairDistance>& answerIn(std::size_t state) const { return answers_[state]; }
  const std::string& name() const { return name_; }

  /// Makes one pass over its states, each timed by itself.
  void time() {
    for (std::size_t i = 0; i < states_.size(); ++i) {
      approach(states_[i]);
      times_.add(i, ask(states_[i]));
    }
  }

  json result() const;

 private:
  /// Returns the time [us].
  double ask(std::size_t state) {
    return timeOf<std::micro>([&] { library_->ask(row_.states[state], row_.question); });
  }

  /// Asks about the state before if it is not timed itself: a motion has no gaps.
  void approach(std::size_t state) {
    if (row_.motion == Motion::Coherent && state % kBlock == 0 && state > 0 && !asks(state - 1)) ask(state - 1);
  }

  void chooseStates();
  void record();

  std::string name_;
  const Row& row_;
  std::unique_ptr<SceneLibrary> library_;
  std::vector<std::size_t> states_;
  Rounds times_;                                    // [us] by timed state
  std::vector<std::vector<PairDistance>> answers_;  // by state of the row
  std::vector<PairCounts> counts_;                  // by timed state
  int failures_ = 0;
};

/// Chooses blocks of successive states all over the row, as many as there is time for.
void Run::chooseStates() {
  const std::size_t size = row_.states.size(), first = std::min(kBlock, size);
  std::vector<double> microseconds;
  for (std::size_t i = 0; i < first; ++i) microseconds.push_back(ask(i));
  const double block_seconds = 1e-6 * kBlock * medianOf(microseconds);
  const std::size_t blocks = (size + kBlock - 1) / kBlock;
  const auto affordable = static_cast<std::size_t>(std::clamp(kRoundSeconds / block_seconds, 1.0, 1e6));
  const std::size_t stride = (blocks + affordable - 1) / affordable;
  for (std::size_t i = 0; i < size; ++i)
    if (i / kBlock % stride == 0) states_.push_back(i);
  times_ = Rounds(states_.size());
}

/// Keeps the answers of one pass that is not timed.
void Run::record() {
  const int failures_before = library_->failures();
  for (const std::size_t state : states_) {
    approach(state);
    ask(state);
    answers_[state] = library_->pairs();
    counts_.push_back(library_->counts());
  }
  failures_ = library_->failures() - failures_before;
}

/// Returns the means over the states.
json meansOf(const std::vector<PairCounts>& counts) {
  const std::pair<const char*, int PairCounts::*> rungs[] = {
      {"total", &PairCounts::total},         {"unknown", &PairCounts::unknown},
      {"at_rest", &PairCounts::at_rest},     {"by_motion", &PairCounts::by_motion},
      {"by_bounds", &PairCounts::by_bounds}, {"computed", &PairCounts::computed}};
  json means;
  for (const auto& [name, rung] : rungs) {
    double sum = 0.0;
    for (const PairCounts& count : counts) sum += count.*rung;
    means[name] = sum / static_cast<double>(counts.size());
  }
  return means;
}

json Run::result() const {
  const std::vector<double> medians = times_.medians();
  json result = {{"row", row_.name()},
                 {"robot", row_.robot.name},
                 {"question", nameOf(row_.question)},
                 {"motion", nameOf(row_.motion)},
                 {"library", name_},
                 {"pairs", static_cast<std::int64_t>(row_.robot.model->pairs.checked.size()) +
                               (row_.objects ? row_.objects->pairCount() : 0)},
                 {"bodies", row_.robot.model->robot.bodies.size() - 1},
                 {"states", states_.size()},
                 {"median_us", medianOf(medians)},
                 {"p99_us", quantile(medians, 0.99)},
                 {"failures", failures_}};
  const json means = meansOf(counts_);
  if (means["total"] == 0.0) return result;
  result["counts"] = means;
  result["skipped"] = 1.0 - means["computed"].get<double>() / means["total"].get<double>();
  return result;
}

/// Returns how far the answers of `other` lie from those of `reference`, in the states that both were asked about.
json agreementOf(const Row& row, const Run& reference, const Run& other) {
  Agreement agreement(*row.robot.model, row.question);
  for (const std::size_t state : other.states())
    if (reference.asks(state)) agreement.compare(row.states[state], reference.answerIn(state), other.answerIn(state));
  return agreement.summary();
}

/// Returns the share of the states in which some pair overlaps, as far as was asked.
double overlappingShare(const Run& run) {
  const auto overlaps = [&](std::size_t state) {
    const std::vector<PairDistance>& answer = run.answerIn(state);
    return std::any_of(answer.begin(), answer.end(), [](const PairDistance& pair) { return pair.distance <= 0.0; });
  };
  const auto count = std::count_if(run.states().begin(), run.states().end(), overlaps);
  return static_cast<double>(count) / static_cast<double>(run.states().size());
}

/// Returns the largest difference [m] of two answers about the minimum, if both say that it is apart.
double largestDifference(const Run& reference, const Run& other) {
  double largest = 0.0;
  for (const std::size_t state : other.states()) {
    if (!reference.asks(state) || reference.answerIn(state).empty() || other.answerIn(state).empty()) continue;
    const double ours = reference.answerIn(state).front().distance, others = other.answerIn(state).front().distance;
    if (ours > 0.0 && others > 0.0) largest = std::max(largest, std::abs(ours - others));
  }
  return largest;
}

/// Returns one entry a library.
json measure(const Row& row, const std::vector<NamedLibrary>& libraries) {
  std::vector<Run> runs;
  runs.reserve(libraries.size());
  for (const NamedLibrary& library : libraries) runs.emplace_back(library, row);
  for (int round = 0; round < kRounds; ++round)
    for (Run& run : runs) run.time();
  json entries = json::array();
  for (const Run& run : runs) {
    json entry = run.result();
    entry["overlapping"] = overlappingShare(run);
    if (row.objects && row.question == SceneQuestion::Minimum)
      entry["largest_difference"] = largestDifference(runs.front(), run);
    if (!row.objects && &run != &runs.front()) entry["agreement"] = agreementOf(row, runs.front(), run);
    entries.push_back(entry);
  }
  showProgress();
  return entries;
}

/// Returns how many pairs a search for the minimum cannot leave out by boxes: the mean over some states.
double pairsInReach(const Row& row) {
  FclScene scene(*row.robot.model, FclScene::Method::HullsLibccd);
  double sum = 0.0;
  int states = 0;
  for (std::size_t i = 0; i < row.states.size(); i += kBlock, ++states) {
    scene.ask(row.states[i], SceneQuestion::Minimum);
    const std::vector<PairDistance> minimum = scene.pairs();
    if (!minimum.empty()) sum += scene.pairsWithBoxesWithin(minimum.front().distance);
  }
  return sum / states;
}

/// The rows of one robot, in both motions.
struct Contest {
  NamedRobot robot;
  std::vector<SceneQuestion> questions;
  std::vector<NamedLibrary> libraries;
  int states;
  std::shared_ptr<const Objects> objects = nullptr;
  bool counts_pairs_in_reach = false;
};

json measure(const Contest& contest, const Wanted& wanted) {
  json rows = json::array();
  for (const Motion motion : kMotions) {
    const std::vector<BodyPoses> poses = statesOf(contest.robot.model->robot, motion, contest.states);
    for (const SceneQuestion question : contest.questions) {
      const Row row{contest.robot, motion, question, poses, contest.objects};
      if (!wanted(row.name())) continue;
      json entries = measure(row, contest.libraries);
      if (contest.counts_pairs_in_reach)
        for (json& entry : entries) entry["pairs_in_reach"] = pairsInReach(row);
      append(rows, entries);
    }
  }
  return rows;
}

json measureRobots(const std::vector<NamedRobot>& robots, int states, const Wanted& wanted) {
  json rows = json::array();
  for (const NamedRobot& robot : robots)
    append(rows,
           measure({robot, {SceneQuestion::Minimum, SceneQuestion::Below, SceneQuestion::All}, allLibraries(), states},
                   wanted));
  return rows;
}

/// Measures a robot with objects around it.
json measureCells(const std::vector<NamedCell>& cells, int states, const Wanted& wanted) {
  json rows = json::array();
  for (const NamedCell& cell : cells)
    append(rows, measure({{cell.name, cell.model},
                          {SceneQuestion::Contact, SceneQuestion::Minimum, SceneQuestion::Below},
                          scalingLibraries(),
                          states,
                          cell.objects},
                         wanted));
  return rows;
}

/// Measures the minimum of ever more arms side by side.
json measureScaling(int states, const Wanted& wanted) {
  json rows = json::array();
  for (const int bodies : {2, 5, 10, 20, 50, 100, 200, 500})
    append(rows, measure({rowsOfArms(bodies),
                          {SceneQuestion::Minimum},
                          scalingLibraries(),
                          std::min(states, kScalingStates),
                          /*objects=*/nullptr,
                          /*counts_pairs_in_reach=*/true},
                         wanted));
  return rows;
}

/// The steps of adding a box to the 1000: each is timed by itself, and again and again.
class AddedBox {
 public:
  AddedBox(const NamedCell& cell, const std::vector<BodyPoses>& states)
      : states_(states), before_(cell.objects), scene_(cell.model), undisturbed_(cell.model) {
    scene_.use(before_);
    undisturbed_.use(before_);
  }

  void run(int number) {
    const BodyPoses& poses = states_[static_cast<std::size_t>(number) % states_.size()];
    Objects next = *before_;
    undisturbed_.update(poses);
    time("a question to a scene of the 1000", [&] { undisturbed_.minimum(undisturbed_.candidates()); });
    Object box;
    time("make the box", [&] { box = boxOfCell(number); });
    time("make the next objects", [&] { next = before_->changed({AddObject{box}}); });
    const auto after = std::make_shared<const Objects>(std::move(next));
    scene_.update(poses);
    time("give them to a scene", [&] { scene_.use(after); });
    time("its next question", [&] { scene_.minimum(scene_.candidates()); });
    time("a question to a scene that keeps the 1000", [&] { undisturbed_.minimum(undisturbed_.candidates()); });
    // The next one is added to these, up to a hundred more.
    if (number % 100 != 99) {
      before_ = after;
      return;
    }
    before_ = first_;
    scene_.use(before_);
  }

  json result() const {
    json rows = json::array();
    for (const std::string& step : order_) {
      const std::vector<double>& microseconds = times_.at(step);
      rows.push_back({{"row", step},
                      {"median_us", medianOf(microseconds)},
                      {"p99_us", quantile(microseconds, 0.99)},
                      {"most_us", quantile(microseconds, 1.0)}});
    }
    return rows;
  }

 private:
  template <typename Step>
  void time(const std::string& name, const Step& step) {
    if (times_.count(name) == 0) order_.push_back(name);
    times_[name].push_back(timeOf<std::micro>(step));
  }

  const std::vector<BodyPoses>& states_;
  std::shared_ptr<const Objects> before_;
  const std::shared_ptr<const Objects> first_ = before_;
  PosedScene scene_, undisturbed_;
  std::map<std::string, std::vector<double>> times_;  // [us] by step
  std::vector<std::string> order_;
};

json measureAddedBoxes(const NamedCell& cell, int states, const Wanted& wanted) {
  if (!wanted("Add a box to " + cell.name)) return json::array();
  const std::vector<BodyPoses> poses = coherentMotion(cell.model->robot, states);
  AddedBox added(cell, poses);
  for (int number = 0; number < states; ++number) added.run(number);
  return added.result();
}

/// A controller asks for so many in each cycle.
constexpr int kConstraintRows = 8;

/// The second distance is so large that all rows are used.
const VelocityDamper kDampers[] = {{{0.02, 0.02}, 0.3, 0.5}, {{0.02, 0.02}, 1.0, 0.5}};

/// The steps of a controller's cycle. All questions go to scenes of their own, as each keeps from state to state what
/// helps it; each step is timed by itself in every state.
class ControllerCycles {
 public:
  ControllerCycles(const NamedRobot& robot, const std::vector<BodyPoses>& states, const VelocityDamper& damper)
      : states_(states),
        damper_(damper),
        scene_(robot.model),
        scene_of_rows_(robot.model),
        rows_(robot.model, kConstraintRows),
        fcl_(*robot.model, FclScene::Method::HullsLibccd),
        rows_of_fcl_(kConstraintRows, scene_.state.degreesOfFreedom().size()),
        of_distances_(states.size()),
        of_rows_(states.size()),
        of_gradients_(states.size()),
        of_fcl_(states.size()) {
    question_.threshold = damper.influence_distance;
    gradient_.resize(scene_.state.degreesOfFreedom().size());
  }

  /// Each step goes through all states by itself, so that none finds in the cache what another has just read.
  void runRound() {
    for (std::size_t state = 0; state < states_.size(); ++state) {
      of_distances_.add(state, timeOf<std::micro>([&] { askForDistances(state); }));
      timeGradients(state);
    }
    for (std::size_t state = 0; state < states_.size(); ++state) {
      of_rows_.add(state, timeOf<std::micro>([&] { askForRows(state); }));
      used_ += usedRows();
      ++asked_;
    }
    // It keeps nothing from state to state, so that some are enough.
    for (std::size_t state = 0; state < states_.size(); state += 10)
      of_fcl_.add(state, timeOf<std::micro>([&] { askFclForRows(state); }));
  }

  json result(const std::string& row) const {
    const std::vector<double> distances = of_distances_.medians(), rows = of_rows_.medians(), fcl = of_fcl_.medians();
    json result = {{"row", row},
                   {"rows", kConstraintRows},
                   {"rows_used", used_ / asked_},
                   {"influence_distance", damper_.influence_distance},
                   {"states", states_.size()},
                   {"distances_us", medianOf(distances)},
                   {"distances_p99_us", quantile(distances, 0.99)},
                   {"median_us", medianOf(rows)},
                   {"p99_us", quantile(rows, 0.99)},
                   {"fcl_us", medianOf(fcl)},
                   {"fcl_p99_us", quantile(fcl, 0.99)}};
    const std::vector<double> gradients = of_gradients_.medians();
    if (!gradients.empty()) result["gradient_us"] = medianOf(gradients);
    return result;
  }

 private:
  void askForDistances(std::size_t state) {
    scene_.update(states_[state]);
    found_ = &scene_.closestBelow(scene_.candidates(), kConstraintRows, question_).closest;
  }

  void askForRows(std::size_t state) {
    scene_of_rows_.update(states_[state]);
    rows_.find(scene_of_rows_.scene, scene_of_rows_.state, damper_);
  }

  /// Takes FCL's distances and points into the same formula. There are none of pairs that overlap.
  void askFclForRows(std::size_t state) {
    scene_.update(states_[state]);
    Eigen::Index row = 0;
    for (const FclScene::PairWithPoints& found :
         fcl_.closest(states_[state], kConstraintRows, damper_.influence_distance)) {
      if (!(found.distance > 0.0)) continue;
      PairProximity pair{scene_.candidates()[found.candidate], 0, 0, {}};
      pair.result.status = narrowphase::Status::Converged;
      pair.result.has_points = true;
      pair.result.point_a = found.point_a;
      pair.result.point_b = found.point_b;
      pair.result.normal = (found.point_b - found.point_a).normalized();
      gradient(scene_.state, pair, gradient_);
      rows_of_fcl_.row(row++) = gradient_;
    }
  }

  /// Times the gradients of all found pairs several times, as a single one is too short for the clock.
  void timeGradients(std::size_t state) {
    constexpr int kRepetitions = 20;
    if (found_->empty()) return;
    const double all = timeOf<std::micro>([&] {
      for (int i = 0; i < kRepetitions; ++i)
        for (const PairProximity& pair : *found_) {
          gradient(scene_.state, pair, gradient_);
          sum_ += gradient_[0];  // so that the compiler computes it
        }
    });
    of_gradients_.add(state, all / (kRepetitions * static_cast<double>(found_->size())));
  }

  double usedRows() const {
    const auto is_used = [](const ConstraintRows::Row& row) { return row.is_used; };
    return static_cast<double>(std::count_if(rows_.rows().begin(), rows_.rows().end(), is_used));
  }

  const std::vector<BodyPoses>& states_;
  const VelocityDamper damper_;
  PosedScene scene_, scene_of_rows_;
  ConstraintRows rows_;
  FclScene fcl_;
  Eigen::MatrixXd rows_of_fcl_;
  Question question_;
  Eigen::VectorXd gradient_;
  const std::vector<PairProximity>* found_ = nullptr;      // by the last question to scene_
  Rounds of_distances_, of_rows_, of_gradients_, of_fcl_;  // [us] by state
  double used_ = 0.0, asked_ = 0.0, sum_ = 0.0;
};

/// Measures the constraint rows of the closest pairs, beside their distances alone.
json measureConstraintRows(const std::vector<NamedRobot>& robots, int states, const Wanted& wanted) {
  json rows = json::array();
  for (const NamedRobot& robot : robots)
    for (const Motion motion : kMotions) {
      const std::string name = robot.name + ", constraint rows, " + nameOf(motion);
      if (!wanted(name)) continue;
      const std::vector<BodyPoses> poses = statesOf(robot.model->robot, motion, states);
      for (const VelocityDamper& damper : kDampers) {
        ControllerCycles cycles(robot, poses, damper);
        for (int round = 0; round < kRounds; ++round) cycles.runRound();
        rows.push_back(cycles.result(name));
      }
      showProgress();
    }
  return rows;
}

/// A cycle of the monitor without and with an uncertainty of each joint: the pairs that it lists, then the smallest
/// guaranteed distance from these. The two take turns, state by state.
class GuaranteedCycles {
 public:
  GuaranteedCycles(const NamedRobot& robot, const std::vector<BodyPoses>& states, double uncertainty)
      : states_(states),
        uncertainty_(uncertainty),
        scene_(robot.model),
        scene_of_guaranteed_(robot.model),
        guaranteed_(robot.model),
        of_distances_(states.size()),
        of_guaranteed_(states.size()) {
    guaranteed_.assume(uncertaintyOfJoints(robot.model->robot, uncertainty));
    question_.threshold = 0.3;  // the node's default
  }

  void runRound() {
    for (std::size_t state = 0; state < states_.size(); ++state) {
      of_distances_.add(state, timeOf<std::micro>([&] { list(scene_, state); }));
      of_guaranteed_.add(state, timeOf<std::micro>([&] { guarantee(state); }));
    }
  }

  json result(const std::string& row) const {
    const std::vector<double> distances = of_distances_.medians(), guaranteed = of_guaranteed_.medians();
    return {{"row", row},
            {"uncertainty", uncertainty_},
            {"states", states_.size()},
            {"distances_us", medianOf(distances)},
            {"median_us", medianOf(guaranteed)},
            {"p99_us", quantile(guaranteed, 0.99)},
            {"ratio", medianOf(guaranteed) / medianOf(distances)},
            {"median_loss", medianOf(losses_)},
            {"p99_loss", quantile(losses_, 0.99)}};
  }

 private:
  static constexpr int kListed = 10;  // the node's default

  PairsBelow list(PosedScene& scene, std::size_t state) {
    scene.update(states_[state]);
    return scene.closestBelow(scene.candidates(), kListed, question_);
  }

  void guarantee(std::size_t state) {
    const PairsBelow below = list(scene_of_guaranteed_, state);
    const std::vector<PairProximity>& closest = below.closest;
    const bool are_all = static_cast<std::size_t>(below.count) == closest.size();
    const double others = are_all ? question_.threshold : closest.back().result.lower_bound - question_.tolerance;
    const Pairs pairs(scene_of_guaranteed_.candidates());
    const GuaranteedMinimum found = guaranteed_.find(scene_of_guaranteed_.scene, scene_of_guaranteed_.state, pairs, {},
                                                     {closest.data(), closest.data() + closest.size(), others});
    losses_.push_back(found.pair.result.distance - found.guaranteed);
  }

  const std::vector<BodyPoses>& states_;
  const double uncertainty_;
  PosedScene scene_, scene_of_guaranteed_;
  GuaranteedDistances guaranteed_;
  Question question_;
  Rounds of_distances_, of_guaranteed_;  // [us] by state
  std::vector<double> losses_;           // [m] of the pair that decides
};

json measureGuarantees(const std::vector<NamedRobot>& robots, int states, const Wanted& wanted) {
  json rows = json::array();
  for (const NamedRobot& robot : robots)
    for (const Motion motion : kMotions) {
      const std::string name = robot.name + ", guaranteed, " + nameOf(motion);
      if (!wanted(name)) continue;
      const std::vector<BodyPoses> poses = statesOf(robot.model->robot, motion, states);
      for (const double uncertainty : {1e-4, 1e-3, 1e-2}) {
        GuaranteedCycles cycles(robot, poses, uncertainty);
        for (int round = 0; round < kRounds; ++round) cycles.runRound();
        rows.push_back(cycles.result(name));
      }
      showProgress();
    }
  return rows;
}

}  // namespace
}  // namespace proximity_server::benchmark

int main(int argc, char** argv) {
  using namespace proximity_server::benchmark;
  proximity_server::tools::ProgramOptions program("scene_benchmark",
                                                  "Time per state of a robot's clearance, beside FCL");
  int states = 2000;
  addPositive(program, "--states", states, "states of each motion");
  return benchmarkMain(program, argc, argv, [&](const Wanted& wanted) {
    std::vector<NamedRobot> robots = robotsToMeasure();
    nlohmann::json result = {{"cells", nlohmann::json::array()}, {"added", nlohmann::json::array()}};
    if (const auto two = twoPandas()) {
      const std::vector<NamedCell> cells = pandaCells(robots.front());
      result["cells"] = measureCells(cells, states, wanted);
      result["added"] = measureAddedBoxes(cells[1], states, wanted);
      robots.insert(robots.end() - 1, *two);
    }
    result["rows"] = measureRobots(robots, states, wanted);
    result["constraint_rows"] = measureConstraintRows(robots, states, wanted);
    result["guaranteed"] = measureGuarantees(robots, states, wanted);
    result["scaling"] = measureScaling(states, wanted);
    return result;
  });
}
