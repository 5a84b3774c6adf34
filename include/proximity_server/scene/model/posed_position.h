#pragma once

#include "proximity_server/scene/model/joint_inequality.h"
#include "proximity_server/scene/model/kinematics.h"
#include "proximity_server/scene/model/robot_model.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

// Joint positions as poses tell them. A pose does not tell full turns, so that it stands for several positions of a
// joint that turns:
//
// * With a stated position, the one nearest to it counts, even beyond a limit.
// * Without a stated position, the joint is taken to be within its limits, or beyond one by kBeyondLimit at most. If
//   several positions are, the user of these functions says which one counts. If there is none, the one nearest to the
//   limits counts.
//
// So, if the limits of a joint are nearly a turn apart or farther, and it is beyond one by more than kBeyondLimit, its
// position must be stated; otherwise it is taken to be a turn away.

namespace proximity_server::scene {

/// [rad] An encoder may report a position this far beyond a limit.
constexpr double kBeyondLimit = 0.05;

/// The position that a pose tells: one of the numbers value + n * spacing, [rad] or [m].
struct PosedPosition {
  double value;
  double spacing;  ///< 0: the value is the only one

  PosedPosition mirrored() const { return {-value, spacing}; }
  double atOrAbove(double position) const { return value + std::ceil((position - value) / spacing) * spacing; }
  double atOrBelow(double position) const { return value + std::floor((position - value) / spacing) * spacing; }
  double nearestTo(double position) const { return value + std::round((position - value) / spacing) * spacing; }
};

struct PositionLimits {
  double lower, upper;

  PositionLimits mirrored() const { return {-upper, -lower}; }
  double excess(double position) const { return std::max(lower - position, position - upper); }
};

/// The position of a joint that is no mimic joint, as its own pose tells, or else the pose of a follower; nullopt if no
/// such pose is known, and for floating and planar joints.
std::optional<PosedPosition> posedPosition(const RobotModel& model, const BodyPoses& poses, int joint);

/// Returns the position nearest to the stated one. Without a stated one, returns the lowest of the positions that the
/// limits allow, or, if they allow none, the position nearest to the limits.
double positionWithin(const PositionLimits& limits, const PosedPosition& position, const std::optional<double>& stated);

/// By how much the sum of an inequality is above its bound. Among the positions that a pose stands for, those count
/// with which the excess is the smallest; of a joint without limits, the one in (-pi, pi]. `stated` has a position for
/// each of RobotModel::joints, or is empty. nullopt if a pose is missing. Allocates nothing.
std::optional<double> excessAt(const RobotModel& model, const JointInequality& inequality, const BodyPoses& poses,
                               const std::vector<std::optional<double>>& stated = {});

}  // namespace proximity_server::scene
