// Time per state of a sweep over many states, forward kinematics included: ours in batches, our Scene alone, FCL in
// each of its ways, and spheres as planners use them; in random states and along edges. Interleaved round by round. The
// results go into a JSON file, with how far the answers of the others lie from ours, the efficiency of two threads, and
// what a batch costs to make. Times are those of the processor, but for two threads, whose time is that of the clock.
// ./dev bench sweep runs it pinned.
#include "benchmark/agreement.h"
#include "benchmark/benchmark_main.h"
#include "benchmark/motions.h"
#include "benchmark/timing.h"
#include "heap_in_use.h"
#include "peers/fcl_scene.h"
#include "peers/robots.h"
#include "peers/sweep_library.h"
#include "scene/kernels/lane_kernels.h"

#include <sched.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <functional>
#include <memory>
#include <thread>

namespace proximity_server::benchmark {

using namespace scene;
using namespace peers;
namespace {

using nlohmann::json;
using Model = std::shared_ptr<const SceneModel>;

constexpr int kRounds = 7;
constexpr int kBatch = 4096;           // states
constexpr double kRoundSeconds = 0.1;  // of one library in one round, more or less
constexpr int kFewest = 64;            // states of a library that is slow
constexpr double kAccuracy = 1e-4;     // [m] of the minimum that planners need
constexpr SceneQuestion kQuestions[] = {SceneQuestion::AnyBelow, SceneQuestion::Minimum, SceneQuestion::Closest,
                                        SceneQuestion::Below};

struct NamedLibrary {
  std::string name;
  std::function<std::unique_ptr<SweepLibrary>(const Model& model)> make;
};

NamedLibrary fclBy(const std::string& name, FclScene::Method method) {
  return {name, [method](const Model& model) {
            return std::make_unique<SweepScene>(model, std::make_unique<FclScene>(*model, method));
          }};
}

/// The others are compared with the first.
std::vector<NamedLibrary> libraries(SceneQuestion question) {
  std::vector<NamedLibrary> libraries{
      {"ours", [](const Model& model) { return std::make_unique<SweepBatch>(model); }},
      {"ours, Scene",
       [](const Model& model) {
         return std::make_unique<SweepScene>(model, std::make_unique<OurScene>(model, Skipping::On));
       }},
      fclBy("FCL hulls", FclScene::Method::HullsLibccd),
      fclBy("FCL hulls, INDEP", FclScene::Method::HullsIndep),
      fclBy("FCL triangles", FclScene::Method::Triangles),
      {"spheres", [](const Model& model) { return std::make_unique<SweepSpheres>(*model); }}};
  if (question == SceneQuestion::Minimum)
    libraries.push_back(
        {"ours, 0.1 mm", [](const Model& model) { return std::make_unique<SweepBatch>(model, kAccuracy); }});
  return libraries;
}

/// One question about one robot in each of its states.
struct Row {
  const NamedRobot& robot;
  std::string states_name;
  SceneQuestion question;
  const PositionTable& states;

  std::string name() const { return robot.name + ", " + nameOf(question) + ", " + states_name; }
};

/// Calls `ask` with the states of each batch, one after the other.
template <typename Ask>
void forBatches(const PositionTable& states, Eigen::Index count, const Ask& ask) {
  for (Eigen::Index first = 0; first < count; first += kBatch)
    ask(states.middleRows(first, std::min<Eigen::Index>(kBatch, count - first)));
}

/// A library at work on a row.
class Run {
 public:
  Run(const NamedLibrary& library, const Row& row)
      : name_(library.name), row_(row), library_(library.make(row.robot.model)) {
    chooseStates();
    record();
  }

  const std::string& name() const { return name_; }
  const std::vector<SceneAnswer>& answers() const { return answers_; }

  void time() {
    const double start = processorSeconds();
    forBatches(row_.states, states_, [this](const States& batch) { library_->ask(batch, row_.question); });
    times_.push_back(1e9 * (processorSeconds() - start) / static_cast<double>(states_));
  }

