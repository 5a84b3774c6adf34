#pragma once

#include "oracle/oracle.h"
#include "proximity_server/narrowphase/motion/motion.h"

#include <functional>
#include <limits>
#include <optional>

namespace proximity_server::narrowphase {

/// A pose in long double; the doubles of the first one of a chain are taken as they are.
struct LongPose {
  Matrix3l rotation = Matrix3l::Identity();
  Vector3l translation = Vector3l::Zero();

  LongPose operator*(const LongPose& other) const;
  Vector3l operator*(const Vector3l& point) const { return rotation * point + translation; }

  /// Its inverse where the rotation is exact; of one with the rounding of a double, off by that.
  LongPose inverse() const;

  Eigen::Isometry3d rounded() const;
};

/// A pose as the doubles say it, but for their rounding: the rotation nearest to the matrix.
LongPose longPose(const Eigen::Isometry3d& pose);

/// The start, turned and moved in the frame that it is given in. Method: Rodrigues' rotation, and the way of the origin
/// split along the axis and across it: v_along t + v_across sin(w t) / w + (u x v) (1 - cos(w t)) / w, which cancels
/// nothing.
LongPose exactPoseAt(const ScrewMotion& screw, long double time);
LongPose exactPoseAt(const MotionChain& chain, long double time);

/// Two shapes in motion.
struct MovingPair {
  const Shape& a;
  const MotionChain& a_motion;
  const Shape& b;
  const MotionChain& b_motion;

  /// a_T_b.
  LongPose relativePose(long double time) const;

  /// No point of one shape moves faster, seen from the other [m per unit of time]: the sum over all screws of
  /// |linear| + |angular| * reach, the reach from that screw's frame to the far end of the shape.
  long double speedLimit() const;

  /// [m] What rounding may cost an answer in double, in a frame that is moved to where a begins: the entries of all
  /// poses, and angles of many turns, by a few epsilon each.
  double rounding() const;
};

/// Bounds of a signed distance [m].
struct DistanceBounds {
  long double low = -std::numeric_limits<long double>::infinity();
  long double high = std::numeric_limits<long double>::infinity();
};

/// Signed distance at one time by branch and bound in long double; milliseconds.
///
/// The pose is rounded to double: an entry of the rotation by u = epsilon / 2 of itself, one of the translation by u of
/// itself. So a point of b, which is no farther than scale() from a's origin, moves by at most u (sqrt(3) + 1) scale:
/// the bounds are widened by 2 epsilon scale, 4e-16 m for shapes of a metre.
DistanceBounds exactDistanceAt(const MovingPair& pair, long double time, int max_cells = 200000);

/// Bounds of the same distance by signedDistance() of the library, widened by their rounding; microseconds. Not
/// independent of the narrowphase at one time, which has a stress run of its own, but of all that moves.
DistanceBounds fastDistanceAt(const MovingPair& pair, long double time, double tolerance = 1e-13);

/// A signed distance as a function of time, and how fast it may change.
struct DistanceOverTime {
  std::function<DistanceBounds(long double)> at;
  long double speed_limit;
};

struct TimeInterval {
  long double begin = 0;
  long double end = 1;
};

/// The first time at which the distance is no more than the contact distance.
struct FirstContact {
  long double free_until;                 ///< proven: above the contact distance from the begin to here
  std::optional<long double> contact_by;  ///< at or below the contact distance here, so the first time is in between

  bool never(const TimeInterval& interval) const { return free_until >= interval.end; }
};

/// First contact by the Lipschitz bound alone: from a time with a gap g nothing can happen for g / speed_limit.
///
/// Error:   contact_by - free_until is what the contact distance less `resolution` [m] leaves open. Grazing closer than
///          it has neither proof: never() is false and there is no contact_by.
/// Cost:    speed_limit / gap steps for each unit of time; the search gives up after max_steps, with what is proven.
FirstContact firstContact(const DistanceOverTime& distance, long double contact_distance,
                          const TimeInterval& interval = {}, long double resolution = 1e-12L, int max_steps = 2000000);

/// Encloses the smallest distance: branch and bound with the Lipschitz bound, until the bounds are `gap` apart.
/// Source: Piyavskii, An algorithm for finding the absolute extremum of a function, 1972.
DistanceBounds smallestDistance(const DistanceOverTime& distance, long double gap, const TimeInterval& interval = {});

/// A local minimum of the upper bound by golden sections in [begin, end]: the best time that was seen.
long double timeOfLocalMinimum(const DistanceOverTime& distance, const TimeInterval& interval, int sections = 60);

}  // namespace proximity_server::narrowphase
