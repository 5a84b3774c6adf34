#include "stress/scene_truth.h"

#include "oracle/exact_oracle.h"
#include "oracle/refined_truth.h"
#include "proximity_server/narrowphase/signed_distance.h"
#include "stress/random_geometry.h"

#include <algorithm>
#include <cmath>
#include <sstream>

namespace proximity_server::scene {

using namespace narrowphase;
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

constexpr double kEpsilon = std::numeric_limits<double>::epsilon();

Vector3l centreOf(const WorldPart& part) {
  return part.world_T_part * Vector3l(part.shape.centre().cast<long double>());
}

/// [m] The rounding of the places of two parts in long double.
long double roundingOf(const WorldPart& a, const WorldPart& b) {
  return 1e-18L * (a.world_T_part.translation.norm() + b.world_T_part.translation.norm());
}

/// No point of one sphere is nearer to the other than `low`, and the centres are parts of the shapes.
DistanceBounds bySpheres(const WorldPart& a, const WorldPart& b) {
  const long double between = (centreOf(b) - centreOf(a)).norm();
  const long double rounding = 1e-15L * (radiusOf(a.shape) + radiusOf(b.shape)) + roundingOf(a, b);
  return {between - radiusOf(a.shape) - radiusOf(b.shape) - rounding, between + rounding};
}

/// The pose is rounded to double: see exactDistanceAt().
DistanceBounds widened(long double low, long double high, const ShapePair& pair) {
  const long double rounding = 2.0L * kEpsilon * pair.scale();
  return {low - rounding, high + rounding};
}

DistanceBounds byRefinement(const WorldPart& a, const WorldPart& b, const Isometry3d& a_T_b) {
  const ShapePair pair{a.shape, b.shape, a_T_b};
  const SignedDistance guess = signedDistance(a.shape, b.shape, a_T_b);
  const RefinedTruth truth = refinedTruth(pair, guess.normal, guess.distance);
  const long double high = std::min<long double>(truth.distance + truth.error_bound, guess.upper_bound);
  return widened(truth.distance, high, pair);
}

PartsApart measured(const WorldPart& a, const WorldPart& b) {
  PartsApart parts{&a, &b, (a.world_T_part.inverse() * b.world_T_part).rounded()};
  parts.distance = byRefinement(a, b, parts.a_T_b);
  parts.distance.low -= roundingOf(a, b);
  parts.distance.high += roundingOf(a, b);
  return parts;
}

/// The height of a part's lowest point above a plane, computed in long double.
DistanceBounds aboveThePlane(const WorldPart& part, const WorldPlane& plane) {
  const Vector3l down = -(part.world_T_part.rotation.transpose() * plane.normal);
  const Vector3l lowest = part.world_T_part * coreSupport(part.shape, down);
  const long double height = plane.normal.dot(lowest) - plane.offset - part.shape.margin();
  const long double rounding = 1e-18L * (lowest.norm() + std::abs(plane.offset));
  return {height - rounding, height + rounding};
}

/// The signed distance of the ball within a representative from the solid inside of a closed mesh. Interior, which has
/// its own tests, tells the side and the nearest triangle; the poses and radii are computed here.
DistanceBounds insideOfTheMesh(const WorldPart& solid, const WorldPart& representative) {
  const Vector3l centre = solid.world_T_part.inverse() * centreOf(representative);
  const Interior::Place place = solid.interior->placeOf(centre.cast<double>());
  const long double radius =
      std::max(0.0, representative.shape.innerRadius()) + representative.shape.margin() + solid.shape.margin();
  const long double rounding = 16.0L * kEpsilon * (centre.norm() + solid.interior->box().diagonal().norm() + radius);
  return {place.lower_bound - radius - rounding, place.upper_bound - radius + rounding};
}

/// Parts farther than this, and than the nearest ones by their spheres, are measured by their spheres.
PairTruth truthOf(const ShapeRefPair& pair, const std::optional<WorldSolid>& a, const std::optional<WorldSolid>& b,
                  double padding, double near) {
  PairTruth truth{pair};
  if (!a || !b) return truth;
  truth.is_known = true;
  DistanceBounds& all = truth.distance;
  const auto offer = [&](const DistanceBounds& distance) {
    all.low = std::min(all.low, distance.low);
    all.high = std::min(all.high, distance.high);
  };
  for (const WorldPart& part_a : a->parts)
    for (const WorldPart& part_b : b->parts) {
      const DistanceBounds rough = bySpheres(part_a, part_b);
      if (rough.low > all.high) continue;
      if (rough.low > near) {
        offer(rough);
        continue;
      }
      const PartsApart parts = measured(part_a, part_b);
      if (parts.distance.high < all.high) truth.nearest = parts;
      offer(parts.distance);
    }
  const auto offerPlanes = [&](const WorldSolid& solid, const WorldSolid& other) {
    for (const WorldPart& part : solid.parts)
      for (const WorldPlane& plane : other.planes) {
        const DistanceBounds height = aboveThePlane(part, plane);
        if (height.high < all.high) truth.nearest = {};
        offer(height);
      }
  };
  const auto findInteriorDepths = [&](const WorldSolid& solid, const WorldSolid& other) {
    for (const WorldPart& part : solid.parts)
      for (const WorldPart& representative : other.parts) {
        if (!part.interior || !representative.is_representative) continue;
        const DistanceBounds depth = insideOfTheMesh(part, representative);
        if (depth.high < std::min(0.0L, all.high)) truth.nearest = {};
        if (depth.low < 0) all.low = std::min(all.low, depth.low);
        if (depth.high < 0) all.high = std::min(all.high, depth.high);
      }
  };
  findInteriorDepths(*a, *b);
  findInteriorDepths(*b, *a);
  offerPlanes(*a, *b);
  offerPlanes(*b, *a);
  all.low -= padding;
  all.high -= padding;
  return truth;
}

std::string nameOf(const SceneCell& cell, const ShapeRef& ref) {
  if (ref.isLink()) return cell.model()->robot.links[ref.link()].name;
  return cell.objects()->object(ref.object())->id;
}

}  // namespace

