// The node under load: clients in processes of their own call each service while tf streams at 1 kHz and the monitor
// runs, beside a service that does nothing but send as many bytes; a batch of 1000 pairs beside its own computation;
// how long a changed object needs to its level; and how regularly the monitor runs on larger robots. Where the system
// grants it, what sends transforms and objects and what receives levels is real-time, so that the times are the node's.
// An echo that is not shows what any other process needs. Has its own ROS master. ./dev bench node runs it.
#include <proximity_server/FirstContact.h>
#include <proximity_server/MinimumDistance.h>
#include <proximity_server/PenetrationDepth.h>
#include <proximity_server/QueryConfiguration.h>
#include <proximity_server/QueryPairs.h>
#include <proximity_server/QueryTrajectory.h>
#include <proximity_server/SeparationAxis.h>
#include "benchmark/benchmark_main.h"
#include "benchmark/echo_times.h"
#include "benchmark/object_levels.h"
#include "benchmark/timing.h"
#include "node/faults/tf_faults.h"
#include "node/load/client_process.h"
#include "node/load/moving_robot.h"
#include "node/load/node_under_load.h"
#include "node/load/programs.h"
#include "node/threads/grants_real_time.h"
#include "proximity_server/scene/loading/load_robot_model.h"
#include "proximity_server/scene/model/kinematics.h"
#include "scene/posed_scene.h"
#include "system/process.h"

#include <ros/ros.h>
#include <nlohmann/json.hpp>

#include <future>
#include <iostream>
#include <thread>

