#pragma once

#include "narrowphase/motion/motion_path.h"

namespace proximity_server::narrowphase {

/// Lower bound of the signed distance between two times: the chord between the gaps along an axis at both times, less a
/// parabola. The axis may change linearly from one unit normal to another.
///
/// 1. A point p of the CSO has the height f = m . p along the axis m, with f'' = m . p'' + 2 m' . p'.
/// 2. If f'' <= c, then f lies above its chord less c / 2 t (duration - t).
/// 3. The gap is the smallest f of all points, so it lies above its own chord less the same parabola.
/// 4. Between the times the axis is shorter than 1, so the bound is divided by its length: if the gap is negative this
///    makes the bound lower; if it is positive the gap itself is a bound.
class AxisBound {
 public:
  struct End {
    const Eigen::Vector3d& normal;
    double gap;  ///< [m]
  };
  /// `motion` bounds the motion of all points of b relative to all points of a.
  AxisBound(const End& begin, const End& end, const MotionBound& motion, double duration);

  /// The first time, counted from the beginning, at which the bound falls to `level`. Returns the duration if it never
  /// does, and 0 if the bound is not above the level at the beginning.
  double firstTimeAt(double level) const;

  /// The time, counted from the beginning, at which the bound is smallest.
  double lowestTime() const;

  /// [m] The bound at a time counted from the beginning.
  double at(double time) const;

  double duration() const { return duration_; }
  double begin() const { return begin_; }
  double end() const { return end_; }

 private:
  double slope() const { return (end_ - begin_) / duration_ - 0.5 * curvature_ * duration_; }

  double begin_, end_, duration_;
  double curvature_;  ///< [m] per unit of time squared: c of the parabola
  double shortest_;   ///< smallest length of the axis
};

/// Two shapes that move along chains: poses, distances and bounds at any time.
///
/// Frame: the axes are parallel to the common frame of the chains; the origin is at the start of a's chain, so that the
///        numbers are small.
class MovingPair {
 public:
  struct Poses {
    ScrewPath::Pose a, b;
  };

  /// All arguments must outlive the pair.
  MovingPair(const Shape& a, const MotionChain& a_motion, const Shape& b, const MotionChain& b_motion);

  /// True if all numbers of both motions are finite, and all screws begin with a pose that rigidPose() accepts.
  bool isRigid() const;

  Poses at(double time) const { return {a_path_.at(time), b_path_.at(time)}; }

  /// The signed distance, with bounds that allow for the rounding of the poses.
  SignedDistance distance(const Poses& poses, const Options& options);

  /// [m] Gap between the support planes of a and b along the unit `normal`, a lower bound of the signed distance.
  double gapAlong(const Eigen::Vector3d& normal, const Poses& poses);

  /// Bounds of the motion of all points of b relative to all points of a, during an interval.
  MotionBound motion(double begin, double end) const;

  /// Moves the points of a result into the common frame of the chains.
  SignedDistance inChainsFrame(SignedDistance result) const;

 private:
  const Shape &a_, &b_;
  const MotionChain &a_motion_, &b_motion_;
  Eigen::Vector3d origin_;
  MotionPath a_path_, b_path_;
  double rounding_;  ///< [m] rounding error of a distance that comes from the poses
  WarmStart warm_start_;
  int vertex_a_ = 0, vertex_b_ = 0;  ///< support vertices of the last gapAlong()
};

/// Runs a search on two moving shapes. The answer is empty if a motion is not rigid, or if the options have no interval
/// within [0, 1].
template <typename Search, typename Options>
auto searched(const Shape& a, const MotionChain& a_motion, const Shape& b, const MotionChain& b_motion,
              Options options) {
  MovingPair pair(a, a_motion, b, b_motion);
  using Answer = decltype(Search(pair, options).run());
  const bool is_interval = 0.0 <= options.begin && options.begin <= options.end && options.end <= 1.0;
  if (!pair.isRigid() || !is_interval) return Answer();
  options.tolerance = usableTolerance(options.tolerance);
  return Search(pair, options).run();
}

}  // namespace proximity_server::narrowphase
