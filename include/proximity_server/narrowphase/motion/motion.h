#pragma once

#include "proximity_server/narrowphase/query_types.h"
#include "proximity_server/narrowphase/shape/shape.h"

#include <Eigen/Geometry>

#include <functional>
#include <limits>
#include <vector>

namespace proximity_server::narrowphase {

/// A rigid motion with constant linear and angular velocity, a screw, during the time [0, 1].
///
/// Frame: the one in which `start` is given. The axis of rotation is fixed in it; the moving frame keeps its distance
///        from the axis, rotates about it and translates along it. Metres and radians per unit of time.
struct ScrewMotion {
  Eigen::Isometry3d start = Eigen::Isometry3d::Identity();  ///< of single precision: stands for rigidPose()
  Eigen::Vector3d linear = Eigen::Vector3d::Zero();         ///< velocity of the moving frame's origin at time 0
  Eigen::Vector3d angular = Eigen::Vector3d::Zero();        ///< may be several turns

  /// The screw from one pose to another, by the smaller of the two angles.
  static ScrewMotion between(const Eigen::Isometry3d& start, const Eigen::Isometry3d& end);

  Eigen::Isometry3d at(double time) const;

  /// The motion as seen from the moving frame: inverse().at(t) = at(t).inverse().
  ScrewMotion inverse() const;

  bool isRest() const { return linear.isZero(0.0) && angular.isZero(0.0); }
};

/// The motion in the coordinates of another fixed frame, (pose * screw).at(t) = pose * screw.at(t), and the motion
/// of another frame fixed to the moving one, (screw * pose).at(t) = screw.at(t) * pose.
ScrewMotion operator*(const Eigen::Isometry3d& pose, const ScrewMotion& screw);
ScrewMotion operator*(const ScrewMotion& screw, const Eigen::Isometry3d& pose);

/// The motion of a frame as a product of screws, each given in the frame that the one before it moves, as for bodies
/// connected by moving joints.
using MotionChain = std::vector<ScrewMotion>;

Eigen::Isometry3d poseAt(const MotionChain& chain, double time);

/// [m] The sum of the lengths along a chain that contribute to its rounding error. At all times the position of a point
/// within `reach` of the origin of the last frame has an error below 32 eps times this sum. Positions are relative to
/// `origin`.
double roundedLengths(const MotionChain& chain, double reach, const Eigen::Vector3d& origin = Eigen::Vector3d::Zero());

/// Bounds of the motion of all points of a ball during an interval of time. The ball is fixed in the last frame of a
/// chain; the motion is relative to the frame in which the first screw is given.
struct MotionBound {
  Eigen::Vector3d velocity;  ///< [m] per unit of time, of the centre of the ball in the middle of the interval
  double deviation;          ///< [m] per unit of time: no velocity of any point at any time differs by more from it
  double acceleration;       ///< [m] per unit of time squared: largest of any point. No point leaves the chord of its
                             ///< path by more than acceleration * duration^2 / 8