namespace proximity_server::benchmark {

using namespace narrowphase;
using namespace scene;
using namespace node;
namespace {

using nlohmann::json;
using Seconds = std::ratio<1>;

constexpr double kTfRate = 1000.0;      // [Hz]
constexpr double kMonitorRate = 250.0;  // [Hz] while services are measured
constexpr std::size_t kBatch = 1000;    // pairs
constexpr std::size_t kClientsBesideTheMonitor = 16;
constexpr double kChangesPerSecond = 1000.0;
constexpr int kRealtimePriority = 50;
constexpr int kMeasuringPriority = 90;  // of what sends to the node and receives from it
constexpr double kPatience = 120.0;     // [s] for a node that reads its meshes
const std::string kPadding = "/padding";
const std::vector<std::pair<const char*, double>> kDelayShares = {{"median", 0.5}, {"p99", 0.99}, {"worst", 1.0}};

struct BenchmarkOptions {
  double seconds = 0.4;           // of one measurement of one server, twice
  double monitor_seconds = 10.0;  // of one rate of the monitor
};

// ---- questions

struct NamedRequest {
  std::string service;
  RawRequest request;
};

std::string nameOf(const RobotModel& robot, int link) { return robot.links[link].name; }

proximity_server::ShapeRef shape(const RobotModel& robot, int link) {
  proximity_server::ShapeRef ref;
  ref.link = nameOf(robot, link);
  return ref;
}

/// Returns a request about one pair, the middle one of those that are checked.
template <class Request>
Request onePair(const SceneModel& model) {
  const std::size_t middle = model.pairs.checked.size() / 2;
  const LinkPair& pair = model.pairs.pairs[model.pairs.checked[middle]];
  Request request;
  request.a = shape(model.robot, pair.link_a);
  request.b = shape(model.robot, pair.link_b);
  return request;
}

QueryTrajectoryRequest trajectory(const MovingRobot& robot) {
  QueryTrajectoryRequest request;
  for (const double time : {0.0, 1.0}) {
    const sensor_msgs::JointState state = robot.jointStateAt(ros::Time(1.0 + time));
    trajectory_msgs::JointTrajectoryPoint point;
    point.positions = state.position;
    point.time_from_start = ros::Duration(time);
    request.trajectory.joint_names = state.name;
    request.trajectory.points.push_back(point);
  }
  return request;
}

FirstContactRequest contact(const MovingRobot& robot) {
  FirstContactRequest request;
  request.joints = robot.jointStateAt(ros::Time(1.0));
  request.joints.velocity.assign(request.joints.name.size(), 0.2);
  request.horizon = 1.0;
  return request;
}

QueryConfigurationRequest configurations(const MovingRobot& robot, std::size_t states) {
  QueryConfigurationRequest request;
  for (std::size_t i = 0; i < states; ++i)
    request.states.push_back(robot.jointStateAt(ros::Time(1.0 + 0.1 * static_cast<double>(i))));
  request.missing_joints = QueryConfigurationRequest::ZERO;
  return request;
}

std::vector<NamedRequest> everyService(const SceneModel& model) {
  const MovingRobot robot(model.robot);
  return {{"minimum_distance", rawRequest(onePair<MinimumDistanceRequest>(model))},
          {"separation_axis", rawRequest(onePair<SeparationAxisRequest>(model))},
          {"penetration_depth", rawRequest(onePair<PenetrationDepthRequest>(model))},
          {"query_pairs", rawRequest(QueryPairsRequest())},
          {"query_configuration", rawRequest(configurations(robot, 1))},
          {"time_of_contact", rawRequest(contact(robot))},
          {"query_trajectory", rawRequest(trajectory(robot))}};
}

/// Returns kBatch pairs: the checked ones, over and over.
std::vector<ShapeRefPair> batchOfPairs(const SceneModel& model) {
  std::vector<ShapeRefPair> pairs;
  for (std::size_t i = 0; i < kBatch; ++i) {
    const int row = model.pairs.checked[i % model.pairs.checked.size()];
    const LinkPair& pair = model.pairs.pairs[row];
    pairs.push_back({{pair.link_a}, {pair.link_b}});
  }
  return pairs;
}

// ---- figures

/// Adds quantiles of times [s] in microseconds, under names that begin with `name`.
void addQuantiles(json& figures, const std::string& name, const std::vector<double>& seconds,
                  const std::vector<std::pair<const char*, double>>& shares) {
  for (const auto& [share_name, share] : shares) figures[name + share_name + "_us"] = 1e6 * quantile(seconds, share);
}

json figures(const Calls& calls, double seconds) {
  const std::vector<double> times(calls.seconds.begin(), calls.seconds.end());
  json figures = {
      {"calls", times.size()}, {"failed", calls.failed}, {"per_second", static_cast<double>(times.size()) / seconds}};
  addQuantiles(figures, "", times, {{"median", 0.5}, {"p99", 0.99}, {"p999", 0.999}});
  return figures;
}

json figures(const MonitorTiming& timing) {
  json figures = {{"rate", timing.rate}, {"cycles", timing.cycles}, {"missed", timing.missed}};
  addQuantiles(figures, "jitter_", timing.jitter, {{"median", 0.5}, {"p99", 0.99}, {"p999", 0.999}});
  addQuantiles(figures, "computation_", timing.computation, {{"median", 0.5}, {"p999", 0.999}});
  addQuantiles(figures, "age_", timing.age, kDelayShares);
  addQuantiles(figures, "reaction_", timing.reaction, {{"median", 0.5}, {"p999", 0.999}, {"worst", 1.0}});
  return figures;
}

void add(Calls& all, const Calls& more) {
  all.seconds.insert(all.seconds.end(), more.seconds.begin(), more.seconds.end());
  all.failed += more.failed;
}

// ---- the processes

/// The node with one robot, and the stream of tf that moves it.
class Stage {
 public:
  Stage(const TestRobot& robot, double rate, int realtime_priority = 0) : robot_(robot) {
    describe(robot_);
    stream_ = startOurselves({"--stream"});
    // The poses may be as old as a busy machine makes them; what is measured here is time.
    node_ = startNode({{"rate", rate}, {"max_tf_age", 5.0}, {"realtime_priority", realtime_priority}});
    if (!awaitNode(kPatience)) throw std::runtime_error("the node does not start with " + robot.name);
    const RawRequest every_pair = rawRequest(QueryPairsRequest());
    RawClient client(kNodeName + "/query_pairs", Connection::Persistent);
    for (int n = 0; n < 100; ++n) {
      const auto response = client.call(every_pair);
      if (response && isSuccess(*response)) return;
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
    }
    throw std::runtime_error("the node has no answers for " + robot.name);
  }
  ~Stage() {
    stopProgram(*node_);
    stopProgram(*stream_);
  }
  Stage(const Stage&) = delete;
  Stage& operator=(const Stage&) = delete;

  const TestRobot& robot() const { return robot_; }
  double megabytes() const { return 1e-6 * static_cast<double>(node_->residentMemory()); }

 private:
  const TestRobot& robot_;
  std::unique_ptr<ChildProcess> stream_, node_;
};

/// All measurements.
class NodeBenchmark {
 public:
  NodeBenchmark(const BenchmarkOptions& options, Wanted wanted)
      : options_(options), wanted_(std::move(wanted)), watch_(ros::NodeHandle()) {
    padding_ = startOurselves({"--padding"});
    echo_ = startOurselves({"--echo"});
    if (!awaitService(kPadding, kPatience)) throw std::runtime_error("the empty service does not start");
  }

