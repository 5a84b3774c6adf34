// How good and how fast bounds over sets of joint positions are: guaranteed distances beside the worst states that a search
// finds, free motions, and proofs of whole robots with their certificates. The results go into a JSON file. Times are those
// of the processor. ./dev bench sets runs it pinned.
#include "benchmark/benchmark_main.h"
#include "benchmark/timing.h"
#include "peers/robots.h"
#include "proximity_server/scene/derivative/free_motion.h"
#include "proximity_server/scene/guaranteed/guaranteed_distances.h"
#include "proximity_server/scene/proof/certify.h"
#include "proximity_server/scene/proof/prove_apart.h"
#include "scene/example_robots.h"
#include "scene/posed_scene.h"
#include "scene/random_states.h"
#include "scene/uncertainty/uncertain_states.h"

#include <sys/time.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <csignal>
#include <iterator>

namespace proximity_server::benchmark {

using namespace scene;
using namespace peers;
namespace {

using nlohmann::json;

constexpr int kRounds = 5;
constexpr int kClosest = 4;             // pairs of a state
constexpr double kEnoughSeconds = 2.0;  // of a proof that is repeated
constexpr long kMostBoxes = 100000;     // of a pair: the default of prove
constexpr int kFewBoxes[] = {1, 10, 100, 1000};

constexpr struct {
  const char* name;
  double most;  // [rad] or [m] of each joint
} kUncertainties[] = {{"1 mrad", 1e-3}, {"1 degree", M_PI / 180.0}};

/// The rows of src/tools/prove/README.md besides kExampleRobots.
constexpr ExampleRobot kProvenRobots[] = {
    {"B1 with Z1", "b1_description/urdf/b1-z1.urdf", "b1_description/srdf/b1-z1.srdf"},
    {"HyQ", "hyq_description/robots/hyq_no_sensors.urdf", "hyq_description/srdf/hyq.srdf"},
    {"Go2", "go2_description/urdf/go2.urdf", "go2_description/srdf/go2.srdf"},
    {"Solo12", "solo_description/robots/solo12.urdf", "solo_description/srdf/solo.srdf"},
    {"Baxter", "baxter_description/urdf/baxter.urdf", "baxter_description/srdf/baxter_manipulation.srdf"},
    {"Romeo", "romeo_description/urdf/romeo.urdf", "romeo_description/srdf/romeo.srdf"}};
constexpr ExampleRobot kTalos = {"Talos", "talos_data/robots/talos_full_v2.urdf", "talos_data/srdf/talos.srdf"};

struct Amounts {
  int states = 200;
  double seconds = 60.0;  // of the processor, for the proofs of a robot, and as many for their certificates
};

/// Returns the median of some times, and what 99 % of them do not exceed.
json summary(const std::vector<double>& times) { return {{"median", medianOf(times)}, {"p99", quantile(times, 0.99)}}; }

std::vector<BodyPoses> statesOf(const RobotModel& robot, int count) {
  Chance chance(21);
  std::vector<BodyPoses> states;
  for (int i = 0; i < count; ++i) states.push_back(forwardKinematics(robot, randomPositions(robot, chance)));
  return states;
}

// ---- guaranteed distances

class Guarantees {
 public:
  Guarantees(const NamedRobot& robot, double most, const std::vector<BodyPoses>& states)
      : scene_(robot.model),
        within_(robot.model),
        states_(states),
        uncertainty_(robot.model->robot),
        distances_(robot.model) {
    std::fill(uncertainty_.positions.begin(), uncertainty_.positions.end(), most);
    distances_.assume(uncertainty_);
    for (const BodyPoses& state : states_) {
      scene_.update(state);
      closest_.emplace_back();
      for (const PairProximity& pair : scene_.closest(scene_.candidates(), kClosest))
        if (pair.result.lower_bound > 0.0) closest_.back().push_back(pair);
    }
  }

  /// Returns lossFactor() of each pair.
  std::vector<double> losses() {
    std::vector<double> losses;
    Chance chance(22);
    for (std::size_t i = 0; i < states_.size(); ++i)
      for (const PairProximity& pair : closest_[i]) {
        begin(i);
        const double guaranteed = distances_.of(scene_.state, pair);
        double worst = pair.result.distance;
        while (const ReachedState* reached = distances_.reached(scene_.state, pair, worst))
          worst = reached->upper_bound;
        losses.push_back(lossFactor(pair, guaranteed, worst, within_, states_[i], uncertainty_, chance));
      }
    return losses;
  }