  json result() const {
    return {{"row", row_.name()},
            {"robot", row_.robot.name},
            {"question", nameOf(row_.question)},
            {"states_are", row_.states_name},
            {"library", name_},
            {"pairs", row_.robot.model->pairs.checked.size()},
            {"states", states_},
            {"ns", medianOf(times_)},
            {"least_ns", quantile(times_, 0.0)}};
  }

 private:
  /// Chooses as many as there is time for, and whole batches if they are more than one.
  void chooseStates() {
    library_->ask(row_.states.topRows(kFewest), row_.question);
    const double start = processorSeconds();
    library_->ask(row_.states.topRows(kFewest), row_.question);
    const double seconds = (processorSeconds() - start) / kFewest;
    const double affordable =
        std::clamp(kRoundSeconds / seconds, double{kFewest}, static_cast<double>(row_.states.rows()));
    states_ = static_cast<Eigen::Index>(affordable);
    if (states_ > kBatch) states_ -= states_ % kBatch;
  }

  /// Keeps the answers of one pass that is not timed.
  void record() {
    forBatches(row_.states, states_, [this](const States& batch) {
      library_->ask(batch, row_.question);
      const std::vector<SceneAnswer> answers = library_->answers();
      answers_.insert(answers_.end(), answers.begin(), answers.end());
    });
  }