  void run() {
    const TestRobot demo = demoRobotForNode();
    {
      const Stage stage(demo, kMonitorRate);
      measureServices(stage);
      measureBatches(stage);
      measureObjects(stage);
    }
    for (const TestRobot& robot : exampleRobotsForNode()) {
      const double rate = robot.name == "Panda" ? 1000.0 : 500.0;
      measureMonitor(robot, rate, 0);
      if (grantsRealTime()) measureMonitor(robot, rate, kRealtimePriority);
    }
  }

  json result() const {
    return {{"cores", std::thread::hardware_concurrency()},
            {"tf_rate", kTfRate},
            {"services", services_},
            {"batches", batches_},
            {"objects", objects_},
            {"monitors", monitors_}};
  }

 private:
  bool isWanted(const std::string& row) const {
    if (!wanted_(row)) return false;
    std::cout << row << std::endl;
    return true;
  }

  ClientProcesses& clients(std::size_t count) {
    if (!clients_ || clients_->size() < count) {
      clients_.reset();
      clients_ = std::make_unique<ClientProcesses>(count);
    }
    return *clients_;
  }

  void measureServices(const Stage& stage) {
    for (const NamedRequest& request : everyService(*stage.robot().model))
      for (const Connection connection : {Connection::Persistent, Connection::OnePerCall})
        for (const std::size_t count : {std::size_t{1}, std::size_t{4}, std::size_t{16}, std::size_t{64}})
          measureService(stage, request, connection, count);
  }

  void measureService(const Stage& stage, const NamedRequest& asked, Connection connection, std::size_t count) {
    const std::string kept = connection == Connection::Persistent ? "persistent" : "one per call";
    if (!isWanted(asked.service + ", " + std::to_string(count) + " clients, " + kept)) return;
    const std::string service = kNodeName + "/" + asked.service;
    const auto response = RawClient(service, Connection::OnePerCall).call(asked.request);
    if (!response || !isSuccess(*response)) throw std::runtime_error(service + " has no answer");
    const RawRequest empty = paddingRequest(asked.request, response->num_bytes);

    Calls ours, padding;
    watch_.start(kMonitorRate);
    for (int round = 0; round < 2; ++round) {
      add(ours,
          clients(count).call(std::vector<Calling>(count, {service, connection, asked.request}), options_.seconds));
      add(padding, clients(count).call(std::vector<Calling>(count, {kPadding, connection, empty}), options_.seconds));
    }
    services_.push_back({{"service", asked.service},
                         {"clients", count},
                         {"connection", kept},
                         {"request_bytes", asked.request.size()},
                         {"response_bytes", response->num_bytes},
                         {"ours", figures(ours, 2.0 * options_.seconds)},
                         {"empty", figures(padding, 2.0 * options_.seconds)},
                         {"monitor", figures(watch_.timing())},
                         {"memory_mb", stage.megabytes()}});
  }

  void measureBatches(const Stage& stage) {
    const SceneModel& model = *stage.robot().model;
    const std::vector<ShapeRefPair> pairs = batchOfPairs(model);
    QueryPairsRequest listed;
    for (const ShapeRefPair& pair : pairs) {
      listed.a.push_back(shape(model.robot, pair.a.link()));
      listed.b.push_back(shape(model.robot, pair.b.link()));
    }
    listed.mode = QueryPairsRequest::PER_PAIR;
    measureBatch("query_pairs, 1000 pairs", "query_pairs", rawRequest(listed), [&](const ros::SerializedMessage& raw) {
      const auto response = fromRaw<QueryPairsResponse>(raw);
      return computation(model, {MovingRobot(model.robot).positionsAt(response.header.stamp)}, pairs);
    });

    const std::size_t states = (kBatch + model.pairs.checked.size() - 1) / model.pairs.checked.size();
    QueryConfigurationRequest configuration = configurations(MovingRobot(model.robot), states);
    configuration.mode = QueryConfigurationRequest::PER_PAIR;
    const std::vector<ShapeRefPair> candidates = PosedScene(stage.robot().model).candidates().list();
    std::vector<std::vector<double>> positions;
    for (const sensor_msgs::JointState& state : configuration.states)
      positions.push_back(MovingRobot(model.robot).positionsAt(state.header.stamp));
    measureBatch("query_configuration, all pairs in " + std::to_string(states) + " states", "query_configuration",
                 rawRequest(configuration),
                 [&](const ros::SerializedMessage&) { return computation(model, positions, candidates); });
  }

