#pragma once

#include "proximity_server/scene/motion/motion_search.h"
#include "proximity_server/scene/query/pair_distances.h"
#include "proximity_server/scene/query/scene.h"

#include <optional>
#include <vector>

namespace proximity_server::scene {

/// The way in which a robot stops: it continues with its velocity for `latency`, then it brakes. It stays on the
/// straight path in joint space: all joints slow down by a common factor, which the joint with the longest braking time
/// determines.
struct Braking {
  double latency = 0.0;  ///< [s]
  /// [rad/s^2] or [m/s^2], one for each of RobotModel::joints; infinity: stops at once. That of a mimic joint limits
  /// the motion that its leader causes.
  std::vector<double> deceleration{};
};

/// How a robot moves from a state.
struct MovingState {
  /// [rad/s] or [m/s], one for each of RobotModel::joints; mimic joints are ignored
  std::vector<double> velocities;
  std::vector<std::optional<double>> positions{};  ///< [rad] stated positions, see motionWithinLimits(); or empty
  RobotMotion::ObjectFrames frames{};              ///< the frames that carry objects; each at rest in its parent
  /// [m] If the state is not known exactly: no pair that a joint moves is ever nearer than its distance by these poses
  /// and velocities minus this.
  double largest_loss = 0.0;
  /// [s] If `largest_loss` contains the motion since the time of the poses: how long ago that is. Inequalities, which
  /// `largest_loss` does not cover, have it as additional latency.
  double age = 0.0;
};

/// Per joint [rad] or [m]: how far it moves at most until the robot has stopped from its full velocities.
std::vector<double> stoppingTravel(const RobotModel& model, const std::vector<double>& velocities,
                                   const Braking& braking);

/// [s] How long braking from the full velocities takes.
double brakingTime(const RobotModel& model, const std::vector<double>& velocities, const Braking& braking);

/// The motion of a stop from the full velocities, as velocityScale() searches it: its parameter is the way, not the time.
/// Throws as velocityScale() does, but not for velocities that are missing.
Motion stoppingMotion(const State& start, const MovingState& state, const Braking& braking);

/// The speed at which a robot can still stop in time.
struct VelocityScale {
  /// Converged: the largest scale, within the tolerance of the search. IterationLimit (the deadline has passed, or the
  /// iterations were used up) and Degenerate: a smaller scale, which is safe. Unknown: a pose or a velocity is missing.
  narrowphase::Status status = narrowphase::Status::Unknown;
  double scale = 0.0;  ///< in [0, 1]
  /// the pair that limits it, where the robot would stop, in the frame of the poses; Unknown if there is none, or if an
  /// inequality limits it
  PairProximity pair;
};

/// [m] During a stop, a pair that is at or below its stop distance may come nearer by this much.
constexpr double kRetreatTolerance = 1e-6;

/// Finds the largest s in [0, 1] such that a robot whose joints move at s times their velocities still stops above the
/// stop distances, and before it breaks one of RobotModel::inequalities. Motions that only lead away from pairs that
/// are already too near are not slowed, and neither are those that lead back into what inequalities allow.
///
/// 1. At s times the velocities v, the robot moves until it stops as far as v would take it in the time L(s) = s T +
///    s^2 tau / 2. T is the latency, and tau = max_j |v_j| / a_j is the time that braking from v takes. The paths of
///    all s begin in the same way.
/// 2. So only the path for s = 1 is searched, see MotionSearch::timeOfContact(); joints rest after they reach their
///    limits. The path is free until L_free, and s = 2 L_free / (T + sqrt(T^2 + 2 tau L_free)).
/// 3. A pair that is at or below the stop distance at the start is in contact if it comes nearer than it was at the
///    start, by the retreat tolerance. If it does so from the start on, the scale is 0. A pair that first moves away
///    and later would come back limits the way to the point where it is as near as at the start.
/// 4. The way also ends where an inequality breaks, see InequalityBreak.
///
/// Error:   rounded down. Each pair stays above its stop distance. A pair that is less than kRetreatTolerance above its
///          stop distance, or below it, stays above its present distance minus kRetreatTolerance.
/// Limit:   motions of floating and planar joints are ignored, and so are motions of objects on their own. A
///          way out of an overlap with a closed mesh that has room inside counts as a retreat only if the two come no
///          nearer during the whole unscaled stop; otherwise the scale is 0, and the status IterationLimit. An overlap
///          whose depth grows at first, until another way out becomes shorter, is not a retreat either. Inequalities
///          hold for the positions of the poses, without uncertainty.
/// Failure: the scale is 0 and the status Unknown if a velocity is not finite, if a pose of a checked pair is missing,
///          or one of an inequality of which a joint moves. After the deadline, the scale that is proven by then is
///          returned. Throws std::invalid_argument as motionWithinLimits() does, for a latency that is negative or not
///          finite, for a deceleration that is not positive (with the name of the joint), for a wrong number of them,
///          and for frames of objects that move on their own.
///
/// `moving` must have the objects of `start`.
VelocityScale velocityScale(MotionSearch& moving, Scene& scene, const State& start, const MovingState& state,
                            const Braking& braking, const PairDistances& stop, const Deadline& deadline = {});

/// The velocity scale for some pairs, without the inequalities.
VelocityScale velocityScale(const Pairs& pairs, MotionSearch& moving, Scene& scene, const State& start,
                            const MovingState& state, const Braking& braking, const PairDistances& stop,
                            const Deadline& deadline = {});

}  // namespace proximity_server::scene