  double speed() const { return velocity.norm() + deviation; }
};
MotionBound motionBound(const MotionChain& chain, const Eigen::Vector3d& centre, double radius, double begin,
                        double end);

/// A convex shape that contains the volume which `shape` sweeps during [begin, end].
///
/// It is the convex hull of the shape at both ends, with a margin of acceleration * duration^2 / 8 for the arcs between
/// them. For a translation it is the exact swept volume.
///
/// Frame:  the moving frame at the time `begin`.
/// Source: van den Bergen, Ray Casting against General Convex Objects with Application to Continuous Collision
///         Detection, 2004 (the swept volume by its support mapping).
Shape sweptShape(const Shape& shape, const ScrewMotion& motion, double begin = 0.0, double end = 1.0);

struct ContactOptions {
  double contact_distance = 0.0;  ///< [m] contact is a signed distance at or below it
  double tolerance = 1e-9;        ///< [m] of the distance at t_contact; NaN counts as 0
  double begin = 0.0;             ///< begin and end of the search, within [0, 1]
  double end = 1.0;
  int max_queries = 10000;  ///< most distance queries; each is for one time
  /// Asked before each further query. True ends the search like max_queries. Empty: never.
  std::function<bool()> is_over = nullptr;
};

/// The time of contact of two moving shapes: when they first come as near as the contact distance.
struct TimeOfContact {
  /// Converged: the answer is complete. IterationLimit, Degenerate: it is not known whether there is contact after
  ///            t_free.
  Status status = Status::Unknown;
  bool contact = false;
  double t_free = 0.0;  ///< from `begin` to t_free the signed distance is proven to be above the contact distance
  /// At this time the signed distance is at most contact_distance + tolerance; NaN without contact. t_free <=
  /// t_contact, and the true time of contact is not before t_free. Both are `begin` if the shapes are in contact from
  /// the beginning.
  double t_contact = std::numeric_limits<double>::quiet_NaN();
  SignedDistance at_contact;  ///< at t_contact, in the frame of the chains
  int queries = 0;            ///< number of distance queries
};

/// The time of contact by conservative advancement.
///
/// 1. Find the signed distance and its normal at the current time. If the distance is at most contact_distance +
///    tolerance, this is the time of contact.
/// 2. Choose the end of a trial step from the acceleration, and from the speed at which the gap closed in the last
///    step.
/// 3. Take the normal as an axis, and measure the gap of the shapes along it at both ends of the step. During the step
///    the gap lies above its chord less a parabola for the acceleration (moving_pair.h).
/// 4. Do the same with an axis that turns as fast as the normal did during the last step, and keep the better bound.
/// 5. If the bound meets the contact distance much earlier than the chord does, repeat from step 3 with a step that
///    ends where the chord meets it, three trials at most.
/// 6. Advance to the time until which the bound stays above the contact distance, and repeat from step 1 until the end
///    of the interval. No contact is passed, however thin the shapes; near contact the steps shrink faster than
///    geometrically.
///
/// Frame:   both chains begin in one common frame. A frame in which both shapes move little gives large steps.
/// Error:   see TimeOfContact. If it is not certain within the tolerance whether there is contact (grazing), the answer
///          is contact.
/// Failure: none; no allocation, except for chains of more than 8 screws. The status is Unknown if a motion is not
///          finite or begins with a pose whose axes are no rotation, or if begin and end are not an interval
///          within [0, 1].
/// Source:  Mirtich, Impulse-based Dynamic Simulation of Rigid Body Systems, 1996 (conservative advancement); Zhang,
///          Redon, Lee, Kim, Continuous Collision Detection for Articulated Models using Taylor Models and Temporal
///          Culling, 2007.
/// Differs: the bound of the motion along the axis is of second order and uses the support mapping at both ends.
TimeOfContact timeOfContact(const Shape& a, const MotionChain& a_motion, const Shape& b, const MotionChain& b_motion,
                            const ContactOptions& options = {});

struct MinimumOptions {
  double tolerance = 1e-9;  ///< [m] accepted width of the bounds; NaN counts as 0
  double begin = 0.0;
  double end = 1.0;
  double stop_above = std::numeric_limits<double>::infinity();  ///< [m] ends once the minimum is proven to be larger
  int max_queries = 512;                                        ///< most distance queries, 2 to 512
};

/// The smallest signed distance of two moving shapes.
struct MinimumOverMotion {
  Status status = Status::Unknown;  ///< Threshold: lower_bound > stop_above
  double lower_bound = -std::numeric_limits<double>::infinity();
  double upper_bound = std::numeric_limits<double>::infinity();
  double time = std::numeric_limits<double>::quiet_NaN();  ///< when the distance is upper_bound
  SignedDistance at_minimum;                               ///< at that time, in the frame of the chains
  int queries = 0;
};

/// Smallest signed distance during a motion, by branch and bound over time.
///
/// 1. Find the signed distance at the begin and the end of the interval; the smaller one is an upper bound.
/// 2. Bound the distance in between from below: along the normal at the begin, along the normal at the end, and along
///    an axis that turns from one to the other, the gap lies above its chord less a parabola (moving_pair.h).
/// 3. Take the interval with the smallest lower bound, and divide it where its bound is lowest.
/// 4. Find the distance there, bound both halves as in step 2, and lower the upper bound if possible.
/// 5. Repeat from step 3 until the bounds are within the tolerance. Intervals above stop_above are not divided.
///
/// Frame:   as timeOfContact().
/// Error:   Converged: upper_bound - lower_bound <= options.tolerance.
/// Failure: as timeOfContact().
/// Source:  Piyavskii, An Algorithm for Finding the Absolute Extremum of a Function, 1972.
/// Differs: the bounds are of second order, not Lipschitz bounds.
MinimumOverMotion minimumDistance(const Shape& a, const MotionChain& a_motion, const Shape& b,
                                  const MotionChain& b_motion, const MinimumOptions& options = {});

}  // namespace proximity_server::narrowphase
