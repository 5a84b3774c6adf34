#pragma once

#include "proximity_server/scene/model/kinematics.h"
#include "proximity_server/scene/model/posed_position.h"
#include "proximity_server/scene/motion/robot_motion.h"

#include <algorithm>
#include <optional>
#include <vector>

namespace proximity_server::scene {

/// A motion over the time [0, 1] in phases. Each phase is a RobotMotion that begins where the phase before ended.
class PhasedMotion {
 public:
  struct Phase {
    double begin, end;   ///< in the time of the whole motion; the first begins at 0, the last ends at 1
    RobotMotion motion;  ///< the motion over this phase, in a time [0, 1] of its own

    /// Maps a time [0, 1] of this phase to the time of the whole motion.
    double onWhole(double time) const { return time < 1.0 ? std::min(end, begin + time * (end - begin)) : end; }
  };

  /// A motion in one phase.
  PhasedMotion(RobotMotion motion);  // NOLINT(google-explicit-constructor): the same motion

  /// Throws std::invalid_argument if there is no phase, or if their times leave a gap.
  explicit PhasedMotion(std::vector<Phase> phases);

  const std::vector<Phase>& phases() const { return phases_; }
  BodyPoses at(double time) const;

  /// Splits the motion of the frames that carry objects, which is over the whole time, into the phases. Throws as
  /// RobotMotion::carryObjects does.
  void carryObjects(const RobotMotion::ObjectFrames& frames);

  /// See RobotMotion::inWorld().
  RobotMotion::State inWorld(double time) const;

 private:
  const Phase& phaseAt(double time) const;

  std::vector<Phase> phases_;
};

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

struct LimitedMotion {
  PhasedMotion motion;
  std::vector<JointStop> stops;           ///< in the order of their times
  std::optional<InequalityBreak> broken;  ///< the first one; an inequality is left out if a pose of it is missing
  /// The joints that would stop earlier on another turn that their limits allow: their position is not stated.
  std::vector<int> assumed = {};
};

/// Moves every joint at constant velocity until it reaches a limit, where it rests from then on.
///
/// 1. Compute the position of each joint from the poses. If the pose of a leader is missing, its position follows from
///    that of a mimic joint. The limits are those of the leader, and all its followers stop with it.
/// 2. The distance to the limit and the velocity give the time of the stop. A joint beyond a limit rests if its
///    velocity points further out, and moves if it points back in.
/// 3. The times of the stops divide the motion into phases: at most one more than there are joints.
///
/// `travel` is as in RobotMotion::ofTravel, for the whole time and without limits. `stated` [rad] has a position for
/// each of RobotModel::joints, or is empty; see posed_position.h. Of the positions that a pose stands for, the one
/// counts with which the joint stops last. An inequality stops no joint.
///
/// Error:   the position at which a joint stops is within rounding of its limit.
/// Failure: throws as RobotMotion::ofTravel does. Throws std::invalid_argument for a wrong number of stated positions,
///          and, with the name of the joint, for a stated position of a moving joint more than half a turn beyond its
///          limits.
LimitedMotion motionWithinLimits(const RobotModel& model, const BodyPoses& start, const std::vector<double>& travel,
                                 const std::vector<std::optional<double>>& stated = {});

}  // namespace proximity_server::scene
