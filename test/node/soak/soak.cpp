// A long run: the demo's robot in motion, the node, objects that change all the time, clients that ask all services,
// and faults at random. Every answer is checked against the library by itself. Ends with a summary; the exit code is 1
// where anything was wrong. Has its own ROS master, uses only this machine, and leaves nothing running. ./dev soak runs
// it.
#include "node/faults/tf_faults.h"
#include "node/load/moving_robot.h"
#include "node/load/node_under_load.h"
#include "node/load/programs.h"
#include "node/load/raw_calls.h"
#include "node/soak/seeing_node.h"
#include "node/soak/simulated_node.h"
#include "node/soak/soak_client.h"
#include "node/soak/soak_monitor.h"
#include "node/soak/soak_objects.h"
#include "node/soak/soak_record.h"
#include "scene/files.h"
#include "tools/program/options.h"

#include <ros/ros.h>
#include <rosbag/bag.h>
#include <std_srvs/Trigger.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <deque>
#include <filesystem>
#include <iostream>
#include <limits>
#include <optional>
#include <thread>

namespace proximity_server::node {

using namespace narrowphase;
using namespace scene;
namespace {

using Clock = std::chrono::steady_clock;

constexpr double kTfRate = 100.0, kMonitorRate = 100.0;       // [Hz]
constexpr double kMaxTfAge = 0.2;                             // [s]
constexpr AnswerChecks::Levels kLevels{0.05, 0.02, 0.3, 10};  // [m], the node's defaults
constexpr unsigned kClients = 6;
constexpr double kTfRecovery = 2.0;       // [s] promised, from the end of a fault of tf to the right answer
constexpr double kRestart = 20.0;         // [s] promised, from the start of the node to the right answer
constexpr double kRegisteredAgain = 5.0;  // [s] promised, from the return of the master on
constexpr double kLongestAnswer = 30.0;   // [s] a call that takes longer hangs
// The node is killed in the first third of the time only: from then on it is one process. Its memory may grow until
// each of its threads has seen the largest requests, and is compared from the middle of the time on.
constexpr double kShareWithRestarts = 1.0 / 3.0;
constexpr double kMaxGrowth = 32e6;  // [byte]

volatile std::sig_atomic_t interrupted = 0;

double since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }
void sleepFor(double seconds) { std::this_thread::sleep_for(std::chrono::duration<double>(seconds)); }

struct SoakOptions {
  double minutes = 60.0;
  unsigned seed = 1;
  std::string only;  ///< the fault that happens; "": all of them
};

stress::Tally sumOf(const SoakRecord::Tallies& tallies) {
  stress::Tally all;
  for (const auto& [name, tally] : tallies) all.merge(tally);
  return all;
}

void print(const char* what, const SoakRecord::Tallies& tallies, const std::vector<stress::Column>& columns) {
  constexpr int kNameWidth = 20;
  stress::printHead(what, kNameWidth, columns);
  for (const auto& [name, tally] : tallies) {
    stress::Tally row = tally;
    row.family = name;
    stress::printRow(kNameWidth, columns, row);
  }
}

/// The ROS master of the run: its port and its process.
struct Master {
  int port;
  std::unique_ptr<ChildProcess>& process;
};

/// The run.
class Soak {
 public:
  Soak(const SoakOptions& options, const Master& master)
      : options_(options),
        master_(master),
        robot_(demoRobotForNode()),
        simulated_robot_(demoRobotForNode(0.0)),
        motion_(robot_.model->robot),
        monitor_(ros::NodeHandle(), robot_.model, record_, {kMaxTfAge, kLevels}),
        timing_(ros::NodeHandle()),
        chance_(options.seed) {
    std::filesystem::create_directory(records_.path("records"));
    describe(robot_);
    tf_ = std::make_unique<TfStream>(ros::NodeHandle(), kTfRate,
                                     [this](const ros::Time& now) { return motion_.transformsAt(now); });
    startTheNode("user");
    if (!monitor_.awaitRightAnswer(ros::Time::now(), kRestart)) throw std::runtime_error("the node does not start");
    objects_ = std::make_unique<SoakObjects>(robot_.model, record_, options.seed + 1);
    monitor_.follow(objects_.get());
    for (unsigned i = 1; i <= kClients; ++i)
      clients_.emplace_back(robot_.model, *objects_, record_, options.seed + 1000 * i);
    timing_.start(kMonitorRate);
  }

  ~Soak() {
    record_.stop();
    clients_.clear();
    monitor_.follow(nullptr);
    objects_.reset();
    stopProgram(*node_);
  }

