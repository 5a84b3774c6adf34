// Time per state of a sweep over many states, forward kinematics included: ours in batches, our Scene alone, FCL in each of
// its ways, and spheres as planners use them; in random states and along edges. Interleaved round by round. The results go
// into a JSON file, with how far the answers of the others lie from ours, the efficiency of two threads, and what a batch
// costs to make. Times are those of the processor, but for two threads, whose time is that of the clock. ./dev bench sweep runs
// it pinned.
#include <malloc.h>
#include <sched.h>
#include <time.h>

#include <algorithm>
#include <chrono>
#include <functional>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <regex>
#include <thread>

#include "benchmark/agreement.h"
#include "benchmark/benchmark_main.h"
#include "benchmark/motions.h"
#include "benchmark/sweep_agreement.h"
#include "peers/robots.h"
#include "peers/sweep_library.h"
#include "scene/example_robots.h"
#include "scene/lanes/lane_kernels.h"

namespace proximity_server::benchmark {

using namespace scene;
using namespace peers;
namespace {

using nlohmann::json;
using Clock = std::chrono::steady_clock;
using Model = std::shared_ptr<const SceneModel>;

constexpr int kRounds = 7;
constexpr int kBatch = 4096;           // states
constexpr double kRoundSeconds = 0.1;  // of one library in one round, more or less
constexpr int kFewest = 64;            // states of a library that is slow

/// [s] Processor time of this thread: what else the machine does hardly counts.
double processorSeconds() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

struct NamedLibrary {
  std::string name;
  std::function<std::unique_ptr<SweepLibrary>(const Model& model)> make;
};

NamedLibrary fclBy(const std::string& name, FclScene::Method method) {
  return {name, [method](const Model& model) { return std::make_unique<SweepFcl>(model, method); }};
}

/// The first is what the others are compared with.
std::vector<NamedLibrary> libraries() {
  return {{"ours", [](const Model& model) { return std::make_unique<SweepBatch>(model); }},
          {"ours, Scene", [](const Model& model) { return std::make_unique<SweepScene>(model); }},
          fclBy("FCL hulls", FclScene::Method::HullsLibccd),
          fclBy("FCL hulls, INDEP", FclScene::Method::HullsIndep),
          fclBy("FCL triangles", FclScene::Method::Triangles),
          {"spheres", [](const Model& model) { return std::make_unique<SweepSpheres>(*model); }}};
}

/// One question about one robot in each of its states.
struct Row {
  const NamedRobot& robot;
  std::string states_name;
  SweepQuestion question;
  const PositionTable& states;

  std::string questionName() const {
    const char* names[] = {"any below 5 cm", "minimum", "5 closest", "below 5 cm"};
    return names[static_cast<int>(question)];
  }
  std::string name() const { return robot.name + ", " + questionName() + ", " + states_name; }
};

/// A library at work on a row.
class Run {
 public:
  Run(const NamedLibrary& library, const Row& row)
      : name_(library.name), row_(row), library_(library.make(row.robot.model)) {
    chooseStates();
    record();
  }

  const std::string& name() const { return name_; }
  const std::vector<SweepAnswer>& answers() const { return answers_; }

  void time() {
    const double start = processorSeconds();
    askAll([] {});
    times_.push_back(1e9 * (processorSeconds() - start) / static_cast<double>(states_));
  }

  json result() const {
    return {{"row", row_.name()},
            {"robot", row_.robot.name},
            {"question", row_.questionName()},
            {"states_are", row_.states_name},
            {"library", name_},
            {"pairs", row_.robot.model->pairs.checked.size()},
            {"states", states_},
            {"ns", quantile(times_, 0.5)},
            {"least_ns", quantile(times_, 0.0)}};
  }

 private:
  template <typename After>
  void askAll(const After& after) {
    for (Eigen::Index first = 0; first < states_; first += kBatch) {
      library_->ask(row_.states.middleRows(first, std::min<Eigen::Index>(kBatch, states_ - first)), row_.question);
      after();
    }
  }

  /// As many as there is time for, and whole batches if they are more than one.
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

  /// One pass that is not timed.
  void record() {
    askAll([this] {
      const std::vector<SweepAnswer> batch = library_->answers();
      answers_.insert(answers_.end(), batch.begin(), batch.end());
    });
  }