  std::string name_;
  const Row& row_;
  std::unique_ptr<SweepLibrary> library_;
  Eigen::Index states_ = 0;
  std::vector<SceneAnswer> answers_;
  std::vector<double> times_;  // [ns] a state, by round
};

/// Puts the first pairs that differ to the oracle, as ./dev bench scene does.
json judged(const Row& row, const Run& ours, const Run& other) {
  Agreement agreement(*row.robot.model, row.question);
  const std::size_t states = std::min(ours.answers().size(), other.answers().size());
  const RobotModel& robot = row.robot.model->robot;
  for (std::size_t i = 0; i < states; ++i)
    agreement.compare(forwardKinematics(robot, positionsOf(row.states, static_cast<Eigen::Index>(i))),
                      ours.answers()[i].pairs, other.answers()[i].pairs);
  return agreement.summary();
}

json agreementOf(const Row& row, const Run& ours, const Run& other) {
  json agreement = sweepAgreement(row.question, ours.answers(), other.answers());
  const bool can_be_judged = row.question == SceneQuestion::Minimum || row.question == SceneQuestion::Below;
  if (can_be_judged && other.name().rfind("FCL", 0) == 0) agreement["judged"] = judged(row, ours, other);
  return agreement;
}

json measure(const Row& row) {
  std::vector<Run> runs;
  for (const NamedLibrary& library : libraries(row.question)) runs.emplace_back(library, row);
  for (int round = 0; round < kRounds; ++round)
    for (Run& run : runs) run.time();
  json entries = json::array();
  for (const Run& run : runs) {
    json entry = run.result();
    if (&run != &runs.front()) entry["agreement"] = agreementOf(row, runs.front(), run);
    entries.push_back(entry);
  }
  showProgress();
  return entries;
}

/// Returns the two ways to take states, by name.
std::vector<std::pair<std::string, PositionTable>> statesOf(const RobotModel& robot, int states) {
  return {{"random", randomPositions(robot, states)}, {"edges", edgePositions(robot, states)}};
}

json measureRobot(const NamedRobot& robot, int states, const Wanted& wanted) {
  json rows = json::array();
  for (const auto& [name, positions] : statesOf(robot.model->robot, states))
    for (const SceneQuestion question : kQuestions) {
      const Row row{robot, name, question, positions};
      if (wanted(row.name())) append(rows, measure(row));
    }
  return rows;
}

/// Measures how long it takes to make the batch of a robot, and its memory.
json measureBatch(const NamedRobot& robot, const Wanted& wanted) {
  if (!wanted("batch, " + robot.name)) return json::array();
  std::vector<double> seconds;
  std::size_t bytes = 0;
  for (int round = 0; round < kRounds; ++round) {
    const std::size_t before = heapInUse();
    const double start = processorSeconds();
    const SceneBatch batch(robot.model);
    seconds.push_back(processorSeconds() - start);
    bytes = heapInUse() - before;
  }
  return json::array({json{{"robot", robot.name},
                           {"links", robot.model->robot.links.size()},
                           {"pieces", robot.model->robot.pieces.size()},
                           {"seconds", medianOf(seconds)},
                           {"bytes", bytes},
                           {"spheres", SphereScene(*robot.model).sphereCount()}}});
}

void runOn(int core) {
  cpu_set_t cores;
  CPU_ZERO(&cores);
  CPU_SET(static_cast<unsigned>(core), &cores);
  sched_setaffinity(0, sizeof cores, &cores);  // a wish: where it fails, the thread runs anywhere
}

/// Returns the seconds until each of so many threads, on a core of its own, has answered all states with a batch of its
/// own.
double secondsOf(int threads, SceneQuestion question, const PositionTable& states, const SceneBatch& batch) {
  std::vector<std::unique_ptr<SweepBatch>> batches;
  for (int i = 0; i < threads; ++i) {
    batches.push_back(std::make_unique<SweepBatch>(batch.forAnotherThread()));
    batches.back()->ask(states.topRows(std::min<Eigen::Index>(kBatch, states.rows())), question);
  }
  return timeOf<std::ratio<1>>([&] {
    std::vector<std::thread> running;
    for (int i = 0; i < threads; ++i)
      running.emplace_back([&, i] {
        runOn(i);
        SweepBatch& own = *batches[i];
        forBatches(states, states.rows(), [&](const States& some) { own.ask(some, question); });
      });
    for (std::thread& thread : running) thread.join();
  });
}

/// Measures the states per second of two threads, each with as many states as the one alone, over twice those of one.
json measureThreads(const NamedRobot& robot, int states, const Wanted& wanted) {
  json rows = json::array();
  const SceneBatch batch(robot.model);
  const PositionTable positions = randomPositions(robot.model->robot, states);
  for (const SceneQuestion question : {SceneQuestion::AnyBelow, SceneQuestion::Minimum}) {
    if (!wanted("threads, " + robot.name + ", " + nameOf(question))) continue;
    // So many states that the start of a thread does not count.
    const double fewest = secondsOf(1, question, positions.topRows(kFewest), batch) / kFewest;
    const auto count =
        static_cast<Eigen::Index>(std::clamp(0.3 / fewest, double{kFewest}, static_cast<double>(states)));
    const PositionTable part = positions.topRows(count);
    std::vector<double> ratios, rates;
    for (int round = 0; round < kRounds; ++round) {
      const double alone = secondsOf(1, question, part, batch), both = secondsOf(2, question, part, batch);
      ratios.push_back(alone / both);
      rates.push_back(static_cast<double>(count) / alone);
    }
    rows.push_back({{"robot", robot.name},
                    {"question", nameOf(question)},
                    {"states", count},
                    {"states_per_second", medianOf(rates)},
                    {"efficiency", medianOf(ratios)}});
  }
  showProgress();
  return rows;
}

/// Returns the instructions that the lanes use here. The answers do not depend on them.
std::string instructionSet() { return lanes::kernels().name; }

}  // namespace
}  // namespace proximity_server::benchmark

int main(int argc, char** argv) {
  using namespace proximity_server::benchmark;
  proximity_server::tools::ProgramOptions program("sweep_benchmark",
                                                  "Time per state of a sweep, beside FCL and spheres");
  int states = 16 * kBatch;
  addCount(program, "--states", states, kFewest, 1 << 24,
           "most states of each row (default: " + std::to_string(states) + ")");
  return benchmarkMain(program, argc, argv, [&](const Wanted& wanted) {
    nlohmann::json result = {{"instruction_set", instructionSet()}, {"batch", kBatch}};
    result["rows"] = result["threads"] = result["batches"] = nlohmann::json::array();
    for (const NamedRobot& robot : robotsToMeasure()) {
      append(result["rows"], measureRobot(robot, states, wanted));
      append(result["threads"], measureThreads(robot, states, wanted));
      append(result["batches"], measureBatch(robot, wanted));
    }
    return result;
  });
}