  /// Whether all was well.
  bool run() {
    const double duration = 60.0 * options_.minutes;
    sleepFor(std::min(5.0, 0.1 * duration));  // until every client has asked about everything
    memory_at_start_ = memory_settled_ = node_->residentMemory();
    while (since(start_) < duration && !isOver()) {
      may_restart_ = since(start_) < kShareWithRestarts * duration;
      if (since(start_) < 0.5 * duration) memory_settled_ = node_->residentMemory();
      oneFault();
      rest(chance_.between(0.2, 1.5));
    }
    rest(1.0);
    return summary();
  }

 private:
  struct Fault {
    const char* name;
    void (Soak::*happen)();
    enum class Phase : unsigned char { Always, WithRestarts, Later } phase = Phase::Always;
  };

  bool isOver() const { return interrupted != 0 || hangs_ || died_; }

  void startTheNode(const std::string& mesh_cache) {
    node_.reset();
    node_ = startNode({{"rate", kMonitorRate},
                       {"max_tf_age", kMaxTfAge},
                       {"mesh_cache", mesh_cache},
                       {"record_directory", records_.path("records")}});
  }

  /// Waits, and looks meanwhile whether the node still lives and answers.
  void rest(double seconds) {
    for (const Clock::time_point start = Clock::now(); since(start) < seconds && !isOver();) {
      sleepFor(0.05);
      look();
    }
  }

  void look() {
    if (!node_->isRunning()) {
      died_ = true;
      record_.countWrong("node", "it ended by itself, exit code " + std::to_string(node_->exitCode()));
    }
    for (const SoakClient& client : clients_) {
      if (client.calls().waiting() < kLongestAnswer) continue;
      hangs_ = true;
      record_.countWrong(client.calls().service(), "no answer within " + std::to_string(kLongestAnswer) + " s");
    }
    if (since(shown_) < (isatty(STDOUT_FILENO) ? 1.0 : 60.0)) return;
    shown_ = Clock::now();
    showProgress();
  }

  void showProgress() const {
    const stress::Tally answers = sumOf(record_.answers()), faults = sumOf(record_.faults());
    const MonitorTiming timing = timing_.timing();
    const int seconds = static_cast<int>(since(start_));
    std::printf(
        "%s%3d:%02d of %g min  %llu cycles, %llu missed  %.0f right answers, %.0f wrong  %.0f faults  %.1f MB  %-16s%s",
        isatty(STDOUT_FILENO) ? "\r" : "", seconds / 60, seconds % 60, options_.minutes,
        static_cast<unsigned long long>(timing.cycles), static_cast<unsigned long long>(timing.missed),
        answers["right"], answers["wrong"], faults["happened"], 1e-6 * static_cast<double>(node_->residentMemory()),
        fault_name_.c_str(), isatty(STDOUT_FILENO) ? "" : "\n");
    std::fflush(stdout);
  }

  // ---- faults

  /// Faults of other things than tf, of this phase.
  std::vector<Fault> others() const {
    const Fault::Phase left_out = may_restart_ ? Fault::Phase::Later : Fault::Phase::WithRestarts;
    std::vector<Fault> faults = {{"BadModel", &Soak::badModel},
                                 {"Reload", &Soak::reload},
                                 {"DeafSubscriber", &Soak::deafSubscriber},
                                 {"DyingClient", &Soak::dyingClient},
                                 {"StandingClock", &Soak::standingClock},
                                 {"JumpingClock", &Soak::jumpingClock},
                                 {"LoopingClock", &Soak::loopingClock},
                                 {"OverlapThatStays", &Soak::overlapThatStays},
                                 {"BadClouds", &Soak::badClouds},
                                 {"NoRecordFolder", &Soak::noRecordFolder},
                                 {"KilledNode", &Soak::killedNode, Fault::Phase::WithRestarts},
                                 {"UnwritableCache", &Soak::unwritableCache, Fault::Phase::WithRestarts},
                                 // A node that starts after that would not find us: we are not registered any more.
                                 {"DyingMaster", &Soak::dyingMaster, Fault::Phase::Later}};
    faults.erase(
        std::remove_if(faults.begin(), faults.end(), [&](const Fault& fault) { return fault.phase == left_out; }),
        faults.end());
    return faults;
  }

