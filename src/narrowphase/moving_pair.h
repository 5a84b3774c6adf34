#pragma once

#include "proximity_server/narrowphase/motion.h"

namespace proximity_server {

/// Two shapes that move along chains, at any time.
///
/// Frame: that of the chains, moved to where a's chain begins, so that its numbers are small.
class MovingPair {
 public:
  struct Poses {
    Eigen::Isometry3d a, b;
  };

  /// All arguments outlive it.
  MovingPair(const Shape& a, const MotionChain& a_motion, const Shape& b, const MotionChain& b_motion);

  /// Whether all of the motion is.
  bool isFinite() const;

  Poses at(double time) const;

  /// The signed distance, with bounds that allow for the rounding of the poses.
  SignedDistance distance(const Poses& poses, const Options& options);

  /// [m] No point of b is nearer to a than this along the unit `normal`: a lower bound of the signed distance.
  double gapAlong(const Eigen::Vector3d& normal, const Poses& poses);

  /// [m] per unit of time squared: at most that of any point of b as seen from any of a, during an interval.
  double acceleration(double begin, double end) const;

  /// A result as the caller sees it.
  SignedDistance inChainsFrame(SignedDistance result) const;

 private:
  Eigen::Isometry3d poseAt(const MotionChain& chain, double time) const;

  const Shape &a_, &b_;
  const MotionChain &a_motion_, &b_motion_;
  Eigen::Vector3d origin_;
  double rounding_;  ///< [m] of a distance, by the poses
  WarmStart warm_start_;
};

/// What the gap along one axis is at least in between two times, as the sum of the chord between its values at both and
/// of a parabola for the acceleration.
///
/// No point of b moves towards a along the axis faster than its chord by more than that: the second derivative of its
/// position along the axis is at most the acceleration. The gap is the least over all points, so it keeps the bound.
struct AxisBound {
  double begin, end;    ///< [m] gap at both times
  double acceleration;  ///< [m] per unit of time squared
  double duration;

  double at(double time) const {
    return begin + (end - begin) * (time / duration) - 0.5 * acceleration * time * (duration - time);
  }

  /// The first time, counted from the beginning, at which the bound is down to `level`, which is below `begin`;
  /// `duration` where it never is.
  double firstTimeAt(double level) const;

  /// When the bound is smallest.
  double lowestTime() const;
};

}  // namespace proximity_server
