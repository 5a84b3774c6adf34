#pragma once

#include "proximity_server/scene/model/robot_model.h"

#include <geometry_msgs/TransformStamped.h>
#include <ros/time.h>
#include <sensor_msgs/JointState.h>

#include <vector>

namespace proximity_server::node {

using namespace scene;

/// A robot whose joints swing about the middle of their ranges, each with a period of its own. Where it stands is a
/// function of the time alone, so that everybody can tell what an answer with a stamp must be.
class MovingRobot {
 public:
  /// `robot` must outlive this.
  explicit MovingRobot(const RobotModel& robot) : robot_(robot) {}

  const RobotModel& robot() const { return robot_; }

  /// [rad] or [m] of each of RobotModel::joints.
  std::vector<double> positionsAt(const ros::Time& time) const;

  /// The transforms of the movable joints, as robot_state_publisher has them.
  std::vector<geometry_msgs::TransformStamped> transformsAt(const ros::Time& time) const;

  /// The positions of the joints that have one of their own.
  sensor_msgs::JointState jointStateAt(const ros::Time& time) const;

 private:
  const RobotModel& robot_;
};

/// Whether a joint takes one position of its own.
bool isSettable(const Joint& joint);

}  // namespace proximity_server::node