  void oneFault() {
    std::vector<TfFaultKind> of_tf = tfFaults();
    std::vector<Fault> of_others = others();
    if (!options_.only.empty()) {
      const auto leaveOthersOut = [this](auto& faults) {
        faults.erase(std::remove_if(faults.begin(), faults.end(),
                                    [this](const auto& fault) { return fault.name != options_.only; }),
                     faults.end());
      };
      leaveOthersOut(of_tf);
      leaveOthersOut(of_others);
      if (of_tf.empty() && of_others.empty()) return;  // not in this phase
    }
    const auto chosen = static_cast<std::size_t>(chance_.below(static_cast<int>(of_tf.size() + of_others.size())));
    if (chosen < of_tf.size()) return tfFault(of_tf[chosen]);
    const Fault& fault = of_others[chosen - of_tf.size()];
    fault_name_ = fault.name;
    (this->*fault.happen)();
    fault_name_.clear();
  }

  /// Waits until the right answers are back.
  void recover(double patience) {
    const ros::Time moment = ros::Time::now();
    const Clock::time_point start = Clock::now();
    bool right = false;
    while (!right && since(start) < patience && !isOver()) right = monitor_.awaitRightAnswer(moment, 0.1);
    if (isOver()) return;
    record_.countFault(fault_name_, right, since(start));
    if (!right) record_.countWrong(fault_name_, "no right answer within " + std::to_string(patience) + " s");
  }

  void tfFault(const TfFaultKind& kind) {
    const int child = chance_.oneOf(robot_.model->robot.joints).child_link;
    const bool everywhere = chance_.happens(0.3);
    fault_name_ = kind.name;
    const bool misleads = kind.effect == TfEffect::Misleads;
    if (misleads) record_.startMisleading();
    tf_->apply(kind.fault, everywhere ? "" : robot_.model->robot.links[child].name);
    rest(chance_.between(0.05, 3.0 * kMaxTfAge));
    tf_->apply(TfFault::None);
    if (misleads) record_.stopMisleading();
    // The wrong transforms must have gone from tf first.
    if (misleads) rest(0.5);
    recover(kTfRecovery);
    fault_name_.clear();
  }

  /// Calls a service without arguments; `success` is what is expected of it.
  void trigger(const std::string& service, bool success) {
    std_srvs::Trigger trigger;
    const bool answered = ros::service::call(kNodeName + "/" + service, trigger);
    if (!answered || (trigger.response.success != 0) != success) {
      record_.countWrong(service, answered ? trigger.response.message : "the call was lost");
    } else {
      record_.count(service, SoakRecord::Outcome::Right);
    }
  }

  void badModel() {
    const std::string broken[] = {"", "<robot name=", "<robot name='r'><link name='a'/><link name='b'/></robot>",
                                  robot_.urdf.substr(0, robot_.urdf.size() / 2)};
    ros::param::set("/robot_description", chance_.oneOf(broken));
    trigger("reload", false);
    describe(robot_);
    recover(kTfRecovery);
  }

  void reload() {
    trigger("reload", true);
    recover(kTfRecovery);
  }

  /// It subscribes to everything and then never reads again.
  void deafSubscriber() {
    const std::unique_ptr<ChildProcess> subscriber = startOurselves({"--subscribe"});
    rest(1.5);
    subscriber->signal(SIGSTOP);
    rest(3.0);
    recover(kTfRecovery);
  }

  /// It dies in the middle of a call.
  void dyingClient() {
    const std::unique_ptr<ChildProcess> client = startOurselves({"--ask"});
    rest(chance_.between(0.5, 2.0));
    client->signal(SIGKILL);
    recover(kTfRecovery);
  }

  using Recovery = std::optional<double>;  // [s]; none: too late

  Recovery recoveryOf(SimulatedNode& node) {
    const Clock::time_point start = Clock::now();
    if (node.awaitRightAnswer(kTfRecovery)) return since(start);
    record_.countWrong(fault_name_, "no right answer within " + std::to_string(kTfRecovery) + " s");
    return std::nullopt;
  }

  /// `happen` gives the recovery of a second node, which has simulated time.
  template <class Happen>
  void inSimulatedTime(double rate, Happen happen) {
    const double speeds[] = {0.5, 1.0, 2.0};
    SimulatedNode node(simulated_robot_, record_, kLevels, rate, chance_.oneOf(speeds));
    const Recovery recovery = node.awaitRightAnswer(kRestart) ? happen(node) : std::nullopt;
    record_.countFault(fault_name_, recovery.has_value(), recovery.value_or(0.0));
    look();
  }

  double randomRate() {
    const double rates[] = {0.0, 5.0, kMonitorRate, 500.0};
    return chance_.oneOf(rates);
  }

