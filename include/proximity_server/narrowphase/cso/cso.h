#pragma once

#include "proximity_server/narrowphase/query_types.h"
#include "proximity_server/narrowphase/shape/support.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <limits>

namespace proximity_server::narrowphase {

/// Vertex of the configuration space obstacle (CSO, Minkowski difference) A - B of two cores, with its point on a.
struct CsoVertex {
  Eigen::Vector3d point;  ///< the point on a minus that on b
  Eigen::Vector3d on_a;
  WarmStart::Pair numbers;  ///< vertex numbers of the two points, if the cores are polytopes
  Eigen::Vector3d onB() const { return on_a - point; }
};

/// [m] Bound of the rounding error of a CSO vertex: of its coordinate along a unit vector, and of its norm.
///
/// To first order in eps, with r the reach of a shape from its origin and t the offset: a support point has an error of
/// 2 eps r, its rotation adds 3 eps r, the sums add 2 eps and the dot product or norm 2 eps of their terms. The constant
/// is 8: src/narrowphase/BOUNDS.md derives what it covers, and says where the worst case of all roundings together, which
/// was never met, is larger. |t|_1 is used for |t|, as it is never less; margins are added to the sums last.
inline double csoRounding(const Shape& a, const Shape& b, const Eigen::Isometry3d& a_T_b) {
  const double reach = a.coreReach() + b.coreReach() + a.margin() + b.margin();
  return 8.0 * std::numeric_limits<double>::epsilon() * (reach + a_T_b.translation().lpNorm<1>());
}

/// [m] Width of the bounds at which a search ends. It is smaller than the tolerance, as the search on a polytope ends
/// on a true face, edge or vertex of the CSO, and Newton's method on a curve doubles the digits with each step; so the
/// extra accuracy costs little, and the normal needs it: its error may be the root of 2 width / distance [rad]. It is
/// never below three roundings, two of which are part of the bounds: a new vertex could then seem to lie behind the
/// simplex.
inline double finalWidth(double tolerance, double rounding) {
  return std::max(3.0 * rounding, std::min(tolerance, 4.0 * rounding));
}

/// The CSO of two cores, by its support mapping.
/// Frame: the frame of a.
class Cso {
 public:
  /// `warm_start` holds the simplex of the last query. All arguments must outlive the CSO.
  Cso(const Shape& a, const Shape& b, const Eigen::Isometry3d& a_T_b, double rounding, WarmStart& warm_start)
      : a_(a),
        b_(b),
        a_T_b_(a_T_b),
        warm_start_(warm_start),
        rounding_(rounding),
        is_polytope_(a.isPolytope() && b.isPolytope()) {}

  /// Vertex of the CSO farthest along `direction`. If the direction points from a to b, it is the difference of the
  /// point of a nearest to b and the point of b nearest to a, along this direction.
  ///
  /// It is inlined everywhere, as its result would pass through memory, and be read there in other pieces than it was
  /// written in, which the processor must wait for: 4 % of a query of two boxes apart.
  [[gnu::always_inline]] CsoVertex vertex(const Eigen::Vector3d& direction) {
    int on_a_number = 0, on_b_number = 0;
    const Eigen::Vector3d on_a = supportPoint(a_, direction, on_a_number);
    const Eigen::Vector3d towards_a = -(bAxes().transpose() * direction);
    const Eigen::Vector3d on_b = supportPoint(b_, towards_a, on_b_number);
    newest_ = {on_a_number, on_b_number};
    return vertexFrom(on_a, on_b, {on_a_number, on_b_number});
  }

  /// A vertex of the simplex with which the last query ended; only if the cores are polytopes.
  CsoVertex recalled(const WarmStart::Pair& numbers) const {
    return vertexFrom(vertexOf(a_, numbers.a), vertexOf(b_, numbers.b), numbers);
  }

  /// Numbers of the two points of the vertex that was found last.
  const WarmStart::Pair& newestNumbers() const { return newest_; }

  WarmStart& warmStart() { return warm_start_; }

  /// The vector from the centre of a's core to the centre of b's core.
  Eigen::Vector3d centreDifference() const { return bAxes() * b_.centre() + bOrigin() - a_.centre(); }

  double finalWidth(double tolerance) const { return narrowphase::finalWidth(tolerance, rounding_); }

  /// [m] See csoRounding().
  double rounding() const { return rounding_; }

  bool isPolytope() const { return is_polytope_; }
  const Shape& a() const { return a_; }
  const Shape& b() const { return b_; }
  const Eigen::Isometry3d& pose() const { return a_T_b_; }  ///< coordinates of b into a
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
  WarmStart::Pair newest_{0, 0};
  double rounding_;
  bool is_polytope_;
};

}  // namespace proximity_server::narrowphase
