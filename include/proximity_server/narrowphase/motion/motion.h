#pragma once

#include <Eigen/Geometry>
#include <limits>
#include <vector>

#include "proximity_server/narrowphase/query_types.h"
#include "proximity_server/narrowphase/shape/shape.h"

namespace proximity_server::narrowphase {

/// A rigid motion with constant linear and angular velocity: a screw, over the time [0, 1].
///
/// Frame: the one that `start` is given in. The axis of the turn stands still in it, and the frame that moves keeps its
///        distance from the axis while it turns and slides along it. Metres and radians per unit of time.
struct ScrewMotion {
  Eigen::Isometry3d start = Eigen::Isometry3d::Identity();
  Eigen::Vector3d linear = Eigen::Vector3d::Zero();   ///< velocity of the moving frame's origin at time 0
  Eigen::Vector3d angular = Eigen::Vector3d::Zero();  ///< may be several turns

  /// From one pose to another, along the shorter turn.
  static ScrewMotion between(const Eigen::Isometry3d& start, const Eigen::Isometry3d& end);

  Eigen::Isometry3d at(double time) const;

  /// The same motion seen from the frame that moves: inverse().at(t) = at(t).inverse().
  ScrewMotion inverse() const;

  bool isRest() const { return linear.isZero(0.0) && angular.isZero(0.0); }
};

/// The same motion seen from a frame that stands still to the first, and that of a frame fixed to the one that moves:
/// (pose * screw).at(t) = pose * screw.at(t), (screw * pose).at(t) = screw.at(t) * pose.
ScrewMotion operator*(const Eigen::Isometry3d& pose, const ScrewMotion& screw);
ScrewMotion operator*(const ScrewMotion& screw, const Eigen::Isometry3d& pose);

/// The motion of a frame as a product of screws, each in the frame of the one before: bodies joined by moving joints.
using MotionChain = std::vector<ScrewMotion>;

Eigen::Isometry3d poseAt(const MotionChain& chain, double time);

/// [m] The lengths along a chain that are rounded, each turned by an angle that is itself rounded: at all times the
/// pose of a point within `reach` of the last frame is off by less than 32 eps of them. Positions count from `origin`.
double roundedLengths(const MotionChain& chain, double reach, const Eigen::Vector3d& origin = Eigen::Vector3d::Zero());

/// What bounds the motion of all points of a ball, which is fixed in the last frame of a chain, as seen from the frame
/// of the first, during an interval of time.
struct MotionBound {
  Eigen::Vector3d velocity;  ///< [m] per unit of time, of the centre in the middle of the interval
  double deviation;          ///< [m] per unit of time, by which all velocities of all points differ from it at most
  double acceleration;       ///< [m] per unit of time squared: a point leaves its chord by acceleration duration^2 / 8

  double speed() const { return velocity.norm() + deviation; }
};
MotionBound motionBound(const MotionChain& chain, const Eigen::Vector3d& centre, double radius, double begin,
                        double end);

/// A convex shape that holds all that `shape` passes through during [begin, end], in the frame of the motion at
/// `begin`: the hull of where it stands at either end, with a margin for the arcs, which lie outside of that by
/// acceleration duration^2 / 8. Of a translation it is the exact swept volume.
/// Source: van den Bergen, Ray Casting against General Convex Objects with Application to Continuous Collision
///         Detection, 2004 (the swept volume by its support mapping).
Shape sweptShape(const Shape& shape, const ScrewMotion& motion, double begin = 0.0, double end = 1.0);

struct ContactOptions {
  double contact_distance = 0.0;  ///< [m] contact is a signed distance at or below it
  double tolerance = 1e-9;        ///< [m] of that distance
  double begin = 0.0;             ///< the time in which contact is looked for, within [0, 1]
  double end = 1.0;
  int max_queries = 10000;  ///< of the distance, at one time
};

/// When two moving shapes come into contact for the first time.
struct TimeOfContact {
  /// Converged: the answer is complete. IterationLimit, Degenerate: contact is undecided after t_free.
  Status status = Status::Unknown;
  bool contact = false;
  double t_free = 0.0;  ///< from `begin` to here the signed distance is proven to be above the contact distance
  /// The signed distance is at most contact_distance + tolerance here. NaN without contact. t_free <= t_contact, and the first
  /// true contact is not before t_free; both are `begin` where the shapes are in contact from the beginning.
  double t_contact = std::numeric_limits<double>::quiet_NaN();
  SignedDistance at_contact;  ///< at t_contact, in the frame of the chains
  int queries = 0;            ///< of the distance
};

/// Time of first contact by conservative advancement.
///
/// From a time at which the shapes are apart, the normal of their distance is the axis of a step, turned as fast as the
/// normals of the last step did: the gap along it is known at the beginning and at the end of the step, and in between
/// lies above its chord less a parabola for the acceleration. The step ends where that meets the contact distance, so no
/// contact is passed, however thin the shapes; near contact the steps shrink faster than geometrically.
///
/// Frame:   the chains lead from one common frame to a and to b. A frame in which both move little gives large steps.
/// Error:   see TimeOfContact. Where contact is not certain within the tolerance (grazing) the answer is contact.
/// Failure: none; no allocation, but for chains of more than 8 screws. A motion that is not finite, or no interval of
///          time, gives Status::Unknown.
/// Source:  Mirtich, Impulse-based Dynamic Simulation of Rigid Body Systems, 1996 (conservative advancement); Zhang,
///          Redon, Lee, Kim, Continuous Collision Detection for Articulated Models using Taylor Models and Temporal
///          Culling, 2007. Here the bound of the motion along the axis is of second order, by the support mapping.
TimeOfContact timeOfContact(const Shape& a, const MotionChain& a_motion, const Shape& b, const MotionChain& b_motion,
                            const ContactOptions& options = {});

struct MinimumOptions {
  double tolerance = 1e-9;  ///< [m] accepted gap between the bounds
  double begin = 0.0;
  double end = 1.0;
  double stop_above = std::numeric_limits<double>::infinity();  ///< [m] of a larger minimum a proof is enough
  int max_queries = 512;                                        ///< of the distance, at one time; 2 to 512
};

/// The smallest signed distance of two moving shapes.
struct MinimumOverMotion {
  Status status = Status::Unknown;  ///< Threshold: lower_bound > stop_above
  double lower_bound = -std::numeric_limits<double>::infinity();
  double upper_bound = std::numeric_limits<double>::infinity();
  double time = std::numeric_limits<double>::quiet_NaN();  ///< of upper_bound
  SignedDistance at_minimum;                               ///< at that time, in the frame of the chains
  int queries = 0;
};

/// Smallest signed distance during a motion: branch and bound over time, the interval with the smallest lower bound
/// first. An interval's bound is what the normals at both of its ends prove, and an axis that turns from one to the
/// other.
///
/// Frame, failure: as timeOfContact.
/// Source: Piyavskii, An algorithm for finding the absolute extremum of a function, 1972, with bounds of second order.
MinimumOverMotion minimumDistance(const Shape& a, const MotionChain& a_motion, const Shape& b,
                                  const MotionChain& b_motion, const MinimumOptions& options = {});

}  // namespace proximity_server::narrowphase
