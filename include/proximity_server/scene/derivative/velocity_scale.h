#pragma once

#include <chrono>
#include <optional>
#include <vector>

#include "proximity_server/scene/motion/moving_scene.h"
#include "proximity_server/scene/query/pair_distances.h"
#include "proximity_server/scene/query/scene.h"

namespace proximity_server::scene {

/// How a robot stops: for `latency` it goes on with its velocity, then it brakes. It stays on the straight path in joint
/// space, so that all joints slow down by a common factor, as hard as the first of them allows.
struct Braking {
  double latency = 0.0;  ///< [s]
  /// [rad/s^2] or [m/s^2], one for each of RobotModel::joints; infinity: stops at once. That of a mimic joint counts for what its
  /// leader makes of it.
  std::vector<double> deceleration{};
};

/// A robot that moves.
struct MovingState {
  BodyPoses poses;  ///< those of the scene
  std::vector<double>
      velocities;  ///< [rad/s] or [m/s], one for each of RobotModel::joints; those of mimic joints are ignored
  std::vector<std::optional<double>> positions{};  ///< [rad] as stated, see motionWithinLimits(); or empty
  RobotMotion::ObjectFrames frames{};              ///< what carries objects; each at rest in its parent
};

/// The speed at which a robot can still stop.
struct VelocityScale {
  /// Converged: the largest scale, within the tolerance of the search. IterationLimit (the deadline has passed, or the iterations
  /// were used up) and Degenerate: a smaller one, which is safe. Unknown: a pose or a velocity is missing.
  narrowphase::Status status = narrowphase::Status::Unknown;
  double scale = 0.0;  ///< of [0, 1]
  PairProximity pair;  ///< that limits it, where it would stop, in the frame of the poses; Unknown if there is none
};

/// [m] A pair that is at or below its stop distance comes nearer during a stop by no more than this.
constexpr double kRetreatTolerance = 1e-6;

/// The largest s in [0, 1] with which the robot, if its joints move at s times their velocities, still stops above the stop
/// distances. What only leads away from a pair that is too near already is not slowed.
///
/// 1. From s times the velocities v the robot gets as far as v lasts for L(s) = s T + s^2 tau / 2, where T is the latency and
///    tau = max_j |v_j| / a_j is how long it takes to brake from v. The paths of all s begin in the same way.
/// 2. So the path for s = 1 is searched once, see MovingScene::timeOfContact(); joints rest from their limits on. It is free until
///    L_free, and s = 2 L_free / (T + sqrt(T^2 + 2 tau L_free)).
/// 3. A pair that is at or below the stop distance at the start is in contact if it comes nearer than it was, by the retreat
///    tolerance. If it does so from the start on, the scale is 0. One that goes away first and would come back limits
///    the way to where it is as near as at the start.
///
/// Error:   rounded down. Each pair stays above its stop distance or, if it is less than kRetreatTolerance above that already,
///          above its present distance less kRetreatTolerance.
/// Limit:   motions of floating and planar joints do not count, nor do those of objects that move on their own. A way out of an
///          overlap with a closed mesh that has room inside is seen as one only if the two come no nearer during the whole
///          unscaled stop; else the scale is 0, and the status IterationLimit.
///          An overlap whose depth grows at first, until another way out becomes the shorter one, is no retreat either.
/// Failure: the scale is 0 and the status Unknown if a velocity is not finite, or if a pose of a checked pair is missing. A
///          deadline gives what is proven by then. Throws std::invalid_argument as motionWithinLimits() does, for a latency
///          that is negative or no number, for a deceleration that is not positive (with the name of the joint), for
///          another number of them, and for frames of objects that move on their own.
///
/// The poses and objects of both scenes are the same: `scene` has had Scene::update() with those of `state`, which stay.
VelocityScale velocityScale(
    MovingScene& moving, Scene& scene, const MovingState& state, const Braking& braking, const PairDistances& stop,
    std::chrono::steady_clock::time_point deadline = std::chrono::steady_clock::time_point::max());

}  // namespace proximity_server::scene
