#pragma once

#include <algorithm>
#include <optional>
#include <vector>

#include "proximity_server/scene/model/kinematics.h"
#include "proximity_server/scene/motion/robot_motion.h"

namespace proximity_server::scene {

/// A motion over the time [0, 1] in phases, each a RobotMotion that begins where the one before ended.
class PhasedMotion {
 public:
  struct Phase {
    double begin, end;   ///< of the whole's time; the first begins at 0, the last ends at 1
    RobotMotion motion;  ///< over this phase

    /// The whole's time at a time [0, 1] of this phase.
    double onWhole(double time) const { return time < 1.0 ? std::min(end, begin + time * (end - begin)) : end; }
  };

  /// In one phase.
  PhasedMotion(RobotMotion motion);  // NOLINT(google-explicit-constructor): the same motion

  /// Throws std::invalid_argument if there is no phase, or if their times leave a gap.
  explicit PhasedMotion(std::vector<Phase> phases);

  const std::vector<Phase>& phases() const { return phases_; }
  BodyPoses at(double time) const;

  /// Gives every phase its part of what carries objects; `frames` are those of the whole time. Throws as
  /// RobotMotion::carryObjects does.
  void carryObjects(const RobotMotion::ObjectFrames& frames);

  /// See RobotMotion::inWorld().
  RobotMotion::State inWorld(double time) const;

 private:
  const Phase& phaseAt(double time) const;

  std::vector<Phase> phases_;
};

/// [rad] An encoder may tell as much beyond a limit.
constexpr double kBeyondLimit = 0.05;

/// A joint that stops at a limit.
struct JointStop {
  int joint;    ///< index into RobotModel::joints; never a mimic joint
  double time;  ///< of [0, 1)
};

struct LimitedMotion {
  PhasedMotion motion;
  std::vector<JointStop> stops;  ///< in the order of their times
};

/// Every joint at constant velocity until it reaches a limit, where it rests from then on.
///
/// 1. Read the position of each joint off the poses. If the pose of a leader is missing, its position follows from that
///    of a mimic joint. The limits are those of the leader, and all its followers stop with it.
/// 2. The distance to the limit and the velocity give the time of the stop. A joint beyond a limit rests if its
///    velocity points further out, and moves if it points back in.
/// 3. The times of the stops divide the motion into phases: at most one more than there are joints.
///
/// `travel` is as in RobotMotion::ofTravel, for the whole time and without limits. `stated` [rad] has a position for
/// each of RobotModel::joints, or is empty. A pose does not tell full turns: of the positions that it may stand for, the one
/// nearest to the stated position counts, also beyond a limit. Without a stated position the joint is taken to be within its
/// limits, or beyond one by kBeyondLimit at most, and stops as late as that allows; if it can be neither, it is as near to them
/// as the pose allows. So a joint that is beyond a limit by more, and whose limits are nearly a turn apart or farther, has to
/// state it: else it is taken to be a turn away.
/// Error:   the position at which a joint stops is within rounding of its limit.
/// Failure: throws as RobotMotion::ofTravel does, and std::invalid_argument for a wrong number of stated positions, and, with the
///          name of the joint, for one of a joint that moves which is more than half a turn beyond its limits.
LimitedMotion motionWithinLimits(const RobotModel& model, const BodyPoses& start, const std::vector<double>& travel,
                                 const std::vector<std::optional<double>>& stated = {});

/// A one-dof joint's position [rad] in (-pi, pi] or [m], given the pose of its child body in its parent body.
double jointPosition(const RobotModel& model, const Joint& joint, const Eigen::Isometry3d& parent_T_child);

}  // namespace proximity_server::scene
