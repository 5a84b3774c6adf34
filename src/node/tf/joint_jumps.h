#pragma once

#include "node/robot/robot.h"

#include <geometry_msgs/TransformStamped.h>
#include <Eigen/Geometry>

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace proximity_server::node {

/// Finds joints about which two publishers disagree: their transforms go back and forth faster than the joint can move.
///
/// 1. Compare every transform of a joint with the one before it. If the stamp goes back by much or leaves a long gap,
///    do not compare the two: the clock jumped, or a simulation was restarted.
/// 2. A step is a jump if it is longer than twice the velocity limit allows in the time between the two stamps, plus a
///    tolerance for jitter of the stamps. A joint with a range but without a velocity limit jumps if it crosses half of
///    its range within 50 ms.
/// 3. A single jump proves nothing, because the robot may really be elsewhere. But if a second jump within two seconds
///    leads back to the place before the first one, report the joint until five seconds after the last such jump.
///
/// Floating and planar joints are not monitored, nor are joints with neither a velocity limit nor a range, because a
/// wheel may turn at any speed. Thread-safe.
class JointJumps {
 public:
  using Clock = std::chrono::steady_clock;

  /// Monitors the joints of this robot from now on.
  void watch(const Robot& robot);

  /// Adds a transform of /tf, which has a stamp. Transforms are added in the order of their arrival.
  void add(const geometry_msgs::TransformStamped& transform, Clock::time_point now = Clock::now());

  /// Forgets all transforms, so that the next one of each joint is not compared with an earlier one.
  void forget();

  /// Returns a sentence for each joint that jumped back recently, in the order of the robot's joints.
  std::vector<std::string> recent(Clock::time_point now = Clock::now()) const;

 private:
  struct Sample {
    std::int64_t stamp;      // [ns]
    Eigen::Isometry3d pose;  // parent_T_child
  };
  struct Jump {
    Clock::time_point when;
    Eigen::Isometry3d from;
    double step;  // [rad] or [m]
    double time;  // [s] between the stamps
  };
  struct TrackedJoint {
    scene::Joint::Type type;
    double max_velocity;  // [rad/s] or [m/s]; infinity if the URDF has none
    double range;         // [rad] or [m]; infinity if the URDF has none
    std::string parent;   // frame
    std::string name;     // in the messages
    std::optional<Sample> last;
    std::optional<Jump> jump;                    // the latest jump
    std::optional<Clock::time_point> confirmed;  // time of the latest jump that led back
  };

  static double stepBetween(const TrackedJoint& joint, const Eigen::Isometry3d& a, const Eigen::Isometry3d& b);
  static bool isJump(const TrackedJoint& joint, double step, double time);

  mutable std::mutex mutex_;
  std::vector<TrackedJoint> joints_;
  std::map<std::string, std::size_t, std::less<>> by_child_;  // indices into joints_ by child frame
};

}  // namespace proximity_server::node
