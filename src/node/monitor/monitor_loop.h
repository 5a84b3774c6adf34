#pragma once

#include "node/monitor/commanded_trajectories.h"
#include "node/monitor/markers.h"
#include "node/monitor/monitor.h"
#include "node/record/recorder.h"
#include "node/sources/tracked_ages.h"
#include "node/tf/tf_poses.h"
#include "proximity_server/scene/model/kinematics.h"
#include "system/steady_timer.h"

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

namespace proximity_server::node {

/// The state of the monitor, for the diagnostics.
struct MonitorHealth {
  Clearance last;  ///< its `cycle` is 0 before the first cycle
  MonitorSettings settings;
  bool enabled;
  std::string broken;           ///< a text about the inequality that the latest poses break most; "": none
  std::string beyond;           ///< a text about the joint that is farthest beyond its limits, see farthestBeyond()
  ros::Duration slowest_cycle;  ///< since the previous call of MonitorLoop::health(); it includes publishing
};

/// Runs a Monitor in threads of its own, and publishes its results on ~clearance. It also publishes on ~constraints,
/// ~collision_velocity_scale, ~separation with its scale and override, ~sensed and ~markers while these have subscribers.
///
/// A cycle runs at the rate of the settings, in ROS time, or on every new set of transforms if the rate is 0. If
/// neither the clock nor the transforms advance, a wall timer publishes nevertheless: the level is then INVALID,
/// because the age of the poses is unknown. So it is while a tracked source is stale. If the level is INVALID, a
/// warning with the reason is logged from time to
/// time. Thread-safe.
class MonitorLoop {
 public:
  /// Subscribes to trajectories in the namespace of `nh`, and publishes in that of `private_nh`.
  MonitorLoop(const ros::NodeHandle& nh, const ros::NodeHandle& private_nh, TfPoses& tf, const TrackedAges& ages,
              const Config& config, Recorder& recorder);
  ~MonitorLoop();

  /// Begins with the present objects of the robot. Before it no other function may be called.
  void start(const std::shared_ptr<const Robot>& robot);

  void follow(const std::shared_ptr<const Robot>& robot);

  /// Takes the present objects of the robot, which must be the monitored one until this returns. Every message that is
  /// published after the return is about these objects: it waits for the end of a cycle that is running.
  void takeObjects(const Robot& robot);

  void configure(const MonitorSettings& settings);
  void enable();
  void disable();
  MonitorHealth health();

  /// Begins a record, see Recorder::beginSaving().
  bool beginRecord();

 private:
  void setRate(double rate);
  void onTransform();
  void onKeepAlive();
  void cycleIfNew();
  void cycleOfTimer();
  void cycle();
  void publish(const PoseSnapshot& snapshot);
  void publishSeparation(const PoseSnapshot& snapshot, const VelocitySnapshot& velocities, const FrameSnapshot& frames);
  bool isSeparated() const;
  void publishVelocityScale(const PoseSnapshot& snapshot, const VelocitySnapshot& velocities,
                            const FrameSnapshot& frames);
  void publishMarkers(const Clearance& clearance, const scene::BodyPoses& poses);
  visualization_msgs::MarkerArray pieces() const;
  void redrawPieces();
  void sendPieces(const ros::SingleSubscriberPublisher& subscriber);
  void warnIfInvalid(const Clearance& clearance);
  void warnOfPositions(const PoseSnapshot& snapshot);
  PoseSnapshot lookUpWithStoppedClock();
  bool mustCycle() const;
  const PoseSnapshot& lookUp();
  void useNextObjects();
  VelocitySnapshot lookUpVelocities();
  const CommandedMotion& lookUpCommands(const PoseSnapshot& snapshot, const VelocitySnapshot& velocities);
  void listenToCommands();

  TfPoses& tf_;
  const TrackedAges& ages_;
  Recorder& recorder_;
  ros::NodeHandle public_nh_;
  CommandedTrajectories commands_;
  ros::CallbackQueue queue_;
  ros::NodeHandle nh_;
  std::atomic<bool> on_tf_{false};
  std::atomic<bool> wake_pending_{false};
  ros::CallbackInterfacePtr wake_;  // runs a cycle for new transforms, at rate 0
  // True if the cycle for changed objects is requested. With a rate it stays true until the next cycle of the timer,
  // which takes all later changes, so that many changes at most double the number of cycles.
  std::atomic<bool> changed_pending_{false};
  ros::CallbackInterfacePtr changed_;  // runs one cycle for all changes of objects that wait

  // A change hands objects to the cycle, and the cycle hands previous objects back, through the next two members. So
  // neither has to wait for the other. The mutex guards these two.
  std::mutex exchange_mutex_;
  std::unique_ptr<MonitoredObjects> next_;      // the objects for the next cycle
  std::unique_ptr<MonitoredObjects> previous_;  // objects that no cycle needs any more; the next change destroys them

  std::mutex mutex_;  // guards the members from here to the publishers
  Monitor monitor_;
  std::optional<TfLookup> lookup_;           // for the poses of the monitor's robot
  PoseSnapshot stale_;                       // the poses while a tracked source is stale: none
  MonitorHealth health_{};                   // its `last` is not used, because the monitor has it
  bool has_cycled_ = false;                  // true if a cycle ran since the last keep-alive
  ros::SteadyTime next_warning_;             // the earliest time of the next warning about INVALID
  ros::SteadyTime first_scale_until_;        // until then an unknown velocity scale is not published; 0: one was known
  ros::Time last_keep_alive_;                // ROS time of the last keep-alive
  bool clock_stands_still_ = false;          // true if the clock did not advance between the last two keep-alives
  std::optional<ClearanceMarkers> markers_;  // for the monitor's robot; made for the first subscriber

  ros::Publisher clearance_pub_, sensed_pub_;
  ros::Publisher constraints_pub_;
  ros::Publisher velocity_scale_pub_;
  ros::Publisher separation_pub_, separation_scale_pub_, separation_override_pub_;
  ros::Publisher markers_pub_;
  ros::Timer simulated_timer_;  // used with a simulated clock
  ros::WallTimer keep_alive_;
  ros::AsyncSpinner spinner_;
  system::SteadyTimer steady_timer_;  // destroyed first, because it calls cycle()
};

}  // namespace proximity_server::node