  void standingClock() {
    inSimulatedTime(randomRate(), [this](SimulatedNode& node) {
      return node.staysInvalidWithoutTime(chance_.between(0.0, 2.0)) ? recoveryOf(node) : std::nullopt;
    });
  }

  void jumpingClock() {
    inSimulatedTime(randomRate(), [this](SimulatedNode& node) {
      Recovery recovery = 0.0;
      for (int i = 0; i < 4 && recovery; ++i) {
        node.jump(chance_.between(-100.0, 100.0));
        recovery = recoveryOf(node);
      }
      return recovery;
    });
  }

  /// Its clock is that of a bag that is played again and again.
  void loopingClock() {
    inSimulatedTime(randomRate(), [this](SimulatedNode& node) {
      const double begin = node.now(), length = chance_.between(0.2, 1.5);
      Recovery recovery = 0.0;
      for (int i = 0; i < 5 && recovery; ++i) {
        rest(length);
        node.jump(begin - node.now());
        recovery = recoveryOf(node);
      }
      return recovery;
    });
  }

  void overlapThatStays() {
    constexpr double kRate = 2.5;  // [Hz] the search may take 0.1 s
    inSimulatedTime(kRate, [this](SimulatedNode& node) {
      return node.isNotSlowedByAnOverlapThatStays(chance_, kRestart) ? Recovery(0.0) : std::nullopt;
    });
  }

  /// The cameras of a second node fail, in one way after the other.
  void badClouds() {
    SeeingNode node(record_);
    const Clock::time_point start = Clock::now();
    bool right = node.awaitStop(kRestart);
    for (int i = 0; i < 12 && right && !isOver(); ++i) {
      right = node.fail(chance_, kTfRecovery);
      look();
    }
    if (isOver()) return;
    if (!right) record_.countWrong(fault_name_, "no STOP within " + std::to_string(kTfRecovery) + " s");
    record_.countFault(fault_name_, right, right ? 0.0 : since(start));
  }

  /// The folder of the records goes, and comes back.
  void noRecordFolder() {
    std::filesystem::rename(records_.path("records"), records_.path("away"));
    trigger("save_record", false);
    std::filesystem::rename(records_.path("away"), records_.path("records"));
    trigger("save_record", true);
    recover(kTfRecovery);
  }

  /// A record with its name is whole, also after its node was killed.
  void checkRecords() {
    for (const auto& file : std::filesystem::directory_iterator(records_.path("records"))) {
      if (file.path().extension() != ".bag") continue;
      try {
        const rosbag::Bag bag(file.path());
      } catch (const std::exception& error) {
        record_.countWrong("records", file.path().filename().string() + ": " + error.what());
      }
    }
  }

  void killedNode() { restart("user"); }
  void unwritableCache() { restart("/proc/proximity_server"); }

  /// It comes back with an empty memory; newcomers must find the node again.
  void dyingMaster() {
    master_.process->signal(SIGKILL);
    master_.process->hasEndedWithin(std::chrono::seconds(5));
    rest(chance_.between(0.2, 2.0));
    master_.process = startMasterAt(master_.port);
    describe(robot_);
    if (!awaitNode(kRegisteredAgain)) record_.countWrong(fault_name_, "newcomers do not find the node any more");
    recover(kTfRecovery);
  }

  void restart(const std::string& mesh_cache) {
    record_.nodeGoesDown();
    node_->signal(SIGKILL);
    node_->hasEndedWithin(std::chrono::seconds(5));
    checkRecords();
    sleepFor(0.2);
    startTheNode(mesh_cache);
    recover(kRestart);
    awaitNode(kRestart);
    record_.nodeIsBack();
  }

  // ---- the end

