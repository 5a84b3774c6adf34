#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <limits>

#include "proximity_server/narrowphase/query_types.h"
#include "proximity_server/narrowphase/shape/support.h"

namespace proximity_server::narrowphase {

/// Vertex of the configuration space obstacle (Minkowski difference) A - B of two cores, with the points that made it.
struct CsoVertex {
  Eigen::Vector3d point;  ///< the point on a minus that on b
  Eigen::Vector3d on_a;
  WarmStart::Pair numbers;  ///< of the points, where the cores are polytopes
  Eigen::Vector3d onB() const { return on_a - point; }
};

/// [m] what rounding may add to or take from the coordinate of a CSO vertex along a unit vector, or from its norm.
///
/// To first order in eps, with r how far a shape reaches from its origin and t the offset: a support point is off by
/// 2 eps r, its rotation by 3 eps r, the sums by 2 eps and the dot product or norm by 2 eps of what they add up: less
/// than 8 eps of it all. |t|_1 is never less than |t|, and margins join the sums last.
inline double csoRounding(const Shape& a, const Shape& b, const Eigen::Isometry3d& a_T_b) {
  const double reach = a.coreReach() + b.coreReach() + a.margin() + b.margin();
  return 8.0 * std::numeric_limits<double>::epsilon() * (reach + a_T_b.translation().lpNorm<1>());
}

/// The CSO of two cores by its support mapping. Frame: that of a.
class Cso {
 public:
  /// `warm_start` gives the first vertices of large hulls, and takes the last. All arguments outlive the CSO.
  Cso(const Shape& a, const Shape& b, const Eigen::Isometry3d& a_T_b, double rounding, WarmStart& warm_start)
      : a_(a),
        b_(b),
        a_T_b_(a_T_b),
        warm_start_(warm_start),
        rounding_(rounding),
        is_polytope_(a.isPolytope() && b.isPolytope()) {}

  /// Vertex farthest along `direction`: the one that A shows towards B when direction is the normal a to b.
  CsoVertex vertex(const Eigen::Vector3d& direction) {
    const Eigen::Vector3d on_a = supportPoint(a_, direction, warm_start_.vertex_a);
    const Eigen::Vector3d towards_a = -(bAxes().transpose() * direction);
    const Eigen::Vector3d on_b = supportPoint(b_, towards_a, warm_start_.vertex_b);  // before its number is read
    return vertexFrom(on_a, on_b, {warm_start_.vertex_a, warm_start_.vertex_b});
  }

  /// A vertex of the simplex that the last query ended with; only where the cores are polytopes.
  CsoVertex recalled(const WarmStart::Pair& numbers) const {
    return vertexFrom(vertexOf(a_, numbers.a), vertexOf(b_, numbers.b), numbers);
  }

  WarmStart& warmStart() { return warm_start_; }

  /// From the centre of a's core to that of b's.
  Eigen::Vector3d centreDifference() const { return bAxes() * b_.centre() + bOrigin() - a_.centre(); }

  /// [m] the gap between the bounds at which a search may end, if it gets there: better than the tolerance, as a search
  /// on a polytope ends on a true face, edge or vertex, and Newton's method on a curve doubles the digits. Below three
  /// roundings, two of which are the bounds' own, a vertex may lie behind the simplex that it should lie beyond.
  double finalGap(double tolerance) const {
    return std::max(3.0 * rounding_, std::min(tolerance, (is_polytope_ ? 4.0 : 1024.0) * rounding_));
  }

  /// [m] see csoRounding.
  double rounding() const { return rounding_; }

  bool isPolytope() const { return is_polytope_; }
  const Shape& a() const { return a_; }
  const Shape& b() const { return b_; }
  Eigen::Isometry3d::ConstLinearPart bAxes() const { return a_T_b_.linear(); }
  Eigen::Isometry3d::ConstTranslationPart bOrigin() const { return a_T_b_.translation(); }

 private:
  CsoVertex vertexFrom(const Eigen::Vector3d& on_a, const Eigen::Vector3d& on_b, const WarmStart::Pair& numbers) const {
    return {on_a - (bAxes() * on_b + bOrigin()), on_a, numbers};
  }

  const Shape& a_;
  const Shape& b_;
  const Eigen::Isometry3d& a_T_b_;
  WarmStart& warm_start_;
  double rounding_;
  bool is_polytope_;
};

}  // namespace proximity_server::narrowphase
