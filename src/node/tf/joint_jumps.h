#pragma once

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

#include "node/robot/robot.h"

namespace proximity_server::node {

/// Finds joints that two publishers disagree about: their transforms go forth and back faster than the joint can move.
///
/// 1. Every transform of a joint is compared with the one before it. Where the stamps go back, or leave a long gap, the
///    clock jumped or a simulation was started again: nothing is compared.
/// 2. A step is a jump where it is longer than twice the velocity limit allows in the time between the two stamps, and
///    a little more, as stamps jitter. A joint with a range but no limit jumps where it crosses half of it in a moment.
/// 3. After one jump the robot may just be elsewhere. Where a second one leads back to where the first began, within
///    two seconds, the joint is reported, until five seconds after the last such jump.
///
/// Not watched: floating and planar joints, and those with neither limit nor range, as wheels and rotors may spin.
/// Thread-safe.
class JointJumps {
 public:
  using Clock = std::chrono::steady_clock;

  /// Watches the joints of this robot from now on.
  void watch(const Robot& robot);

  /// A transform of /tf with a stamp; in the order in which they come.
  void look(const geometry_msgs::TransformStamped& transform, Clock::time_point now = Clock::now());

  /// The next transform of each joint is compared with nothing.
  void forget();

  /// One sentence for each joint that jumps, in the order of the robot's joints.
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
  struct Watched {
    scene::Joint::Type type;
    double max_velocity;  // [rad/s] or [m/s]; infinity where unstated
    double range;         // [rad] or [m]; infinity where there is none
    std::string parent;   // frame
    std::string name;     // for people
    std::optional<Sample> last;
    std::optional<Jump> jump;                    // the latest
    std::optional<Clock::time_point> confirmed;  // the latest of those that led back
  };

  static double stepBetween(const Watched& joint, const Eigen::Isometry3d& a, const Eigen::Isometry3d& b);
  static bool isJump(const Watched& joint, double step, double time);

  mutable std::mutex mutex_;
  std::vector<Watched> joints_;
  std::map<std::string, std::size_t, std::less<>> by_child_;  // frame to index into joints_
};

}  // namespace proximity_server::node