  /// Measures of() by pair, and find() by state, of new objects.
  json times() {
    std::vector<std::size_t> first(1, 0);  // by state: the number of its first pair
    for (const std::vector<PairProximity>& pairs : closest_) first.push_back(first.back() + pairs.size());
    Rounds of_pairs(first.back()), of_states(states_.size());
    for (int round = 0; round < kRounds; ++round)
      for (std::size_t i = 0; i < states_.size(); ++i) {
        for (std::size_t k = 0; k < closest_[i].size(); ++k) {
          begin(i);
          of_pairs.add(first[i] + k, processorTimeOf<std::micro>([&] { distances_.of(scene_.state, closest_[i][k]); }));
        }
        begin(i);
        of_states.add(i, processorTimeOf<std::micro>([&] { distances_.find(scene_.scene, scene_.state, {}); }));
      }
    return {{"pairs", first.back()}, {"of_us", summary(of_pairs.medians())}, {"find_us", summary(of_states.medians())}};
  }

 private:
  void begin(std::size_t state) {
    scene_.update(states_[state]);
    distances_.forget();
  }

  PosedScene scene_, within_;
  const std::vector<BodyPoses>& states_;
  Uncertainty uncertainty_;
  GuaranteedDistances distances_;
  std::vector<std::vector<PairProximity>> closest_;  // by state: those that are apart
};

// ---- free motions

/// Measures weights() of all checked pairs by pair, and find() of the pairs within the influence distance by state.
json measureFreeMotion(const NamedRobot& robot, const std::vector<BodyPoses>& states) {
  PosedScene scene(robot.model);
  FreeMotion free(robot.model);
  const FreeMotionQuestion question;
  Question near;
  near.threshold = question.influence_distance;
  Eigen::VectorXd weights(scene.state.degreesOfFreedom().size());
  const std::vector<ShapeRefPair> pairs = scene.candidates().list();
  Rounds of_weights(states.size()), of_find(states.size());
  std::vector<double> bubbles;
  for (int round = 0; round < kRounds; ++round)
    for (std::size_t i = 0; i < states.size(); ++i) {
      scene.update(states[i]);
      const std::vector<PairProximity> below = scene.below(scene.candidates(), near);
      of_find.add(i, processorTimeOf<std::micro>(
                         [&] { free.find(scene.state, below.data(), below.data() + below.size(), question); }));
      const double all = processorTimeOf<std::nano>([&] {
        for (const ShapeRefPair& pair : pairs) free.weights(scene.state, pair, weights);
      });
      of_weights.add(i, all / static_cast<double>(pairs.size()));
      if (round == 0) bubbles.push_back(free.size());
    }
  return {{"pairs", pairs.size()},
          {"bubbles", medianOf(bubbles)},
          {"weights_ns", summary(of_weights.medians())},
          {"find_us", summary(of_find.medians())}};
}

// ---- proofs

std::atomic<double> end{0.0};  // [s] of processorSeconds()
std::atomic<bool> is_over{false};

void setTimer(suseconds_t microseconds) {
  const itimerval timer{{0, microseconds}, {0, microseconds}};
  setitimer(ITIMER_REAL, &timer, nullptr);
}

/// Returns a deadline after some processor time: other work of the machine does not count. A timer of real time looks for
/// it, because the kernel rounds the clock of the processor to its ticks while a timer of that clock runs.
Deadline deadlineAfter(double seconds) {
  end = processorSeconds() + seconds;
  is_over = false;
  std::signal(SIGALRM, [](int) { is_over = is_over || processorSeconds() >= end; });
  setTimer(10000);
  return Deadline(is_over);
}

/// Calls `step` with a deadline, more often if it takes little time, and returns the median time [s].
template <typename Step>
double secondsOf(double most, const Step& step) {
  std::vector<double> times;
  double all = 0.0;
  while (times.empty() || (all < kEnoughSeconds && times.size() < kRounds)) {
    const Deadline deadline = deadlineAfter(most);
    times.push_back(processorTimeOf<std::ratio<1>>([&] { step(deadline); }));
    all += times.back();
  }
  setTimer(0);
  return medianOf(times);
}

json outcomesOf(const std::vector<PairProof>& proofs) {
  std::vector<double> boxes;  // of each proven pair
  long refuted = 0, all = 0;
  for (const PairProof& proof : proofs) {
    all += proof.boxes;
    refuted += proof.outcome == ProofOutcome::Refuted;
    if (proof.outcome == ProofOutcome::Proven) boxes.push_back(static_cast<double>(proof.boxes));
  }
  json within = json::array();  // how many pairs are proven with at most so many boxes
  for (const int most : kFewBoxes)
    within.push_back(std::count_if(boxes.begin(), boxes.end(), [&](double count) { return count <= most; }));
  double sum = 0.0;
  for (const double count : boxes) sum += count;
  return {{"pairs", proofs.size()},
          {"proven", boxes.size()},
          {"refuted", refuted},
          {"boxes", all},
          {"boxes_of_proven", sum},
          {"proven_within", within},
          {"most_boxes_of_proven", quantile(boxes, 1.0)}};
}

/// Asks what `prove --pairs disabled --time-budget` asks, with the time of the processor in place of that of a clock.
json measureProof(const NamedRobot& robot, double most_seconds) {
  std::vector<ShapeRefPair> pairs;
  for (const LinkPair& pair : robot.model->pairs.pairs)
    if (pair.reason == PairReason::SrdfDisabled) pairs.push_back({{pair.link_a}, {pair.link_b}});
  ProofQuestion question;
  question.contact_distance = kContactDistance;
  question.most_boxes = kMostBoxes;
  std::vector<PairProof> proofs;
  const double prove = secondsOf(most_seconds, [&](const Deadline& deadline) {
    question.deadline = deadline;
    proofs = proveApart(robot.model, pairs, knownRanges(robot.model->robot), question);
  });
  std::vector<std::optional<PairCertificate>> certificates;
  const double certify_too = secondsOf(most_seconds, [&](const Deadline& deadline) {
    question.deadline = deadline;
    certificates = certify(robot.model, proofs, question);
  });
  std::size_t certified = 0, nodes = 0;
  for (const std::optional<PairCertificate>& certificate : certificates) {
    certified += certificate.has_value();
    if (certificate) nodes += certificate->tree.size();
  }
  json result = outcomesOf(proofs);
  result.update({{"seconds", prove},
                 {"seconds_with_certificates", prove + certify_too},
                 {"certified", certified},
                 {"nodes", nodes}});
  return result;
}

// ---- rows

enum class Rows : unsigned char { All, StatesOnly, ProofOnly };

void measureRobot(const std::string& name, Rows rows, const std::function<std::optional<NamedRobot>()>& load,
                  const Amounts& amounts, const Wanted& wanted, json& result) {
  const auto isWanted = [&](const std::string& row, Rows without) {
    return rows != without && wanted(name + ", " + row);
  };
  std::vector<std::size_t> uncertainties;
  for (std::size_t i = 0; i < std::size(kUncertainties); ++i)
    if (isWanted(kUncertainties[i].name, Rows::ProofOnly)) uncertainties.push_back(i);
  const bool is_free_motion = isWanted("free motion", Rows::ProofOnly), is_proof = isWanted("proof", Rows::StatesOnly);
  if (uncertainties.empty() && !is_free_motion && !is_proof) return;
  const std::optional<NamedRobot> robot = load();
  if (!robot) {
    std::cout << name << " is left out. " << kExampleRobotsMissing << "\n";
    return;
  }
  const auto add = [&](const std::string& table, json entry) {
    entry["robot"] = name;
    result[table].push_back(entry);
    showProgress();
  };
  const std::vector<BodyPoses> states = statesOf(robot->model->robot, amounts.states);
  for (const std::size_t i : uncertainties) {
    Guarantees guarantees(*robot, kUncertainties[i].most, states);
    json entry = guarantees.times();
    entry["uncertainty"] = kUncertainties[i].name;
    entry["loss"] = summary(guarantees.losses());
    add("guarantees", entry);
  }
  if (is_free_motion) add("free_motions", measureFreeMotion(*robot, states));
  if (is_proof) add("proofs", measureProof(*robot, amounts.seconds));
}

json measureRobots(const Amounts& amounts, const Wanted& wanted) {
  json result = {{"states", amounts.states},      {"closest", kClosest},    {"most_seconds", amounts.seconds},
                 {"most_boxes", kMostBoxes},      {"few_boxes", kFewBoxes}, {"guarantees", json::array()},
                 {"free_motions", json::array()}, {"proofs", json::array()}};
  const auto measure = [&](const ExampleRobot& files, Rows rows) {
    measureRobot(
        files.name, rows, [&] { return exampleRobot(files); }, amounts, wanted, result);
  };
  measureRobot(
      "Demo", Rows::StatesOnly, [] { return demoRobot(); }, amounts, wanted, result);
  for (const ExampleRobot& files : kExampleRobots) measure(files, Rows::All);
  measure(kTalos, Rows::All);
  for (const ExampleRobot& files : kProvenRobots) measure(files, Rows::ProofOnly);
  return result;
}

}  // namespace
}  // namespace proximity_server::benchmark

int main(int argc, char** argv) {
  using namespace proximity_server::benchmark;
  proximity_server::tools::ProgramOptions program("sets_benchmark", "Bounds over sets of joint positions");
  Amounts amounts;
  addPositive(program, "--states", amounts.states, "random states of a robot");
  addPositive(program, "--seconds", amounts.seconds,
              "of the processor for the proofs of a robot, and as many for their certificates");
  return benchmarkMain(program, argc, argv, [&](const Wanted& wanted) { return measureRobots(amounts, wanted); });
}
