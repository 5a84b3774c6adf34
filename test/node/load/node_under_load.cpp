#include "node/load/node_under_load.h"

#include "node/load/programs.h"
#include "node/patience.h"
#include "node/threads/grants_real_time.h"
#include "proximity_server/scene/pieces/convex_pieces.h"
#include "scene/example_robots.h"

#include <ros/param.h>
#include <ros/service.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <thread>

namespace proximity_server::node {

using namespace narrowphase;
using namespace scene;
namespace {

const std::string kDemo = PROXIMITY_SOURCE_DIR "/config/demo/robot";

TestRobot robotFrom(const std::string& name, const std::string& urdf_file, const std::string& srdf_file,
                    const MeshResolver& resolve, ModelOptions options = {}) {
  TestRobot robot{name, readFile(urdf_file), readFile(srdf_file), nullptr};
  options.mesh_cache = userMeshCache();
  auto model = std::make_shared<SceneModel>();
  model->robot = loadRobotModel(robot.urdf, resolve, options);
  model->pairs = filterPairs(model->robot, robot.srdf);
  robot.model = model;
  return robot;
}

}  // namespace

TestRobot demoRobotForNode(double mesh_tolerance) {
  ModelOptions options;
  options.mesh_tolerance = mesh_tolerance;
  return robotFrom("demo", kDemo + ".urdf", kDemo + ".srdf", packageResolver(rosPackagePath()), options);
}

std::vector<TestRobot> exampleRobotsForNode() {
  const MeshResolver resolve = exampleRobotsResolver();
  std::vector<TestRobot> robots;
  if (!findsExampleRobots(resolve)) return robots;
  for (const ExampleRobot& robot : kExampleRobots) {
    if (robot.name == std::string("Ur5")) continue;
    robots.push_back(
        robotFrom(robot.name, exampleRobotFile(resolve, robot.urdf), exampleRobotFile(resolve, robot.srdf), resolve));
  }
  return robots;
}

void describe(const TestRobot& robot) {
  ros::param::set("/robot_description", robot.urdf);
  ros::param::set("/robot_description_semantic", robot.srdf);
}

std::unique_ptr<ChildProcess> startNode(const std::map<std::string, XmlRpc::XmlRpcValue>& parameters,
                                        const std::string& name, const std::vector<std::string>& remappings) {
  ros::param::del(name);
  for (const auto& [parameter, value] : parameters) ros::param::set(name + "/" + parameter, value);
  std::vector<std::string> command = {NODE_EXECUTABLE, "__name:=" + name.substr(1)};
  command.insert(command.end(), remappings.begin(), remappings.end());
  return startProgram(command);
}

bool awaitService(const std::string& service, double seconds) {
  return holdsWithin(std::chrono::duration<double>(seconds),
                     [&] { return ros::service::exists(service, /*print_failure_reason=*/false); });
}

bool awaitNode(double seconds) {
  // The last one that it advertises.
  return awaitService(kNodeName + "/enable_monitor", seconds);
}

MonitorWatch::MonitorWatch(ros::NodeHandle nh)
    : subscriber_(nh.subscribe(kNodeName + "/clearance", 10000, &MonitorWatch::onClearance, this,
                               ros::TransportHints().tcpNoDelay())) {}

void MonitorWatch::start(double rate) {
  const std::lock_guard<std::mutex> lock(mutex_);
  timing_ = {};
  timing_.rate = rate;
  last_cycle_ = 0;
}

MonitorTiming MonitorWatch::timing() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return timing_;
}

void MonitorWatch::onClearance(const Clearance& message) {
  if (message.header.stamp.isZero()) return;  // tf has nothing: the message does not tell when it was made
  const std::lock_guard<std::mutex> lock(mutex_);
  const ros::Time begin = message.header.stamp + message.tf_age;
  if (timing_.rate > 0.0 && last_cycle_ > 0 && message.cycle > last_cycle_) {
    const double elapsed = (begin - last_begin_).toSec();
    const std::uint64_t cycles = message.cycle - last_cycle_;  // more than 1 where messages were lost on their way
    timing_.cycles += cycles;
    timing_.missed +=
        static_cast<std::uint64_t>(std::max(0.0, std::round(elapsed * timing_.rate) - static_cast<double>(cycles)));
    if (cycles == 1) timing_.jitter.push_back(std::abs(elapsed - 1.0 / timing_.rate));
    timing_.computation.push_back(message.computation_time.toSec());
    const ros::Time now = ros::Time::now();
    timing_.age.push_back((now - message.header.stamp).toSec());
    timing_.reaction.push_back((now - last_stamp_).toSec());
  }
  last_cycle_ = message.cycle;
  last_begin_ = begin;
  last_stamp_ = message.header.stamp;
}

BareBeat::BareBeat(double rate, int realtime_priority)
    : thread_([this, rate, realtime_priority] { run(rate, realtime_priority); }) {}

BareBeat::~BareBeat() {
  ends_ = true;
  thread_.join();
}

double BareBeat::missed() const {
  return static_cast<double>(missed_) / static_cast<double>(std::max<std::uint64_t>(1, beats_ + missed_));
}

void BareBeat::run(double rate, int realtime_priority) {
  using Clock = std::chrono::steady_clock;
  if (realtime_priority > 0) takeRealTimePriority(realtime_priority);
  const auto period = std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(1.0 / rate));
  Clock::time_point next = Clock::now() + period, last = Clock::now();
  while (!ends_) {
    std::this_thread::sleep_until(next);
    const Clock::time_point now = Clock::now();
    next += period * (1 + (now - next) / period);
    ++beats_;
    const double elapsed = std::chrono::duration<double>(now - last).count();
    missed_ += static_cast<std::uint64_t>(std::max(0.0, std::round(elapsed * rate) - 1.0));
    last = now;
  }
}

}  // namespace proximity_server::node
