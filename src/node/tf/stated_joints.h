#pragma once

#include "node/robot/robot.h"

#include <ros/time.h>
#include <sensor_msgs/JointState.h>
#include <Eigen/Geometry>

#include <limits>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

namespace proximity_server::node {

/// The latest positions and velocities in joint_states, or in the topics that the parameter `robots` names. Several
/// publishers may each publish some of the joints, or one of the two only. If there are several robots, a message may
/// name a joint as the model does, "left/elbow", or as the URDF does, "elbow", unless another robot on the same topic
/// has a joint of this name, too. Joints that no robot has are ignored. Allocates only in follow(). Thread-safe.
class StatedJoints {
 public:
  /// The latest number of a joint, NaN before the first one, with the stamp of its message.
  struct Number {
    double value = std::numeric_limits<double>::quiet_NaN();
    ros::Time stamp;

    /// Returns whether it is finite, and its stamp is within `max_age` [s] of a time.
    bool isFresh(const ros::Time& time, double max_age) const;
  };
  struct Entry {
    Number position, velocity;  ///< [rad] or [m], [rad/s] or [m/s]
  };

  /// Listens to the joints of this robot, and forgets all others. Before this there are none.
  void follow(const Robot& robot);

  /// Adds a message. Velocities, or positions, that are not as many as the names do not count: many publishers leave the
  /// velocities empty.
  void add(const sensor_msgs::JointState& state, const std::string& topic);

  using Entries = std::map<std::string, std::shared_ptr<Entry>>;  ///< by each name that messages may give a joint

  /// The state between two messages. No message is added while a view exists.
  class View {
   public:
    /// The numbers of a joint; nullptr if the robot that is listened to has no such joint on its topic.
    const Entry* find(const Robot& robot, int joint) const;

   private:
    friend class StatedJoints;
    explicit View(const StatedJoints& joints) : lock_(joints.mutex_), latest_(joints.latest_) {}

    std::unique_lock<std::mutex> lock_;
    const std::map<std::string, Entries>& latest_;
  };
  View view() const { return View(*this); }

 private:
  mutable std::mutex mutex_;
  std::map<std::string, Entries> latest_;  // by full name of the topic
};

/// The topic on which the joint of a robot is expected.
const std::string& topicOf(const Robot& robot, int joint);

/// The position [rad] of a joint that turns at the time of its transform, on the turn that its number in joint_states
/// tells: a transform does not tell turns. nullopt if it is not told: the number
/// * is not within Config::max_tf_age of `stamp`, the time of the transform,
/// * does not agree with the transform, up to whole turns. The two may differ by 0.05 rad and by what the joint moves
///   between their times at twice its velocity limit, together at most by a quarter turn, or
/// * is more than half a turn beyond the limits, so that the driver means something else.
/// Mimic joints have none, because their leaders tell them.
std::optional<double> onStatedTurn(const Robot& robot, int joint, const Eigen::Isometry3d& parent_T_child,
                                   const ros::Time& stamp, const StatedJoints::Entry& entry);

/// A joint that is in joint_states beyond its limits by more than scene::kBeyondLimit.
struct JointBeyond {
  int joint;        ///< index into RobotModel::joints; never a mimic joint
  double position;  ///< [rad] or [m]
};

/// The joint that is the farthest beyond its limits, by positions within Config::max_tf_age of `now`; nullopt: none is.
std::optional<JointBeyond> farthestBeyond(const Robot& robot, const StatedJoints& stated, const ros::Time& now);

/// Appends: "joint 'elbow' is at 257.8 rad in joint_states, beyond its limits of -6.283 and 6.283: in degrees?". The
/// question is left out if the number in degrees would be beyond them, too, or is within a turn in radians.
void append(std::string& text, const Robot& robot, const JointBeyond& beyond);

}  // namespace proximity_server::node
