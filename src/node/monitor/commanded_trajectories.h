#pragma once

#include "node/monitor/joint_velocities.h"
#include "node/robot/robot.h"
#include "node/tf/joint_frames.h"
#include "node/tf/tf_poses.h"
#include "proximity_server/scene/motion/joint_spline.h"

#include <ros/node_handle.h>
#include <trajectory_msgs/JointTrajectory.h>

#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

namespace proximity_server::node {

/// The splines of one command of a controller, in the order of their times [s].
struct CommandedSplines {
  std::string topic;
  std::vector<scene::SplineSegment> segments;  ///< each begins when the one before ends, or later
  /// A commanded joint beyond its limit, where it is the farthest beyond in a segment.
  struct Excess {
    double time;       ///< [s]
    std::string text;  ///< "joint 'elbow' goes to 2.4, and its upper limit is 2.1"
  };
  std::vector<Excess> beyond;

  /// Before the first segment, between two and after the last, the joints rest.
  scene::TrajectoryPoint stateAt(double time) const;
  /// The motion between two times, if no segment begins or ends between them.
  scene::SplineSegment between(double from, double to) const;
};

/// Joints that follow splines.
struct FollowedSplines {
  std::shared_ptr<const CommandedSplines> splines;
  std::vector<int> joints;  ///< indices into RobotModel::joints
  double time;              ///< [s] that of the splines at the stamp of the poses
};

/// The motion of the joints that follow commands, from the time of the poses on.
struct CommandedMotion {
  std::vector<FollowedSplines> followed;  ///< empty: every joint keeps its velocity
  scene::Positions positions;             ///< [rad] or [m] of all joints at the stamp; 0 if a position is not known
  std::vector<double> tracking_error;     ///< [rad] or [m] of all joints
  std::string text;                       ///< for which motion the answer is, or why the commands are not used
};

/// Listens to the trajectories that controllers get, see Config::trajectories, and makes of them the splines that
/// joint_trajectory_controller drives. Thread-safe.
///
/// 1. A command replaces the motion of its joints when it begins: at its stamp, or at once if that is 0 or past. One
///    without points ends the motion of the joints it names, or of all that its topic commanded.
/// 2. The splines begin at the state that was commanded until then, if the robot was there. Otherwise they begin at the
///    positions of tf and the velocities of joint_states.
/// 3. A robot follows its command with a delay. It is the one of at most kLargestDelay, to either side, at which the
///    positions fit best. If a joint is then farther off than its tracking error, no command is used.
/// 4. Joints rest after their last point. When it has passed, they follow no command any more.
class CommandedTrajectories {
 public:
  static constexpr double kLargestDelay = 0.1;  ///< [s]
  /// [rad] or [m] Added to each tracking error: by so much encoders and clocks may be off.
  static constexpr double kResolution = 1e-4;

  /// Subscribes to the topics of this robot, and to no others. Another robot forgets all commands.
  void listen(ros::NodeHandle nh, const std::shared_ptr<const Robot>& robot);

  /// Ends all subscriptions, and forgets all commands.
  void stopListening();

  /// Does the same without subscriptions. `topics` have the robot whose joints they name, or -1 for any of several.
  void follow(const std::shared_ptr<const Robot>& robot, const std::map<std::string, int>& topics);

  /// Takes a command. Returns why it is refused, as by the controller, which keeps the one before; "" if it is not.
  std::string take(const std::string& topic, const trajectory_msgs::JointTrajectory& message, const ros::Time& now);

  /// The motion of those of `joints` that follow commands; of none while a pose or velocity is not known.
  CommandedMotion lookUp(const std::vector<int>& joints, const PoseSnapshot& poses, const VelocitySnapshot& velocities,
                         const ros::Time& now);

 private:
  struct Command {
    std::string topic;
    std::vector<int> joints;
    std::vector<scene::TrajectoryPoint> points;  ///< empty: the motion ends
    double zero = 0.0;                           ///< [s] time 0 of the points
    double begin = 0.0;                          ///< [s] when the controller takes it
  };
  struct Driven {
    std::shared_ptr<const CommandedSplines> splines;
    std::vector<int> joints;
    double delay = 0.0;    ///< [s]
    int stray_joint = -1;  ///< a joint that is too far off the splines, by `off`; -1: none is
    double off = 0.0;
  };
  struct Present {
    double time, now;       ///< [s] the stamp of the poses, and the time of the cycle
    JointValues positions;  ///< of the joints in question, if they are known
    const VelocitySnapshot& velocities;
  };

  void forget();
  double secondsAt(const ros::Time& time) const;
  void await(Command command, const ros::Time& stamp, const ros::Time& now);
  void begin(const Command& command, const Present& present);
  CommandedSplines splinesOf(const Command& command, const Present& present) const;
  scene::TrajectoryPoint presentState(const Command& command, const Present& present, double time) const;
  void track(Driven& driven, const Present& present) const;
  double offBy(int joint, double position, double commanded) const;
  double allowed(int joint) const;
  std::string textOfStray(const Driven& driven) const;
  void findBeyond(const std::vector<int>& joints, CommandedSplines& splines) const;
  CommandedMotion motionFrom(const Present& present) const;

  std::mutex mutex_;  // guards the members from here to the subscribers
  std::shared_ptr<const Robot> robot_;
  std::map<std::string, int> topics_;
  ros::Time epoch_;  // times in seconds count from here
  ros::Time last_now_;
  std::vector<Command> waiting_;                        // until they begin
  std::vector<Driven> driven_;                          // no two have the same joint
  std::map<std::string, ros::Subscriber> subscribers_;  // destroyed first, because their callbacks use the others
};

/// The beginning of a control_msgs/FollowJointTrajectoryActionGoal; Debian does not have control_msgs.
struct TrajectoryActionGoal {
  std_msgs::Header header;
  ros::Time stamp;
  std::string id;
  trajectory_msgs::JointTrajectory trajectory;
};

}  // namespace proximity_server::node

namespace ros {
namespace message_traits {
template <>
struct MD5Sum<proximity_server::node::TrajectoryActionGoal> {
  static const char* value() { return "cff5c1d533bf2f82dd0138d57f4304bb"; }
  static const char* value(const proximity_server::node::TrajectoryActionGoal&) { return value(); }
};
template <>
struct DataType<proximity_server::node::TrajectoryActionGoal> {
  static const char* value() { return "control_msgs/FollowJointTrajectoryActionGoal"; }
  static const char* value(const proximity_server::node::TrajectoryActionGoal&) { return value(); }
};
}  // namespace message_traits
namespace serialization {
template <>
struct Serializer<proximity_server::node::TrajectoryActionGoal> {
  template <typename Stream>
  static void read(Stream& stream, proximity_server::node::TrajectoryActionGoal& goal) {
    stream.next(goal.header);
    stream.next(goal.stamp);
    stream.next(goal.id);
    stream.next(goal.trajectory);
  }
};
}  // namespace serialization
}  // namespace ros