  std::string name_;
  const Row& row_;
  std::unique_ptr<SweepLibrary> library_;
  Eigen::Index states_ = 0;
  std::vector<SweepAnswer> answers_;
  std::vector<double> times_;  // [ns] a state, by round
};

/// Puts the first pairs that differ to the oracle, as ./dev bench scene does.
json judged(const Row& row, const Run& ours, const Run& other) {
  const bool is_minimum = row.question == SweepQuestion::Minimum;
  Agreement agreement(*row.robot.model, is_minimum ? SceneQuestion::Minimum : SceneQuestion::Below);
  const std::size_t states = std::min(ours.answers().size(), other.answers().size());
  std::vector<double> positions(row.robot.model->robot.joints.size());
  for (std::size_t i = 0; i < states; ++i) {
    for (std::size_t j = 0; j < positions.size(); ++j)
      positions[j] = row.states(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j));
    agreement.compare(forwardKinematics(row.robot.model->robot, positions), ours.answers()[i].pairs,
                      other.answers()[i].pairs);
  }
  return agreement.summary();
}

json agreementOf(const Row& row, const Run& ours, const Run& other) {
  json agreement = sweepAgreement(row.question, ours.answers(), other.answers());
  const bool can_be_judged = row.question == SweepQuestion::Minimum || row.question == SweepQuestion::Below;
  if (can_be_judged && other.name().rfind("FCL", 0) == 0) agreement["judged"] = judged(row, ours, other);
  return agreement;
}

json measure(const Row& row) {
  std::vector<Run> runs;
  for (const NamedLibrary& library : libraries()) runs.emplace_back(library, row);
  for (int round = 0; round < kRounds; ++round)
    for (Run& run : runs) run.time();
  json entries = json::array();
  for (const Run& run : runs) {
    json entry = run.result();
    if (&run != &runs.front()) entry["agreement"] = agreementOf(row, runs.front(), run);
    entries.push_back(entry);
  }
  std::cerr << "." << std::flush;
  return entries;
}

/// The two ways to take states, by name.
std::vector<std::pair<std::string, PositionTable>> statesOf(const RobotModel& robot, int states) {
  return {{"random", randomPositions(robot, states)}, {"edges", edgePositions(robot, states)}};
}

json measureRobot(const NamedRobot& robot, int states, const std::regex& wanted) {
  json rows = json::array();
  for (const auto& [name, positions] : statesOf(robot.model->robot, states))
    for (const SweepQuestion question :
         {SweepQuestion::AnyBelow, SweepQuestion::Minimum, SweepQuestion::Closest, SweepQuestion::Below}) {
      const Row row{robot, name, question, positions};
      if (!std::regex_search(row.name(), wanted)) continue;
      for (const json& entry : measure(row)) rows.push_back(entry);
    }
  return rows;
}

/// What stands for a robot in a batch: how long it takes to make, and its memory.
json measureBatch(const NamedRobot& robot, const std::regex& wanted) {
  if (!std::regex_search("batch, " + robot.name, wanted)) return nullptr;
  std::vector<double> seconds;
  std::size_t bytes = 0;
  for (int round = 0; round < kRounds; ++round) {
    const std::size_t before = mallinfo2().uordblks;
    const double start = processorSeconds();
    const SceneBatch batch(robot.model);
    seconds.push_back(processorSeconds() - start);
    bytes = mallinfo2().uordblks - before;
  }
  return {{"robot", robot.name},
          {"links", robot.model->robot.links.size()},
          {"pieces", robot.model->robot.pieces.size()},
          {"seconds", quantile(seconds, 0.5)},
          {"bytes", bytes},
          {"spheres", SphereScene(*robot.model).sphereCount()}};
}

void runOn(int core) {
  cpu_set_t cores;
  CPU_ZERO(&cores);
  CPU_SET(static_cast<unsigned>(core), &cores);
  sched_setaffinity(0, sizeof cores, &cores);  // a wish: where it fails, the thread runs anywhere
}

/// Seconds until each of so many threads, on a core of its own, has answered all states with a twin.
double secondsOf(int threads, SweepQuestion question, const PositionTable& states, const SceneBatch& batch) {
  std::vector<std::unique_ptr<SweepBatch>> twins;
  for (int i = 0; i < threads; ++i) {
    twins.push_back(std::make_unique<SweepBatch>(batch.twin()));
    twins.back()->ask(states.topRows(std::min<Eigen::Index>(kBatch, states.rows())), question);
  }
  const auto start = Clock::now();
  std::vector<std::thread> running;
  for (int i = 0; i < threads; ++i)
    running.emplace_back([&, i] {
      runOn(i);
      for (Eigen::Index first = 0; first < states.rows(); first += kBatch)
        twins[static_cast<std::size_t>(i)]->ask(
            states.middleRows(first, std::min<Eigen::Index>(kBatch, states.rows() - first)), question);
    });
  for (std::thread& thread : running) thread.join();
  return std::chrono::duration<double>(Clock::now() - start).count();
}

/// States per second of two threads, each with as many states as the one alone, over twice those of one.
json measureThreads(const NamedRobot& robot, int states, const std::regex& wanted) {
  json rows = json::array();
  const SceneBatch batch(robot.model);
  const PositionTable positions = randomPositions(robot.model->robot, states);
  for (const SweepQuestion question : {SweepQuestion::AnyBelow, SweepQuestion::Minimum}) {
    const std::string name = question == SweepQuestion::AnyBelow ? "any below 5 cm" : "minimum";
    if (!std::regex_search("threads, " + robot.name + ", " + name, wanted)) continue;
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
                    {"question", name},
                    {"states", count},
                    {"states_per_second", quantile(rates, 0.5)},
                    {"efficiency", quantile(ratios, 0.5)}});
  }
  std::cerr << "." << std::flush;
  return rows;
}

/// What the lanes run with here. The answers do not depend on it.
std::string instructionSet() { return lanes::kernels().name; }

}  // namespace
}  // namespace proximity_server::benchmark

int main(int argc, char** argv) {
  using namespace proximity_server::benchmark;
  CLI::App app{"Time per state of a sweep, beside FCL and spheres"};
  int states = 16 * kBatch;
  app.add_option("--states", states, "most states of each row")
      ->check(CLI::Range(kFewest, 1 << 24))
      ->capture_default_str();
  return benchmarkMain(app, argc, argv, [&](const std::regex& wanted) {
    std::vector<NamedRobot> robots = exampleRobots();
    if (robots.empty()) std::cout << kExampleRobotsMissing << " Panda, UR5 and PR2 are left out.\n";
    robots.push_back(demoRobot());
    nlohmann::json result = {{"instruction_set", instructionSet()}, {"batch", kBatch}};
    result["rows"] = result["threads"] = result["batches"] = nlohmann::json::array();
    for (const NamedRobot& robot : robots) {
      for (const auto& row : measureRobot(robot, states, wanted)) result["rows"].push_back(row);
      for (const auto& row : measureThreads(robot, states, wanted)) result["threads"].push_back(row);
      if (const auto row = measureBatch(robot, wanted); !row.is_null()) result["batches"].push_back(row);
    }
    std::cerr << "\n";
    return result;
  });
}
