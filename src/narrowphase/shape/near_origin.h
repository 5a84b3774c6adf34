#pragma once

#include "proximity_server/narrowphase/shape/shape.h"

#include <Eigen/Geometry>

namespace proximity_server::narrowphase {

/// A pair of shapes in which hulls that are far from the origins of their frames are moved to them: the distance is the
/// same, and the numbers are smaller, so they are rounded less.
///
/// A hull a is moved by -p, b by -q, where p and q are vertices of them; for a shape that is not far, p or q is 0. A
/// point y of b is at R y + t in the frame of a. Minus a point x of a this is
///   R (y - q) + (R q + t - p) - (x - p).
/// So the axes R and the direction of every normal stay unchanged, and the offset is the term in the second brackets.
///
/// Error: a distance, and a height along a unit vector, change by at most error(). With eps / 2 the unit roundoff, and
///        x - p, y - q within the reach of the moved shapes:
///        * Each coordinate of x - p and of y - q is rounded once. No point moves by more than eps / 2 of its distance
///          from the origin, the moved hull is the hull of the moved vertices, and the axes of a pose that is used as
///          it stands lengthen nothing by more than 32 eps. Together less than eps (reach_a + reach_b).
///        * A coordinate of the offset is a sum of five terms, three of them products, as if computed with twice the
///          digits: its error is eps / 2 of itself and (5 eps / 2)^2 / (1 - 5 eps) of the sum of the terms' sizes. The
///          sums of the three coordinates are a vector of at most sqrt(3) |q| + |t| + |p|. Together less than eps
///          |offset| + 16 eps^2 (|p| + |q| + |t|).
/// Source: Ogita, Rump, Oishi, Accurate Sum and Dot Product, SIAM J. Sci. Comput. 2005 (Dot2, Proposition 5.5).
class NearOrigin {
 public:
  /// Does not allocate.
  NearOrigin(const Shape& a, const Shape& b, const Eigen::Isometry3d& a_T_b);

  const Shape& a() const { return a_; }
  const Shape& b() const { return b_; }
  const Eigen::Isometry3d& pose() const { return pose_; }  ///< of the moved b in the frame of the moved a
  const Eigen::Vector3d& from() const { return p_; }       ///< p: the origin of the moved a, in the frame of a
  double error() const { return error_; }                  ///< [m]

 private:
  Eigen::Vector3d p_;
  Shape a_, b_;
  Eigen::Isometry3d pose_;
  double error_;
};

}  // namespace proximity_server::narrowphase
