#pragma once

#include "proximity_server/scene/objects/objects.h"
#include "proximity_server/scene/proof/joint_box.h"
#include "proximity_server/scene/scene_model/shape_ref.h"

namespace proximity_server::scene {

/// The part of a box that matters to a pair.
struct PairBox {
  JointBox joints;  ///< those that move the two relative to each other, without mimic joints
  /// [m] An upper bound of how much the distance of the two in any state of the box differs by rounding of the
  /// kinematics: from a state in real numbers to poses by forwardKinematics(), and from the ends of an interval that
  /// stands for a full turn.
  ///
  /// A position q of a joint is off by at most eps (1 + |q|), and so is the rotation by it; a product of two poses adds
  /// less than 16 eps to a rotation, and less than 8 eps times all lengths to a translation. A rotation moves what is
  /// behind it by its error times the sum of all lengths. Both shapes, in the state and at the centre of a box, make 4
  /// times 24 eps; 128 eps is more.
  double rounding = 0.0;
};

/// Throws std::invalid_argument as proveApart() does. `objects` may be nullptr.
PairBox pairBox(const RobotModel& robot, const Objects* objects, const ShapeRefPair& pair, const JointBox& box);

}  // namespace proximity_server::scene
