#pragma once

#include "proximity_server/scene/velocity_scale.h"

#include <limits>
#include <vector>

// Speed and separation: how far people have to be from a moving robot, and how fast it may move beside them. It is no
// safety function.

namespace proximity_server::scene {

/// A person, or another thing that moves on its own, as an object of the scene. Nothing but its speed is known of how it
/// moves.
struct Tracked {
  int object;                ///< number of the object; it stands where it was seen last
  double speed = 1.6;        ///< [m/s] it is nowhere faster
  double near_speed = 2.0;   ///< [m/s] the same within kNearPerson of the robot; not below `speed`
  double older = 0.0;        ///< [s] it was seen this long before the time of the robot's poses; negative: after it
  double intrusion = 0.0;    ///< [m] by which a part of it may be nearer than what the sensor sees
  double uncertainty = 0.0;  ///< [m] by which the sensor may be off
};

constexpr double kNearPerson = 0.5;  ///< [m]

/// Compares the distance of a person with the protective separation distance S = S_h + S_r + S_s + C + Z_d + Z_r.
struct Separation {
  static constexpr double kNotKnown = std::numeric_limits<double>::quiet_NaN();

  /// Converged: all that follows is known. IterationLimit and Degenerate: the margin and the scale are smaller than they
  /// could be. Unknown: a pose or a velocity is missing; the scale is 0.
  narrowphase::Status status = narrowphase::Status::Unknown;
  int tracked = -1;      ///< index of the person with the smallest margin; -1: none
  PairProximity pair{};  ///< the person and the link or held object that comes nearest to it, now
  // Terms of `pair`:
  double distance = std::numeric_limits<double>::infinity();  ///< [m] d: lower bound now
  double human_speed = kNotKnown;                             ///< [m/s] v_h: assumed, towards the robot
  double robot_speed = kNotKnown;                             ///< [m/s] v_r: towards the person now; 0: moves away
  double reaction_time = kNotKnown;                           ///< [s] T_r: until the robot begins to brake
  double stopping_time = kNotKnown;                           ///< [s] T_s: of braking from the full velocities
  double human_way = kNotKnown;                               ///< [m] S_h: of the person until the robot stands
  double reaction_way = kNotKnown;         ///< [m] S_r: v_r T_r, but not more than the robot comes nearer in all
  double stopping_way = kNotKnown;         ///< [m] S_s: by which the robot comes nearer besides
  double intrusion = kNotKnown;            ///< [m] C
  double sensor_uncertainty = kNotKnown;   ///< [m] Z_d
  double robot_uncertainty = kNotKnown;    ///< [m] Z_r, see MovingState::largest_loss
  double protective_distance = kNotKnown;  ///< [m] S
  double margin = std::numeric_limits<double>::infinity();  ///< [m] d - S
  double scale = 0.0;  ///< of the velocities, in [0, 1]: with it S is kept from all persons; rounded down
};

/// Finds the smallest margin, and the largest scale of the velocities with which no person can reach a part of the robot
/// before this stands.
///
/// 1. Each person may move towards the robot until the robot stands: for the time t = older + T_r + T_s by
///    S_h = min(near_speed t, max(0, kNearPerson - C - Z_d - Z_r) + speed t). The second is enough as nobody is within
///    kNearPerson then before the robot stands.
/// 2. The smallest distance m of links and person on the whole way of the stop gives the margin m - S_h - C - Z_d - Z_r,
///    see MotionSearch::minimum(). S_r + S_s is d - m.
/// 3. At s times the velocities T_s is s times as long, see velocityScale(): with contact distances for the time of one
///    scale it gives another scale. The answer is the scale that gives itself; secants find it, and every step
///    leaves one that is safe.
///
/// Shapes:  links that a joint moves, and what they hold. Links that only roots carry are no hazard. A person that a link
///          moves away from does not slow it, however near it is, as in velocityScale().
/// Error:   a distance within kRetreatTolerance, and the scale within kScaleTolerance, rounded down.
/// Limit:   roots are taken to stand still, as in velocityScale(), and so does the motion of joints that measured
///          velocities do not tell.
/// Failure: as velocityScale(); also std::invalid_argument for a number of Tracked that is negative or not finite, a
///          `near_speed` below `speed`, and for an object that does not exist or that a link holds.
/// Source:  the formula and its terms are from ISO/TS 15066:2016, 5.5.4; the speeds from EN ISO 13855:2010, 6.2
///          (2.0 m/s, and 1.6 m/s if the distance is then at least 0.5 m). See config/SEPARATION.md.
Separation separation(MotionSearch& moving, Scene& scene, const State& start, const MovingState& state,
                      const Braking& braking, const std::vector<Tracked>& tracked, const Deadline& deadline = {});

constexpr double kScaleTolerance = 1e-3;

}  // namespace proximity_server::scene