bool hasObject(const ShapeRefPair& pair) { return !pair.areLinks(); }

bool isOfKind(const ShapeRefPair& pair, PairKind kind) {
  return kind == PairKind::Any || hasObject(pair) == (kind == PairKind::WithObject);
}

StateTruth::StateTruth(SceneCell& cell) : cell_(cell) {
  const double near = cell.chance().below(8) == 0 ? std::numeric_limits<double>::infinity() : 0.3 * cell.size();
  for (const ShapeRefPair& pair : cell.checkedPairs()) {
    known_[namesOf(pair)] = static_cast<int>(pairs_.size());
    pairs_.push_back(truthOf(pair, solidOf(pair.a), solidOf(pair.b), cell.paddingOf(pair), near));
  }
}

StateTruth::Names StateTruth::namesOf(const ShapeRefPair& pair) {
  const auto name = [](const ShapeRef& ref) { return std::make_pair(ref.link(), ref.isObject() ? ref.object() : -1); };
  return std::tuple_cat(std::min(name(pair.a), name(pair.b)), std::max(name(pair.a), name(pair.b)));
}

const PairTruth* StateTruth::find(const ShapeRefPair& pair) const {
  const auto found = known_.find(namesOf(pair));
  return found == known_.end() ? nullptr : &pairs_[found->second];
}

PairTruth StateTruth::of(const ShapeRefPair& pair) {
  return truthOf(pair, solidOf(pair.a), solidOf(pair.b), cell_.paddingOf(pair), kFar);
}

const std::optional<WorldSolid>& StateTruth::solidOf(const ShapeRef& ref) {
  const auto [found, is_new] = solids_.try_emplace(std::make_pair(ref.link(), ref.isObject() ? ref.object() : -1));
  if (is_new) found->second = cell_.solidOf(ref);
  return found->second;
}

DistanceBounds byOracle(const PartsApart& parts) {
  const ShapePair pair{parts.a->shape, parts.b->shape, parts.a_T_b};
  if (hasPolytopeCore(pair.a) && hasPolytopeCore(pair.b)) {
    const long double exact = exactDistance(pair).withMargins(pair);
    return widened(exact, exact, pair);
  }
  const Truth truth = signedDistanceOracle(pair, /*max_cells=*/4000);
  return widened(truth.distance, truth.distance + truth.error_bound, pair);
}

std::string nameOf(const SceneCell& cell, const ShapeRefPair& pair) {
  return nameOf(cell, pair.a) + " and " + nameOf(cell, pair.b);
}

std::string by(long double metres) {
  std::ostringstream text;
  text.precision(6);
  text << " by " << static_cast<double>(metres) << " m";
  return text.str();
}

std::string problemOf(const SignedDistance& result, const PairTruth& truth, double tolerance, double rounding) {
  if (!truth.is_known) return result.status == Status::Unknown ? "" : "has a distance without a pose";
  if (result.status == Status::Unknown) return "is unknown";
  const long double above = result.lower_bound - truth.distance.high - rounding;
  const long double below = truth.distance.low - result.upper_bound - rounding;
  if (above > 0) return "has a lower bound that is above the distance" + by(above);
  if (below > 0) return "has an upper bound that is below the distance" + by(below);
  const double width = result.upper_bound - result.lower_bound;
  if (result.status == Status::Converged && !(width <= tolerance))
    return "converged, but its bounds are" + by(width) + " apart";
  if (!result.has_points) return "";
  const double off = (result.point_a + result.distance * result.normal - result.point_b).norm();
  if (off > 16.0 * kEpsilon * (result.point_a.norm() + std::abs(result.distance)))
    return "has a point_b that is not point_a + distance * normal," + by(off) + " off";
  return "";
}

}  // namespace proximity_server::scene