  /// Returns how long [s] the library takes for the answers.
  double computation(const SceneModel& model, const std::vector<std::vector<double>>& states,
                     const std::vector<ShapeRefPair>& pairs) {
    if (!scene_) scene_ = std::make_unique<PosedScene>(std::make_shared<const SceneModel>(model));
    std::vector<BodyPoses> poses;
    for (const std::vector<double>& state : states) poses.push_back(forwardKinematics(model.robot, state));
    return timeOf<Seconds>([&] {
      for (const BodyPoses& each : poses) {
        scene_->update(each);
        scene_->all(pairs);
      }
    });
  }

  /// The calls are those of a client process: in this one the poll thread of roscpp is real-time, and would keep the
  /// caller, whose answers it reads, from the processor.
  template <class Compute>
  void measureBatch(const std::string& row, const std::string& service, const RawRequest& request, Compute compute) {
    if (!isWanted("batch: " + row)) return;
    const std::string name = kNodeName + "/" + service;
    RawClient client(name, Connection::Persistent);
    Calls ours, padding;
    std::vector<double> computations;
    std::size_t response_bytes = 0;
    for (int round = 0; round < 10; ++round) {
      for (int state = 0; state < 20; ++state) {
        const auto response = client.call(request);
        if (!response || !isSuccess(*response)) throw std::runtime_error(service + " has no answer to a batch");
        response_bytes = response->num_bytes;
        computations.push_back(compute(*response));
      }
      const RawRequest empty = paddingRequest(request, response_bytes);
      add(ours, clients(1).call({{name, Connection::Persistent, request}}, options_.seconds));
      add(padding, clients(1).call({{kPadding, Connection::Persistent, empty}}, options_.seconds));
    }
    const std::vector<double> round_trips(ours.seconds.begin(), ours.seconds.end());
    const std::vector<double> empties(padding.seconds.begin(), padding.seconds.end());
    json figures = {{"batch", row},
                    {"calls", round_trips.size()},
                    {"request_bytes", request.size()},
                    {"response_bytes", response_bytes},
                    {"round_trip_us", 1e6 * medianOf(round_trips)},
                    {"computation_us", 1e6 * medianOf(computations)},
                    {"empty_us", 1e6 * medianOf(empties)}};
    addQuantiles(figures, "round_trip_", round_trips, {{"p99", 0.99}});
    batches_.push_back(figures);
  }

  /// Returns the calls of some clients, to all services by turns.
  static std::vector<Calling> everythingFrom(std::size_t clients, const SceneModel& model) {
    const std::vector<NamedRequest> requests = everyService(model);
    std::vector<Calling> tasks;
    for (std::size_t i = 0; i < clients; ++i) {
      const NamedRequest& asked = requests[i % requests.size()];
      tasks.push_back({kNodeName + "/" + asked.service, Connection::Persistent, asked.request});
    }
    return tasks;
  }

  /// Measures the time from the message with an object to its level, with and without clients and other objects that
  /// change.
  void measureObjects(const Stage& stage) {
    for (const std::size_t count : {std::size_t{0}, kClientsBesideTheMonitor}) {
      for (const double changes : {0.0, kChangesPerSecond}) {
        if (!isWanted("objects: " + std::to_string(static_cast<int>(changes)) + " other changes/s, " +
                      std::to_string(count) + " clients"))
          continue;
        const std::vector<Calling> tasks = everythingFrom(count, *stage.robot().model);
        ClientProcesses& callers = clients(kClientsBesideTheMonitor);
        ObjectLevels levels{ros::NodeHandle()};
        const double seconds = 10.0 * options_.seconds;
        EchoTimes echo{ros::NodeHandle()};
        watch_.start(kMonitorRate);
        std::future<Calls> calls = std::async(std::launch::async, [&] { return callers.call(tasks, seconds); });
        auto echoes = std::async(std::launch::async, [&] { return echo.measure(seconds); });
        const std::vector<double> times = levels.measure(seconds, changes);
        const Calls done = calls.get();
        json figures = {{"clients", count},
                        {"changes_per_second", changes},
                        {"messages", times.size()},
                        {"calls", benchmark::figures(done, seconds)},
                        {"monitor", benchmark::figures(watch_.timing())},
                        {"memory_mb", stage.megabytes()}};
        addQuantiles(figures, "to_level_", times, kDelayShares);
        addQuantiles(figures, "echo_", echoes.get(), kDelayShares);
        objects_.push_back(figures);
      }
    }
  }

