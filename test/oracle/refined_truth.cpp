#include "oracle/refined_truth.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>

namespace proximity_server::narrowphase {
namespace {

constexpr long double kInfinity = std::numeric_limits<long double>::infinity();

/// The CSO b - a of the cores, with b moved by `shift`.
class ShiftedCso {
 public:
  ShiftedCso(const ShapePair& pair, const Vector3l& shift)
      : pair_(pair),
        rotation_(pair.a_T_b.linear().cast<long double>()),
        translation_(pair.a_T_b.translation().cast<long double>() + shift) {}

  Vector3l lowest(const Vector3l& n) const {
    const Vector3l on_b = rotation_ * coreSupport(pair_.b, -(rotation_.transpose() * n));
    return on_b + translation_ - coreSupport(pair_.a, n);
  }

 private:
  const ShapePair& pair_;
  Matrix3l rotation_;
  Vector3l translation_;
};

/// Up to four points, and the point of their convex hull that is nearest to the origin.
struct Corners {
  std::array<Vector3l, 4> points;
  std::size_t size = 0;
  Vector3l nearest = Vector3l::Constant(kInfinity);
};

/// Foot of the perpendicular from the origin to the affine hull of the points; infinite where it lies outside of them.
template <int edges>
Vector3l footInside(const Corners& part) {
  Eigen::Matrix<long double, 3, edges> e;
  for (int i = 0; i < edges; ++i) e.col(i) = part.points[static_cast<std::size_t>(i) + 1] - part.points[0];
  const Eigen::Matrix<long double, edges, edges> gram = e.transpose() * e;
  const Eigen::Matrix<long double, edges, 1> weights = gram.inverse() * -(e.transpose() * part.points[0]);
  const bool inside = weights.minCoeff() >= 0 && weights.sum() <= 1;
  return inside ? Vector3l(part.points[0] + e * weights) : Vector3l::Constant(kInfinity);
}

Vector3l footInside(const Corners& part) {
  switch (part.size) {
    case 1:
      return part.points[0];
    case 2:
      return footInside<1>(part);
    case 3:
      return footInside<2>(part);
    default:
      return footInside<3>(part);
  }
}

/// The part of the simplex with the nearest foot; only parts with the newest, last point are nearer than before.
Corners reduced(const Corners& simplex) {
  Corners best;
  const std::size_t others = simplex.size - 1;
  for (unsigned subset = 0; subset < 1u << others; ++subset) {
    Corners part;
    part.points[part.size++] = simplex.points[others];
    for (std::size_t i = 0; i < others; ++i)
      if ((subset >> i & 1u) != 0) part.points[part.size++] = simplex.points[i];
    part.nearest = footInside(part);
    if (part.nearest.squaredNorm() < best.nearest.squaredNorm()) best = part;
  }
  return best;
}

struct Enclosure {
  long double lower = -kInfinity;  ///< the support plane of `normal` leaves this much
  long double upper = kInfinity;   ///< there is a point of the CSO this near
  Vector3l normal;
};

Enclosure distanceOf(const ShiftedCso& cso, const Vector3l& guess, long double rounding) {
  Enclosure found;
  Corners simplex;
  Vector3l n = guess;
  for (int i = 0; i < 200; ++i) {
    const Vector3l w = cso.lowest(n);
    if (w.dot(n) > found.lower) {
      found.lower = w.dot(n);
      found.normal = n;
    }
    if (found.upper - found.lower <= rounding || simplex.size == 4) break;
    simplex.points[simplex.size++] = w;
    const Corners next = reduced(simplex);
    if (!(next.nearest.norm() < found.upper)) break;
    simplex = next;
    found.upper = simplex.nearest.norm();
    n = simplex.nearest / found.upper;
  }
  return found;
}

long double refinedGap(const ShapePair& pair, Vector3l n, long double shift, long double rounding) {
  long double best = pair.gapAlong(n);
  for (int i = 0; i < 8; ++i) {
    n = distanceOf(ShiftedCso(pair, shift * n), n, rounding).normal.normalized();
    const long double gap = pair.gapAlong(n);
    if (!(gap > best + rounding)) return std::max(best, gap);
    best = gap;
  }
  return best;
}

}  // namespace

RefinedTruth refinedTruth(const ShapePair& pair, const Eigen::Vector3d& normal, double distance) {
  const Vector3l n = normal.cast<long double>().normalized();
  const long double margins = static_cast<long double>(pair.a.margin()) + pair.b.margin();
  // As of signedDistanceOracle.
  const long double rounding = 16 * std::numeric_limits<long double>::epsilon() * pair.scale();
  if (distance + margins > 0) {
    const Enclosure cores = distanceOf(ShiftedCso(pair, Vector3l::Zero()), n, rounding);
    return {cores.lower - margins, cores.upper - cores.lower + rounding};
  }
  // The nearer to touching, the larger the step; a twentieth of the size keeps the axis exact.
  const long double shift = -(distance + margins) + 0.05L * (pair.a.coreRadius() + pair.b.coreRadius());
  return {refinedGap(pair, n, shift, rounding), kInfinity};
}

}  // namespace proximity_server::narrowphase
