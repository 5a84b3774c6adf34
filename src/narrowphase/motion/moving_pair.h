#pragma once

#include "narrowphase/motion/motion_path.h"

namespace proximity_server::narrowphase {

/// What the signed distance is at least in between two times: the chord between the gaps along an axis at both, less a
/// parabola. The axis may turn, straight from one unit normal to the other.
///
/// A point of the CSO at height f = m . p over the axis m has f'' = m . p'' + 2 m' . p'. Where f'' <= c, f lies above
/// its chord less c / 2 t (duration - t); the gap is the least f of all points, so it does too. The axis is shorter
/// than 1 in between, which makes a gap above 0 a larger distance and one below 0 a deeper overlap.
class AxisBound {
 public:
  struct End {
    const Eigen::Vector3d& normal;
    double gap;  ///< [m]
  };
  /// What bounds the motion of all points of b as seen from those of a, see MotionBound.
  AxisBound(const End& begin, const End& end, const MotionBound& motion, double duration);

  /// The first time, counted from the beginning, at which the bound is down to `level`, which is below it at first;
  /// the duration where it never is.
  double firstTimeAt(double level) const;

  /// When the bound is smallest, and how small.
  double lowestTime() const;
  double at(double time) const;

  double duration() const { return duration_; }
  double begin() const { return begin_; }
  double end() const { return end_; }

 private:
  double slope() const { return (end_ - begin_) / duration_ - 0.5 * curvature_ * duration_; }

  double begin_, end_, duration_;
  double curvature_;  ///< [m] per unit of time squared
  double shortest_;   ///< the axis
};

/// Whether an interval of time lies within [0, 1].
inline bool isInterval(double begin, double end) { return 0.0 <= begin && begin <= end && end <= 1.0; }

/// Two shapes that move along chains, at any time.
///
/// Frame: that of the chains, moved to where a's chain begins, so that its numbers are small.
class MovingPair {
 public:
  struct Poses {
    ScrewPath::Pose a, b;
  };

  /// All arguments outlive it.
  MovingPair(const Shape& a, const MotionChain& a_motion, const Shape& b, const MotionChain& b_motion);

  /// Whether all of the motion is.
  bool isFinite() const;

  Poses at(double time) const { return {a_path_.at(time), b_path_.at(time)}; }

  /// The signed distance, with bounds that allow for the rounding of the poses.
  SignedDistance distance(const Poses& poses, const Options& options);

  /// [m] No point of b is nearer to a than this along the unit `normal`: a lower bound of the signed distance.
  double gapAlong(const Eigen::Vector3d& normal, const Poses& poses);

  /// Of all points of b as seen from those of a, during an interval.
  MotionBound motion(double begin, double end) const;

  /// A result as the caller sees it.
  SignedDistance inChainsFrame(SignedDistance result) const;

 private:
  const Shape &a_, &b_;
  const MotionChain &a_motion_, &b_motion_;
  Eigen::Vector3d origin_;
  MotionPath a_path_, b_path_;
  double rounding_;  ///< [m] of a distance, by the poses
  WarmStart warm_start_;
  int vertex_a_ = 0, vertex_b_ = 0;  ///< of the last gap along a normal, mostly at another time than the distance
};

}  // namespace proximity_server::narrowphase
