#pragma once

#include "proximity_server/scene/model/kinematics.h"
#include "proximity_server/scene/model/posed_position.h"
#include "proximity_server/scene/motion/motion.h"

#include <optional>
#include <vector>

namespace proximity_server::scene {

/// A joint that stops at a limit.
struct JointStop {
  int joint;    ///< index into RobotModel::joints; never a mimic joint
  double time;  ///< in [0, 1)
};

/// From `time` on, in [0, 1), the excess of an inequality is larger than 0 and, by its tolerance, than at the start.
struct InequalityBreak {
  int inequality;  ///< index into RobotModel::inequalities
  double time;
};

struct MotionLimits {
  std::vector<JointStop> stops{};           ///< in the order of their times
  std::optional<InequalityBreak> broken{};  ///< the first one; an inequality is left out if a pose of it is missing
  /// The joints that would stop earlier on another turn that their limits allow: their position is not stated.
  std::vector<int> assumed{};
};

struct LimitedMotion : MotionLimits {
  Motion motion;
};

/// Moves every joint at constant velocity until it reaches a limit, where it rests from then on.
///
/// 1. Compute the position of each joint from the poses. If the pose of a leader is missing, its position follows from
///    the position of a mimic joint. The limits of the leader count, and all its followers stop with it.
/// 2. The distance to the limit and the velocity give the time of the stop. A joint beyond a limit rests if its
///    velocity points further out, and moves if it points back in.
/// 3. The times of the stops divide the motion into pieces: at most one more than there are joints.
///
/// `travel` is as in RobotMotion::ofTravel, for the whole time and without limits. `stated` [rad] has a position for
/// each of RobotModel::joints, or is empty; see posed_position.h. Among the positions that a pose stands for, the one
/// counts with which the joint stops last. An inequality stops no joint.
///
/// Error:   the position at which a joint stops is within rounding of its limit.
/// Failure: throws as RobotMotion::ofTravel does. Throws std::invalid_argument for a wrong number of stated positions,
///          and, with the name of the joint, for a stated position of a moving joint more than half a turn beyond its
///          limits.
LimitedMotion motionWithinLimits(const RobotModel& model, const BodyPoses& start, const std::vector<double>& travel,
                                 const std::vector<std::optional<double>>& stated = {});

// The parts of motionWithinLimits(), for Lookahead, which makes one piece at a time.

/// The limits of a motion. Failure: throws as motionWithinLimits() does, but for the travel.
void findLimits(const RobotModel& model, const BodyPoses& start, const std::vector<double>& travel,
                const std::vector<std::optional<double>>& stated, MotionLimits& limits);

/// The parameter of the first stop after `begin`; 1 if there is none.
double nextStop(const std::vector<JointStop>& stops, double begin);

/// Makes of the travel without limits that between two parameters, if no joint stops between them.
void restrictTravel(double begin, double end, const std::vector<JointStop>& stops, std::vector<double>& travel);

}  // namespace proximity_server::scene