  /// Measures the monitor without clients, and with many that call all services as fast as they can.
  void measureMonitor(const TestRobot& robot, double rate, int realtime_priority) {
    const std::string row = robot.name + " at " + std::to_string(static_cast<int>(rate)) + " Hz" +
                            (realtime_priority > 0 ? ", real-time" : "");
    if (!isWanted(row)) return;
    const Stage stage(robot, rate, realtime_priority);
    for (const std::size_t count : {std::size_t{0}, kClientsBesideTheMonitor}) {
      const std::vector<Calling> tasks = everythingFrom(count, *robot.model);
      ClientProcesses& callers = clients(kClientsBesideTheMonitor);
      const BareBeat bare(rate, realtime_priority);
      EchoTimes echo{ros::NodeHandle()};
      watch_.start(rate);
      auto echoes = std::async(std::launch::async, [&] { return echo.measure(options_.monitor_seconds); });
      if (tasks.empty()) std::this_thread::sleep_for(std::chrono::duration<double>(options_.monitor_seconds));
      const Calls calls = callers.call(tasks, options_.monitor_seconds);
      json row_figures = {{"robot", robot.name},
                          {"realtime_priority", realtime_priority},
                          {"bare_missed", bare.missed()},
                          {"clients", count},
                          {"calls", figures(calls, options_.monitor_seconds)},
                          {"monitor", figures(watch_.timing())},
                          {"memory_mb", stage.megabytes()}};
      addQuantiles(row_figures, "echo_", echoes.get(), kDelayShares);
      monitors_.push_back(row_figures);
    }
  }

  BenchmarkOptions options_;
  Wanted wanted_;
  MonitorWatch watch_;
  std::unique_ptr<ChildProcess> padding_, echo_;
  std::unique_ptr<ClientProcesses> clients_;
  std::unique_ptr<PosedScene> scene_;
  json services_ = json::array(), batches_ = json::array(), objects_ = json::array(), monitors_ = json::array();
};

// ---- the parts of this program

void servePadding() {
  ros::NodeHandle nh;
  const ros::ServiceServer server = advertisePadding(nh, kPadding);
  ros::AsyncSpinner spinner(4);
  spinner.start();
  ros::waitForShutdown();
}

void stream() {
  ros::NodeHandle nh;
  std::string urdf;
  ros::param::get("/robot_description", urdf);
  ModelOptions without_meshes;
  without_meshes.allow_missing_meshes = true;
  const RobotModel model = loadRobotModel(urdf, packageResolver({}), without_meshes);
  const MovingRobot robot(model);
  const TfStream tf(nh, kTfRate, [&](const ros::Time& now) { return robot.transformsAt(now); });
  ros::spin();
}

int playPart(int argc, char** argv) {
  const std::string part = argv[1];
  if (part == "--stream") takeRealTimePriority(kMeasuringPriority);
  if (part == "--echo") system::requestShortTimeSlices();
  ros::init(argc, argv, "part_of_benchmark", ros::init_options::AnonymousName);
  if (part == "--client") {
    const ros::NodeHandle keeps_ros_running;
    runClient(std::stoi(argv[2]), std::stoi(argv[3]));
  }
  if (part == "--padding") servePadding();
  if (part == "--stream") stream();
  if (part == "--echo") serveEcho();
  return 0;
}

json measure(int argc, char** argv, const BenchmarkOptions& options, const Wanted& wanted) {
  const int port = freePort();
  useMasterAt(port);
  const std::unique_ptr<ChildProcess> master = startMasterAt(port);
  takeRealTimePriority(kMeasuringPriority);  // for the threads of roscpp, which inherit it
  ros::init(argc, argv, "node_benchmark", ros::init_options::NoSigintHandler);
  const ros::NodeHandle keeps_ros_running;
  ros::AsyncSpinner spinner(1);
  spinner.start();
  giveUpRealTimePriority();  // so that neither the node nor its clients inherit it
  NodeBenchmark benchmark(options, wanted);
  benchmark.run();
  spinner.stop();
  ros::shutdown();
  return benchmark.result();
}

}  // namespace
}  // namespace proximity_server::benchmark

int main(int argc, char** argv) {
  using namespace proximity_server::benchmark;
  const std::string first = argc > 1 ? argv[1] : "";
  for (const char* const part : {"--client", "--padding", "--stream", "--echo"})
    if (first == part) return playPart(argc, argv);
  BenchmarkOptions options;
  proximity_server::tools::ProgramOptions program("node_benchmark", "The node under load");
  addPositive(program, "--seconds", options.seconds, "of one measurement");
  addPositive(program, "--monitor-seconds", options.monitor_seconds, "of one rate of the monitor");
  return benchmarkMain(program, argc, argv, [&](const Wanted& wanted) { return measure(argc, argv, options, wanted); });
}
