#pragma once

#include "proximity_server/scene/model/robot_model.h"

#include <string>
#include <vector>

namespace proximity_server::scene {

/// One coordinate of the velocity of a robot, and with it one column of every derivative.
struct DegreeOfFreedom {
  enum class Kind : unsigned char { Rotation, Translation };
  std::string name;  ///< the name of its joint; for planar and floating joints with a suffix, see DegreesOfFreedom
  int joint;         ///< index into RobotModel::joints; never a mimic joint
  Kind kind;         ///< the unit of its velocity is [rad/s] or [m/s]
};

/// The coordinates by which the derivatives of a robot are taken: the velocities of all joints that are not mimic
/// joints, in the order of RobotModel::joints.
///
/// * A revolute, continuous or prismatic joint has one, with the name of the joint.
/// * A planar joint has three: "/x" and "/y" move the child's origin along two axes of the plane, and "/theta" turns it
///   around the normal. The first axis is the x axis after the shortest rotation from z to the normal; for the normal z
///   it is x itself.
/// * A floating joint has six: "/trans_x", "/trans_y" and "/trans_z" move the child's origin, and "/rot_x", "/rot_y"
///   and "/rot_z" are the angular velocity. All are along the axes of the joint's frame, which is fixed in the parent.
class DegreesOfFreedom {
 public:
  explicit DegreesOfFreedom(const RobotModel& model);

  int size() const { return static_cast<int>(list_.size()); }
  const DegreeOfFreedom& operator[](int column) const { return list_[column]; }
  const std::vector<DegreeOfFreedom>& list() const { return list_; }

  /// The velocity of a joint is `multiplier` times the velocities in `count` columns, beginning with `first`. The
  /// multiplier is 1, except for a mimic joint, which has the columns of its leader.
  struct Columns {
    int first;
    int count;
    double multiplier;
  };
  const Columns& columnsOf(int joint) const { return of_joint_[joint]; }

 private:
  std::vector<DegreeOfFreedom> list_;
  std::vector<Columns> of_joint_;
};

}  // namespace proximity_server::scene
