#pragma once

#include <random>
#include <vector>

#include "proximity_server/scene/model/robot_model.h"

namespace proximity_server::scene {

/// One position for each of RobotModel::joints, [rad] or [m].
using Positions = std::vector<double>;

/// The positions that are tried of a joint that follows no other.
///
/// A continuous joint makes one full turn. A prismatic joint without limits is tried from -1 m to 1 m, which is a
/// guess. Followers go where their leader takes them, as they do everywhere in the scene; limits of their own do not
/// count.
struct JointRange {
  int joint;  ///< index into RobotModel::joints
  double lower, upper;

  double width() const { return upper - lower; }

  /// A position near the given one that lies in the range and can be typed in: with at least 10,000 of them in a range,
  /// it has as few decimals as that takes.
  double typeable(double position) const;
};

/// The ranges of all joints that have a position and follow no other, in the order of the joints.
std::vector<JointRange> jointRanges(const RobotModel& robot);

/// Whether the ranges hold all that a joint can do: not so for floating and planar joints, which stay at the identity,
/// for prismatic ones without limits, and for what follows a joint without limits.
bool hasKnownRange(const RobotModel& robot, int joint);

/// Each joint uniformly within its range, independent of the others.
Positions randomPositions(const RobotModel& robot, const std::vector<JointRange>& ranges, std::mt19937_64& random);

/// The movable joints between two bodies, in the order from a to b.
std::vector<int> jointsBetween(const RobotModel& robot, int body_a, int body_b);

/// Those of `ranges` that move the links of a pair against each other.
std::vector<JointRange> rangesBetween(const RobotModel& robot, const std::vector<JointRange>& ranges, int link_a,
                                      int link_b);

}  // namespace proximity_server::scene
