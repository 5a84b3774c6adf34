#pragma once

#include "node/robot/robot.h"
#include "node/tf/joint_frames.h"
#include "node/tf/joint_velocities.h"
#include "node/tf/tf_poses.h"
#include "proximity_server/scene/answers/commanded_motion.h"
#include "proximity_server/scene/motion/spline_delays.h"

#include <ros/node_handle.h>
#include <trajectory_msgs/JointTrajectory.h>

#include <cstdint>
#include <limits>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

namespace proximity_server::node {

/// The splines of one command of a controller.
struct CommandedSplines : scene::JointSplines {
  std::string topic;
  /// [s] The controller may have begun by so much earlier or later than the splines.
  double begin_error = 0.0;
  /// A commanded joint beyond its limit, where it is the farthest beyond in a segment.
  struct Excess {
    double time;       ///< [s]
    std::string text;  ///< "joint 'elbow' goes to 2.4, and its upper limit is 2.1"
  };
  std::vector<Excess> beyond{};
};

struct CommandedMotion : scene::CommandedMotion {
  std::string text;  ///< for which motion the answer is, or why the commands are not used
};

/// Listens to the trajectories that controllers get, see Config::trajectories, and makes of them the splines that
/// joint_trajectory_controller drives. Thread-safe.
///
/// 1. A command replaces the motion of its joints when it begins: at its stamp, or at once if that is 0 or past. Until
///    then the motion before goes on. One without points ends the motion of the joints it names, or of all that its
///    topic commanded.
/// 2. The splines begin at the state that was commanded until then, if the robot was there, also if it holds the end of
///    a trajectory. Otherwise they begin at the positions of tf and the velocities of joint_states.
/// 3. A robot follows its command with a constant delay of at most SplineDelays::kLargest. It is negative only as far
///    as the controller can have received a command without a stamp before this node: by SplineDelays::kLargestLead.
///    If a controller can have begun at another time, the splines are not exact until the first point of the command.
/// 4. If a joint is farther off than its tracking error with each such delay, the joints of this command keep their
///    velocities. If they have agreed with the splines for SplineDelays::kAgreement, as it says, since the command began,
///    with each possible delay, they follow them; before this they may do either.
/// 5. A controller may refuse a command, such as one of some of its joints only, and a goal may be canceled, which is
///    heard as a command without points. So what was replaced counts beside the command, until the joints follow it. If
///    they followed what was replaced, they do either of both. If more than four were replaced, the last ones count.
/// 6. Joints rest after their last point. When it has passed, they follow no command any more.
class CommandedTrajectories {
 public:
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

  /// The motion of those of `joints` that follow commands; of none while a pose or velocity is not known. It is valid
  /// until the next call, and only one thread may ask. While the same joints follow the same commands, nothing is
  /// allocated.
  const CommandedMotion& lookUp(const std::vector<int>& joints, const PoseSnapshot& poses,
                                const VelocitySnapshot& velocities, const ros::Time& now);

 private:
  using Points = std::vector<scene::TrajectoryPoint>;
  struct Command {
    std::string topic;
    std::vector<int> joints;
    Points points;             ///< empty: the motion ends
    double received = 0.0;     ///< [s]
    double zero = 0.0;         ///< [s] time 0 of the points
    double begin = 0.0;        ///< [s] when the controller takes it
    double begin_error = 0.0;  ///< [s] or earlier or later by this
    double least_delay = 0.0;  ///< [s]
    std::int64_t number = 0;
  };
  struct Driven {
    std::shared_ptr<const CommandedSplines> splines;
    std::vector<int> joints;
    scene::SplineDelays delays;
    std::int64_t number;  ///< of the command
    double begin;         ///< [s] of the command
    bool is_inherited;    ///< the robot has agreed with what these splines go on from
    /// [s] When a later command of these joints begins, which the controller may have refused.
    double replaced = std::numeric_limits<double>::infinity();
  };
  struct Present {
    double time, now;              ///< [s] the stamp of the poses, and the time of the cycle
    const JointValues& positions;  ///< of the joints in question, if they are known
    const PoseSnapshot& poses;
    const VelocitySnapshot& velocities;
  };

  template <class Message, class TrajectoryOf>
  ros::Subscriber subscribed(ros::NodeHandle& nh, const std::string& topic, const std::string& name,
                             const TrajectoryOf& trajectoryOf);
  void forget();
  double secondsAt(const ros::Time& time) const;
  void await(Command command, const ros::Time& stamp, const ros::Time& now);
  static bool isOver(const Driven& driven, const Present& present);
  static bool agreesSince(const Driven& driven, double time, const Present& present);
  static bool isSure(const Driven& driven, const Present& present);
  bool mustBegin(const Command& command) const;
  void begin(const Command& command, const Present& present);
  template <class IsMoved>
  void replaceBy(const Command& command, const IsMoved& isMoved);
  void forgetDriven(const Present& present);
  static bool goesOn(const Command& command, const Driven& before);
  Driven continued(const Command& command, const Driven& before, std::vector<int> joints) const;
  Driven begun(const Command& command, std::vector<int> joints, const Present& present) const;
  static Points::const_iterator firstPoint(const Command& command, double time);
  void addPoints(const Command& command, scene::TrajectoryPoint start, CommandedSplines& splines) const;
  scene::TrajectoryPoint presentState(const Command& command, const Present& present, double time) const;
  void track(Driven& driven, const Present& present);
  double offBy(int joint, double position, double commanded) const;
  double allowed(int joint) const;
  std::string textOfStray(const Driven& driven) const;
  void findBeyond(const std::vector<int>& joints, CommandedSplines& splines) const;
  void findMotion(const Present& present);
  template <class Test>
  bool fitsBeside(const Driven& driven, const Test& isAsked) const;
  bool follow(const Driven& driven, const Present& present, scene::FollowedSplines& followed);

  std::mutex mutex_;  // guards the members from here to the subscribers
  std::shared_ptr<const Robot> robot_;
  std::map<std::string, int> topics_;
  ros::Time epoch_;  // times in seconds count from here
  ros::Time last_now_;
  std::vector<Command> waiting_;  // until they begin
  std::int64_t last_number_ = 0;
  std::int64_t last_begun_ = 0;  // the number of the last command with splines
  std::vector<Driven> driven_;   // of two with the same joint the later one has replaced the other
  JointValues positions_;        // of the last cycle; kept, as measured_, for their memory
  std::vector<scene::MeasuredJoint> measured_;
  CommandedMotion motion_;  // of the last cycle
  std::map<std::string, std::vector<ros::Subscriber>>
      subscribers_;  // destroyed first, because their callbacks use the others
};

/// An actionlib_msgs/GoalID that cancels goals. Which ones it names does not matter: see CommandedTrajectories, 5.
struct TrajectoryActionCancel {};

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
template <>
struct MD5Sum<proximity_server::node::TrajectoryActionCancel> {
  static const char* value() { return "302881f31927c1df708a2dbab0e80ee8"; }
  static const char* value(const proximity_server::node::TrajectoryActionCancel&) { return value(); }
};
template <>
struct DataType<proximity_server::node::TrajectoryActionCancel> {
  static const char* value() { return "actionlib_msgs/GoalID"; }
  static const char* value(const proximity_server::node::TrajectoryActionCancel&) { return value(); }
};
}  // namespace message_traits
namespace serialization {
template <>
struct Serializer<proximity_server::node::TrajectoryActionCancel> {
  template <typename Stream>
  static void read(Stream&, proximity_server::node::TrajectoryActionCancel&) {}
};
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
