#pragma once

#include <ros/callback_queue.h>
#include <ros/callback_queue_interface.h>
#include <ros/node_handle.h>
#include <ros/spinner.h>
#include <visualization_msgs/MarkerArray.h>

#include <atomic>
#include <cstddef>
#include <memory>
#include <mutex>
#include <optional>

#include "node/monitor/markers.h"
#include "node/monitor/monitor.h"
#include "node/tf/tf_poses.h"
#include "proximity_server/scene/model/kinematics.h"
#include "system/steady_timer.h"

namespace proximity_server::node {

/// The state of the monitor, for the diagnostics.
struct MonitorHealth {
  Clearance last;  ///< its `cycle` is 0 before the first cycle
  MonitorSettings settings;
  bool enabled;
  ros::Duration slowest_cycle;  ///< with all that it publishes, since the previous call of MonitorLoop::health()
};

/// Runs a Monitor in threads of its own and publishes its results on ~clearance, and while somebody listens on ~constraints,
/// ~collision_velocity_scale and ~markers.
///
/// A cycle runs at the rate of the settings, in ROS time, or on every new set of transforms if the rate is 0. If
/// neither the clock nor the transforms advance, a wall timer publishes nevertheless; then the age of the poses is
/// unknown, and the level is INVALID, of which a throttled warning tells the cause. Thread-safe.
class MonitorLoop {
 public:
  /// Subscribes to joint_states in the namespace of `nh`, and publishes in that of `private_nh`.
  MonitorLoop(const ros::NodeHandle& nh, const ros::NodeHandle& private_nh, TfPoses& tf,
              const std::shared_ptr<const Robot>& robot);
  ~MonitorLoop();

  void follow(const std::shared_ptr<const Robot>& robot);

  /// Takes the objects that the robot, which it follows, has now: every later message knows them. Waits for the end of a
  /// cycle that runs. The robot must not be replaced meanwhile.
  void takeObjects(const Robot& robot);

  void configure(const MonitorSettings& settings);
  void enable();
  void disable();
  MonitorHealth health();

 private:
  void setRate(double rate);
  void onTransform();
  void onKeepAlive();
  void cycleIfNew();
  void cycle();
  void publish(const PoseSnapshot& snapshot);
  void publishVelocityScale(const PoseSnapshot& snapshot, const VelocitySnapshot& velocities,
                            const FrameSnapshot& frames);
  void publishMarkers(const Clearance& clearance, const scene::BodyPoses& poses);
  visualization_msgs::MarkerArray pieces() const;
  void redrawPieces();
  void sendPieces(const ros::SingleSubscriberPublisher& subscriber);
  void warnIfInvalid(const Clearance& clearance);
  PoseSnapshot lookUpInStandingTime();
  bool isToCycle() const;
  const PoseSnapshot& lookUp();
  void useNextObjects();
  VelocitySnapshot lookUpVelocities();
  bool needsVelocities() const;
  void listenToVelocities();

  TfPoses& tf_;
  JointVelocities velocities_;
  ros::CallbackQueue queue_;
  ros::NodeHandle nh_;
  std::atomic<bool> on_tf_{false};
  std::atomic<bool> wake_pending_{false};
  ros::CallbackInterfacePtr wake_;  // at rate 0, for new transforms
  std::atomic<bool> changed_pending_{false};
  ros::CallbackInterfacePtr changed_;  // at rate 0, for changed objects: one cycle for all that wait

  // Objects go to and fro through these, so that neither a cycle nor a change waits for the other: guards the next two.
  std::mutex exchange_;
  std::unique_ptr<MonitoredObjects> next_;    // for the next cycle
  std::unique_ptr<MonitoredObjects> former_;  // which no cycle needs any more; the next change destroys them

  std::mutex mutex_;  // guards the members from here to the publishers
  Monitor monitor_;
  std::optional<TfLookup> lookup_;           // of the monitor's robot
  MonitorHealth health_{};                   // without `last`, which the monitor has
  bool alive_ = false;                       // a cycle ran since the last keep-alive
  ros::SteadyTime next_warning_;             // not before then is a warning about INVALID logged
  ros::Time kept_alive_at_;                  // ROS time of the last keep-alive
  bool stands_still_ = false;                // the clock did not advance between the last two of them
  std::optional<ClearanceMarkers> markers_;  // of the monitor's robot; made for the first subscriber

  ros::Publisher clearance_pub_;
  ros::Publisher constraints_pub_;
  ros::Publisher velocity_scale_pub_;
  ros::Publisher markers_pub_;
  ros::Timer simulated_timer_;  // used with a simulated clock
  ros::WallTimer keep_alive_;
  ros::AsyncSpinner spinner_;
  system::SteadyTimer steady_timer_;  // destroyed first, as it calls cycle()
};

}  // namespace proximity_server::node
