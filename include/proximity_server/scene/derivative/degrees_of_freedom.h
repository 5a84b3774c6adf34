#pragma once

#include <string>
#include <vector>

#include "proximity_server/scene/model/robot_model.h"

namespace proximity_server::scene {

/// One coordinate of the velocity of a robot, and with it one column of every derivative.
struct DegreeOfFreedom {
  enum class Kind : unsigned char { Rotation, Translation };
  std::string name;  ///< of its joint; of a planar or floating one with a suffix, see DegreesOfFreedom
  int joint;         ///< index into RobotModel::joints; never a mimic joint
  Kind kind;         ///< its velocity is in [rad/s] or [m/s]
};

/// What the derivatives of a robot are taken by: the velocities of all joints that follow no other, in the order of
/// RobotModel::joints.
///
/// Revolute, continuous and prismatic joints have one, with the name of the joint.
/// A planar joint has three: "/x" and "/y", of the child's origin along two axes of the plane, and "/theta" around the normal. The
///          first axis is what the shortest turn of z to the normal makes of x: x itself for the normal z.
/// A floating joint has six: "/trans_x", "/trans_y", "/trans_z", of the child's origin, and "/rot_x", "/rot_y", "/rot_z", the
///          angular velocity. Both are along the axes of the joint's frame, which is fixed in the parent.
class DegreesOfFreedom {
 public:
  explicit DegreesOfFreedom(const RobotModel& model);

  int size() const { return static_cast<int>(list_.size()); }
  const DegreeOfFreedom& operator[](int column) const { return list_[static_cast<std::size_t>(column)]; }
  const std::vector<DegreeOfFreedom>& list() const { return list_; }

  /// What a joint does at given velocities: `multiplier` times what those of the columns from `first` on say. That is 1 unless
  /// it follows another joint, whose columns these are then.
  struct Columns {
    int first;
    int count;
    double multiplier;
  };
  const Columns& columnsOf(int joint) const { return of_joint_[static_cast<std::size_t>(joint)]; }

 private:
  std::vector<DegreeOfFreedom> list_;
  std::vector<Columns> of_joint_;
};

}  // namespace proximity_server::scene
