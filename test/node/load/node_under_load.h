#pragma once

#include <proximity_server/Clearance.h>
#include "node/faults/child_process.h"
#include "proximity_server/scene/loading/load_robot_model.h"
#include "proximity_server/scene/query/scene.h"

#include <ros/node_handle.h>
#include <xmlrpcpp/XmlRpcValue.h>

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

namespace proximity_server::node {

using namespace narrowphase;
using namespace scene;

/// The name of the node under load.
inline const std::string kNodeName = "/proximity_server";

/// A robot as the node gets it, and as the library by itself loads it with the node's defaults.
struct TestRobot {
  std::string name;
  std::string urdf, srdf;  ///< the texts
  std::shared_ptr<const SceneModel> model;
};

/// With this mesh tolerance [m], see ModelOptions.
TestRobot demoRobotForNode(double mesh_tolerance = ModelOptions().mesh_tolerance);
/// Panda and PR2; none where the package example-robot-data is not found.
std::vector<TestRobot> exampleRobotsForNode();

/// Puts the descriptions on the parameter server.
void describe(const TestRobot& robot);

/// The node, with these of its parameters, this name and these remappings ("FROM:=TO"). It needs a described robot.
std::unique_ptr<ChildProcess> startNode(const std::map<std::string, XmlRpc::XmlRpcValue>& parameters,
                                        const std::string& name = kNodeName,
                                        const std::vector<std::string>& remappings = {});

/// Whether there is such a service within so many seconds. Unlike roscpp's own wait it says nothing about it.
bool awaitService(const std::string& service, double seconds);

/// Waits for the services of the node.
bool awaitNode(double seconds);

/// How regularly a monitor ran.
struct MonitorTiming {
  double rate = 0.0;  ///< [Hz]
  std::uint64_t cycles = 0;
  std::uint64_t missed = 0;         ///< periods in which none began
  std::vector<double> jitter;       ///< [s] by which the time from one cycle to the next differs from the period
  std::vector<double> computation;  ///< [s]
  std::vector<double> age;          ///< [s] from the stamp of the poses to when their level is here
  /// [s] from the stamp of one cycle's poses to when the next cycle's message is here: what a transform that just
  /// missed the first waits for its level.
  std::vector<double> reaction;
};

/// Listens to ~clearance. When a cycle began is read from its own message, so that the way to us matters to the
/// reaction only. Thread-safe.
class MonitorWatch {
 public:
  explicit MonitorWatch(ros::NodeHandle nh);

  /// Forgets what was until now.
  void start(double rate);
  MonitorTiming timing() const;

 private:
  void onClearance(const Clearance& message);

  mutable std::mutex mutex_;
  MonitorTiming timing_;
  std::uint64_t last_cycle_ = 0;  // 0: none yet
  ros::Time last_begin_;
  ros::Time last_stamp_;
  ros::Subscriber subscriber_;
};

/// A thread that wakes up at the rate of a monitor and does nothing: what it misses is the machine's.
class BareBeat {
 public:
  /// A `realtime_priority` above 0 is SCHED_FIFO, where the system grants it.
  BareBeat(double rate, int realtime_priority);
  ~BareBeat();

  /// Part of the periods until now in which it did not wake up, counted as MonitorTiming::missed is.
  double missed() const;

 private:
  void run(double rate, int realtime_priority);

  std::atomic<bool> ends_{false};
  std::atomic<std::uint64_t> beats_{0}, missed_{0};
  std::thread thread_;  // last: it uses all of the above
};

}  // namespace proximity_server::node
