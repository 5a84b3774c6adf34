#pragma once

#include "proximity_server/scene/model/robot_model.h"

#include <random>
#include <vector>

namespace proximity_server::scene {

/// One position for each of RobotModel::joints, [rad] or [m].
using Positions = std::vector<double>;

/// The range of positions of a joint that is sampled. Mimic joints have none. The range is given by the limits, with
/// three exceptions.
///
/// A continuous joint makes one full turn, from -pi to pi, and so does a revolute joint without a limit. A revolute
/// joint whose limits are more than a full turn apart makes one full turn about the middle of its limits, because more
/// of them would repeat the same poses; but if other joints mimic it, it has its limits. A prismatic joint without a
/// limit has a range from -1 m to 1 m, which is a guess. Mimic joints follow their leader, and their own limits are
/// ignored.
struct JointRange {
  int joint;  ///< index into RobotModel::joints
  double lower, upper;

  double width() const { return upper - lower; }

  /// Rounds a position to few decimals, so that a person can type it in. The result lies in the range. The number of
  /// decimals is the smallest that leaves at least 10,000 different positions in the range.
  double typeable(double position) const;
};

/// The ranges of all joints that have one degree of freedom and are not mimic joints, in the order of the joints.
std::vector<JointRange> jointRanges(const RobotModel& robot);

/// True if the range covers all positions of a joint. False for floating and planar joints, which stay at the identity,
/// for prismatic joints without limits, and for mimic joints of a joint without limits.
bool hasKnownRange(const RobotModel& robot, int joint);

/// The range of a joint; nullptr if there is none.
const JointRange* intervalOf(const std::vector<JointRange>& box, int joint);

/// Those of RobotModel::inequalities all of whose joints have a range.
std::vector<JointInequality> inequalitiesOver(const std::vector<JointRange>& ranges, const RobotModel& robot);

/// Draws each joint uniformly from its range, independently of the others, until inequalitiesOver() holds; the other
/// joints are at 0. Failure: throws as drawWithin().
Positions randomPositions(const RobotModel& robot, const std::vector<JointRange>& ranges, std::mt19937_64& random);

/// The movable joints between two bodies, in the order from a to b. If the bodies belong to two robots, all joints up
/// to their roots.
std::vector<int> jointsBetween(const RobotModel& robot, int body_a, int body_b);

/// Returns the ranges whose joints change the relative pose of two links.
std::vector<JointRange> rangesBetween(const RobotModel& robot, const std::vector<JointRange>& ranges, int link_a,
                                      int link_b);

}  // namespace proximity_server::scene