  /// Prints the tables; whether all was well.
  bool summary() {
    record_.stop();
    checkRecords();
    const MonitorTiming timing = timing_.timing();
    const double end = static_cast<double>(node_->residentMemory());
    const double growth = end - static_cast<double>(memory_settled_);
    const stress::Tally answers = sumOf(record_.answers()), faults = sumOf(record_.faults());
    std::printf("\n\n");
    print("answers", record_.answers(),
          {stress::count("right", 10, "right"), stress::count("no tf", 10, "refused"),
           stress::count("misled tf", 10, "misled"), stress::count("lost", 8, "lost"),
           stress::count("wrong", 8, "wrong")});
    std::printf("\n");
    print("faults", record_.faults(),
          {stress::count("happened", 10, "happened"), stress::count("survived", 10, "survived"),
           stress::number("slowest recovery [s]", 22, "%*.2f", "recovery")});
    const bool grown = growth > kMaxGrowth;
    std::printf(
        "\n%.1f min, seed %u: %llu cycles at %g Hz, %llu missed (%.3f %%); %.0f of %.0f faults survived\n",
        since(start_) / 60.0, options_.seed, static_cast<unsigned long long>(timing.cycles), kMonitorRate,
        static_cast<unsigned long long>(timing.missed),
        100.0 * static_cast<double>(timing.missed) / static_cast<double>(std::max<std::uint64_t>(1, timing.cycles)),
        faults["survived"], faults["happened"]);
    std::printf(
        "%.0f right answers, %.0f wrong; memory of the node %.1f MB at the start, %.1f MB in the middle, "
        "%.1f MB at the end%s\n",
        answers["right"], answers["wrong"], 1e-6 * static_cast<double>(memory_at_start_),
        1e-6 * static_cast<double>(memory_settled_), 1e-6 * end, grown ? ": it grows" : "");
    std::fflush(stdout);
    if (hangs_) std::_Exit(1);  // a client that hangs cannot be joined
    return answers["wrong"] == 0.0 && !grown && !died_ && faults["survived"] == faults["happened"];
  }

  const SoakOptions options_;
  const Master master_;
  const TemporaryFiles records_;  ///< with the folder "records" of the node's records
  SoakRecord record_;
  TestRobot robot_, simulated_robot_;  // the other one has exact meshes
  MovingRobot motion_;
  SoakMonitor monitor_;
  MonitorWatch timing_;
  Chance chance_;
  std::unique_ptr<TfStream> tf_;
  std::unique_ptr<ChildProcess> node_;
  std::unique_ptr<SoakObjects> objects_;
  std::deque<SoakClient> clients_;
  std::string fault_name_;
  bool may_restart_ = false, hangs_ = false, died_ = false;
  std::size_t memory_at_start_ = 0, memory_settled_ = 0;  // [byte]
  const Clock::time_point start_ = Clock::now();
  Clock::time_point shown_{};
};

// ---- the parts of this program that faults need

void subscribe() {
  ros::NodeHandle nh;
  const boost::function<void(const boost::shared_ptr<const Clearance>&)> ignore = [](const auto&) {};
  const ros::Subscriber clearance = nh.subscribe(kNodeName + "/clearance", 1, ignore);
  ros::spin();
}

/// As much as is allowed, again and again.
void ask() {
  const ros::NodeHandle keeps_ros_running;
  QueryPairsRequest request;
  request.a.resize(90);
  request.mode = QueryPairsRequest::PER_PAIR;
  const RawRequest bytes = rawRequest(request);
  RawClient client(kNodeName + "/query_pairs", Connection::Persistent);
  while (ros::ok()) client.call(bytes);
}

int soak(int argc, char** argv, const SoakOptions& options) {
  const int port = freePort();
  useMasterAt(port);
  std::unique_ptr<ChildProcess> master = startMasterAt(port);
  ros::init(argc, argv, "soak", ros::init_options::NoSigintHandler);
  for (const int signal : {SIGINT, SIGTERM}) std::signal(signal, [](int) { interrupted = 1; });
  const ros::NodeHandle keeps_ros_running;
  ros::AsyncSpinner spinner(3);
  spinner.start();
  bool well = false;
  {
    Soak run(options, Master{port, master});
    well = run.run();
  }
  spinner.stop();
  ros::shutdown();
  stopProgram(*master);
  if (interrupted) return 130;
  return well ? 0 : 1;
}

}  // namespace
}  // namespace proximity_server::node

int main(int argc, char** argv) {
  using namespace proximity_server::node;
  const std::string part = argc > 1 ? argv[1] : "";
  if (part == "--subscribe" || part == "--ask") {
    ros::init(argc, argv, "part_of_soak", ros::init_options::AnonymousName);
    part == "--ask" ? ask() : subscribe();
    return 0;
  }
  SoakOptions options;
  proximity_server::tools::ProgramOptions program("soak",
                                                  "The node under faults for a long time, every answer checked.");
  addPositive(program, "--minutes", options.minutes, "how long");
  addCount(program, "--seed", options.seed, 0, std::numeric_limits<unsigned>::max(),
           "of the faults and questions (default: 1)");
  program.addText("--only", "FAULT", options.only, "the only fault that happens, as the table at the end names it");
  if (const std::optional<int> exit_code = program.parse(argc, argv)) return *exit_code;
  try {
    return soak(argc, argv, options);
  } catch (const std::exception& error) {
    std::cerr << "soak: " << error.what() << "\n";
    return 1;
  }
}
