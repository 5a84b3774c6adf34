#include "narrowphase/gjk_epa/epa.h"

#include "narrowphase/closed_form/parallel_axes.h"
#include "narrowphase/cso/polytope.h"
#include "narrowphase/curved/depth_about_axis.h"
#include "narrowphase/curved/inner_ellipsoid.h"
#include "narrowphase/curved/refinement.h"
#include "narrowphase/gjk_epa/epa_start.h"
#include "narrowphase/gjk_epa/gjk.h"
#include "proximity_server/narrowphase/angle.h"
#include "proximity_server/narrowphase/assertion.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

namespace proximity_server::narrowphase {
namespace {

using Eigen::Vector3d;

/// A direction refined by Newton's method, and the depth along it.
struct Refined {
  StationaryDirection stationary;
  double depth;
};

/// The simplex with w in front; refine() looks at the first three vertices that lie on different pieces.
Simplex withPiece(const CsoVertex& w, const Simplex& simplex) {
  Simplex result;
  result[0] = w;
  result.members = 1;
  for (int place = 0; place < 3; ++place) {
    if (!simplex.has(place)) continue;
    result[place + 1] = simplex[place];
    result.members |= 1u << (place + 1);
  }
  return result;
}

/// Refines `normal`. If the CSO reaches a little farther along the refined direction than the smooth pieces that
/// Newton's method knows, it is repeated with the piece that was missing, at most `pieces` times. Returns nullopt if
/// the steps do not converge, or if the CSO still reaches farther.
std::optional<Refined> refined(Cso& cso, const Simplex& simplex, const Vector3d& normal, int pieces = 3) {
  constexpr double kLittle = 1e-3;  // of the depth; beyond, the next face of the polytope is the better start
  const std::optional<StationaryDirection> stationary = refine(cso, simplex, normal);
  if (!stationary) return std::nullopt;
  const CsoVertex w = cso.vertex(stationary->normal);
  const double depth = stationary->normal.dot(w.point), beyond = depth - stationary->height;
  if (beyond <= cso.rounding()) return Refined{*stationary, depth};
  if (pieces == 0 || beyond > kLittle * depth) return std::nullopt;
  return refined(cso, withPiece(w, simplex), stationary->normal, pieces - 1);
}

void setDirection(const Refined& direction, EpaResult& result) {
  result.depth = direction.depth;
  result.normal = direction.stationary.normal;
  result.has_normal = result.has_points = true;
  result.point_a = direction.stationary.points.on_a;
  result.point_b = direction.stationary.points.on_b;
}

/// The result for an origin on the surface of the CSO.
EpaResult onSurface(Cso& cso, const Simplex& simplex, const SurfacePlane& plane, const Options& options) {
  const WitnessPoints witnesses = witnessPoints(simplex);
  EpaResult result;
  result.depth = plane.depth;
  result.normal = plane.normal;
  result.has_normal = result.has_points = true;
  result.point_a = witnesses.on_a;
  result.point_b = witnesses.on_b;
  if (!cso.isPolytope()) {
    const std::optional<Refined> direction = refined(cso, simplex, plane.normal);
    if (direction && direction->depth <= plane.depth + cso.rounding()) setDirection(*direction, result);
  }
  result.lower_bound = std::min(result.depth, 0.0) - cso.rounding();
  const bool converged = result.depth + cso.rounding() - result.lower_bound <= options.distance_tolerance;
  result.status = converged ? Status::Converged : Status::Degenerate;
  result.unique = !plane.two_sided;
  return result;
}

/// A point on_a - on_b of a face, and its distance from the point at the depth along the normal.
struct FacePoint {
  Vector3d on_a, on_b;
  double error;  ///< [m] this distance
};

/// The point where the ray from the origin along the normal meets a face, or a point of the face near the ray if it
/// passes beside the face.
FacePoint passage(const Polytope& polytope, const Polytope::Face& face, const EpaResult& result) {
  std::array<double, 3> weights = polytope.rayWeights(face, result.normal);
  double sum = 0.0;
  for (double& weight : weights) sum += weight = std::max(weight, 0.0);
  FacePoint point{Vector3d::Zero(), Vector3d::Zero(), 0.0};
  for (std::size_t i = 0; i < 3; ++i) {
    const CsoVertex& vertex = polytope.vertex(face.vertices[i]);
    point.on_a += weights[i] / sum * vertex.on_a;
    point.on_b += weights[i] / sum * vertex.onB();
  }
  point.error = (point.on_a - point.on_b - result.depth * result.normal).norm();
  return point;
}

/// The point of a triangle nearest to the point at the depth along the normal. Unlike passage(), it is accurate for a
/// face that is narrow or seen from its edge, too.
FacePoint nearestPoint(std::array<CsoVertex, 3> corners, const EpaResult& result) {
  const Vector3d target = result.depth * result.normal;
  for (CsoVertex& corner : corners) corner.point -= target;
  const WitnessPoints points = pointsOfTriangle(corners[0], corners[1], corners[2]);
  return {points.on_a, points.on_b - target, (points.on_a - points.on_b).norm()};
}

/// Sets the witness points by the point of the CSO nearest to the one at the depth along the normal. The ray along the
/// normal leaves the CSO below this point by at most the width of the bounds. has_points stays false if the point that
/// is found is farther away than nine tenths of the tolerance; the rest is for rounding.
void setPointsAtDepth(const Cso& cso, double tolerance, EpaResult& result) {
  const Vector3d way_out = result.depth * result.normal;
  Eigen::Isometry3d touching = cso.pose();
  touching.translation() += way_out;
  WarmStart none;
  Cso moved(cso.a(), cso.b(), touching, cso.rounding(), none);
  Options options;
  options.stop_below = 0.9 * tolerance;
  const GjkResult nearest = gjk(moved, result.normal, moved.vertex(result.normal), options);
  const bool is_apart = nearest.outcome == GjkResult::Outcome::Apart;
  if (!is_apart && nearest.simplex.members == 0b1111) return;
  const WitnessPoints points = is_apart ? nearest.points : witnessPoints(nearest.simplex);
  if (!((points.on_a - points.on_b).norm() <= options.stop_below)) return;
  result.has_points = true;
  result.point_a = points.on_a;
  result.point_b = points.on_b - way_out;
}

/// Sets the witness points to the point where the ray from the origin along the normal leaves the polytope: through the
/// face `guess`, or through the face with the nearest point. has_points stays false if this point is farther from the
/// one at the depth than the bounds and the tolerance allow.
void setWitnesses(const Polytope& polytope, const Polytope::Face* guess, const Options& options, EpaResult& result) {
  const double width = result.depth - result.lower_bound, accepted = width + options.distance_tolerance;
  const double enough = std::max(width, options.distance_tolerance);
  FacePoint best{Vector3d::Zero(), Vector3d::Zero(), std::numeric_limits<double>::infinity()};
  if (guess != nullptr) best = passage(polytope, *guess, result);
  // The ray may pass through another face in the same plane. Written as !(<=) so that NaN searches, too.
  if (!(best.error <= width)) {
    best.error = std::numeric_limits<double>::infinity();
    polytope.forEachFace([&](const Polytope::Face& face) {
      if (!(face.area.dot(result.normal) > 0.0)) return;
      // No point of a face that lies so far below the depth is near enough.
      const auto isBelow = [&](int v) { return result.normal.dot(polytope.vertex(v).point) < result.depth - enough; };
      if (std::all_of(face.vertices.begin(), face.vertices.end(), isBelow)) return;
      const FacePoint candidate = passage(polytope, face, result);
      if (candidate.error < best.error) best = candidate;
    });
  }
  // Points that are accepted may still widen the bounds beyond the tolerance.
  if (!(best.error <= enough)) {
    polytope.forEachFace([&](const Polytope::Face& face) {
      if (face.area.dot(result.normal) < 0.0) return;
      const auto& [a, b, c] = face.vertices;
      const FacePoint candidate = nearestPoint({polytope.vertex(a), polytope.vertex(b), polytope.vertex(c)}, result);
      if (candidate.error < best.error) best = candidate;
    });
  }
  result.has_points = best.error <= accepted;
  result.point_a = best.on_a;
  result.point_b = best.on_b;
}

/// Sets the witness points from the simplex with which GJK ended, for a polytope that rounding has spoilt before it
/// knew the face.
void setWitnesses(const Simplex& simplex, const Options& options, EpaResult& result) {
  const WitnessPoints points = witnessPoints(simplex);
  const double error = (points.on_a - points.on_b - result.depth * result.normal).norm();
  if (!(error <= result.depth - result.lower_bound + options.distance_tolerance)) return;
  result.has_points = true;
  result.point_a = points.on_a;
  result.point_b = points.on_b;
}

/// True if only directions near the normal have this depth, within the tolerance. Directions within 1e-2 rad count as
/// the same: on a curved CSO the depths of neighbouring faces differ by half the squared angle times the radius, which
/// may be less than the tolerance.
bool isUnique(const Polytope& polytope, const EpaResult& result, const Options& options) {
  constexpr double kSameDirection = 1e-2;
  bool unique = true;
  polytope.forEachFace([&](const Polytope::Face& face) {
    const bool is_as_close = face.isCloserThan(result.depth + options.distance_tolerance) &&
                             !face.isCloserThan(result.depth - options.distance_tolerance);
    if (is_as_close && (face.normal() - result.normal).squaredNorm() > kSameDirection * kSameDirection) unique = false;
  });
  return unique;
}

/// True if a direction beside the normal, or the opposite one, has this depth within the tolerance. The ellipsoid that
/// proves a depth says nothing about such directions, and the polytope has no faces there yet.
bool isInRing(Cso& cso, const EpaResult& result, const Options& options) {
  constexpr double kBeside = 1.1e-2;  // sine of the angle; more than kSameDirection of isUnique()
  const Vector3d u = result.normal.unitOrthogonal(), v = result.normal.cross(u);
  const auto isAsShallow = [&](const Vector3d& direction) {
    const Vector3d unit = direction.normalized();
    return unit.dot(cso.vertex(unit).point) <= result.depth + options.distance_tolerance;
  };
  if (isAsShallow(-result.normal)) return true;
  for (int i = 0; i < 8; ++i) {
    const auto [sine, cosine] = sineAndCosine(0.25 * i * M_PI);
    if (isAsShallow(result.normal + kBeside * (cosine * u + sine * v))) return true;
  }
  return false;
}

/// [m] A lower bound of the depth of two solids of revolution with nearly parallel axes; -infinity for other cores.
double depthByTilt(const Cso& cso) {
  constexpr double kNearlyParallel = 1e-3;  // [rad] for a larger tilt its square, times the size, exceeds any tolerance
  constexpr double kNone = -std::numeric_limits<double>::infinity();
  if (!isSolidOfRevolution(cso.a().kind()) || !isSolidOfRevolution(cso.b().kind())) return kNone;
  if (axesTilt(cso.a(), cso.b(), cso.pose()) > kNearlyParallel) return kNone;
  // The axes of b need not be perpendicular unit vectors to the last digit.
  const double skew = (cso.bAxes().transpose() * cso.bAxes() - Eigen::Matrix3d::Identity()).norm();
  const double reach = cso.a().coreReach() + cso.b().coreReach() + cso.bOrigin().norm();
  const double depth = depthOfTiltedAxes(cso.a(), cso.b(), cso.pose()) - 4.0 * cso.rounding() - skew * reach;
  return depth > 0.0 ? depth : kNone;
}

/// The shallowest direction found so far, and caps of directions in which the depth is proven to be at least the depth
/// of the direction in the middle of the cap.
class SmallestDepth {
 public:
  SmallestDepth(const Cso& cso, EpaResult& result) : result_(result), depth_inside_(depthByTilt(cso)) {}

  /// Refines the normal of a face of a curved CSO, and keeps the direction if it is the shallowest. Returns true if no
  /// direction near the face can be shallower; the face is set aside then.
  bool refineFrom(Cso& cso, Polytope& polytope, const Polytope::Face& face) {
    Simplex simplex;
    for (int i = 0; i < 3; ++i) simplex[i] = polytope.vertex(face.vertices[i]);
    simplex.members = 0b111;
    const std::optional<Refined> direction = refined(cso, simplex, face.normal());
    if (!direction) return false;
    const StationaryDirection& stationary = direction->stationary;
    if (stationary.cos_proven < 1.0 && caps_ < kMaxCaps) proven_[caps_++] = {stationary.normal, stationary.cos_proven};
    // A direction with points is preferred to an equally shallow one without points.
    const double limit = result_.depth + (result_.has_points ? 0.0 : cso.rounding());
    if (direction->depth < limit) keep(*direction);
    return stationary.cos_proven < 1.0 && setAsideIfProven(polytope, face);
  }

  /// Tries to prove by an ellipsoid that no direction is shallower than the refined one, once for each.
  void proveByEllipsoid(const Cso& cso, double tolerance) {
    if (!result_.has_points || is_tried_) return;
    is_tried_ = true;
    depth_inside_ = std::max(depth_inside_, depthOfInnerEllipsoid(cso, stationary_, result_.depth, tolerance));
  }

  /// Proves by branch and bound that no direction is shallower than the result, and improves the result on the way.
  /// This is tried once. Newton's method may not have begun yet with the direction of the result: where the depth is
  /// nearly the same in all directions, the face that it is from was far inside.
  void proveAboutAxis(Cso& cso, double tolerance) {
    if (is_searched_) return;
    is_searched_ = true;
    const auto refine = [&](const std::array<Vector3d, 2>& directions) {
      improve(cso, directions);
      proveByEllipsoid(cso, tolerance);
      const bool is_proven = result_.has_points && depth_inside_ >= result_.depth - 0.5 * tolerance;
      return is_proven ? 0.0 : result_.depth;
    };
    const double known = result_.has_points ? result_.depth : refine({result_.normal, result_.normal});
    // By reference: a std::function would take memory for so many captures.
    const double proven = depthAboutAxis(cso, known, tolerance, std::ref(refine));
    depth_inside_ = std::max(depth_inside_, proven);
    if (!result_.has_points && proven > 0.0) setPointsAtDepth(cso, tolerance, result_);
  }

  /// [m] A lower bound of the depth in all directions, by a solid inside of the CSO or by the search about an axis;
  /// -infinity if none is known.
  double depthInside() const { return depth_inside_; }

  /// Sets a face aside if one proven cap contains all directions about it in which the depth could still be smaller,
  /// and with it the other faces of these directions. Returns false if no cap does.
  ///
  /// These are the directions in which no vertex of the polytope reaches as far as the known depth. They surround the
  /// normals of the faces closer than this depth, and end between such a face and each neighbour that is not closer.
  /// The cap is convex, so it suffices that it contains these normals and these ends.
  bool setAsideIfProven(Polytope& polytope, const Polytope::Face& face) const {
    for (int i = 0; i < caps_; ++i)
      if (setAsideIfIn(proven_[i], polytope, face)) return true;
    return false;
  }

 private:
  void keep(const Refined& direction) {
    setDirection(direction, result_);
    stationary_ = direction.stationary;
    is_tried_ = false;
  }

  /// Replaces the result by the first direction, which is shallower, or by the direction to which Newton's method
  /// refines it.
  void improve(Cso& cso, const std::array<Vector3d, 2>& directions) {
    Simplex simplex;
    simplex[0] = cso.vertex(directions[0]);
    simplex[1] = cso.vertex(directions[1]);
    simplex.members = 0b11;
    const double depth = directions[0].dot(simplex[0].point);
    const std::optional<Refined> direction = refined(cso, simplex, directions[0]);
    if (direction && direction->depth <= std::min(depth, result_.depth)) {
      keep(*direction);
    } else if (depth < result_.depth) {
      result_.depth = depth;
      result_.normal = directions[0];
      result_.has_normal = true;
      result_.has_points = false;
    }
  }

  static constexpr int kMaxCaps = 8;
  struct Cap {
    Vector3d normal;
    double cosine;
  };

  /// A face as seen from a cap.
  struct Seen {
    double distance;  ///< [m] of the face
    double inside;    ///< cosine of the angle between its normal and the middle of the cap

    Seen(const Cap& cap, const Polytope::Face& face) {
      const double scale = 1.0 / std::sqrt(face.area2);
      distance = scale * face.height;
      inside = scale * face.area.dot(cap.normal);
    }
  };

  bool setAsideIfIn(const Cap& cap, Polytope& polytope, const Polytope::Face& face) const {
    constexpr std::size_t kMaxFaces = 16;
    std::array<const Polytope::Face*, kMaxFaces> closer{&face};
    std::size_t count = 1;
    for (std::size_t i = 0; i < count; ++i) {
      const Seen at(cap, *closer[i]);
      if (!(at.inside > cap.cosine)) return false;
      for (std::size_t edge = 0; edge < 3; ++edge) {
        const Polytope::Face& next = polytope.neighbour(*closer[i], edge);
        if (next.isCloserThan(result_.depth)) {
          if (std::find(closer.begin(), closer.begin() + count, &next) != closer.begin() + count) continue;
          if (count == kMaxFaces) return false;
          closer[count++] = &next;
          continue;
        }
        // The edge reaches the depth in the direction that divides both normals in proportion to the distances, and
        // beyond it.
        if (!next.hasNormal()) return false;
        const Seen beyond(cap, next);
        const double part = (result_.depth - at.distance) / (beyond.distance - at.distance);
        if (!((1.0 - part) * at.inside + part * beyond.inside > cap.cosine)) return false;
      }
    }
    std::for_each(closer.begin(), closer.begin() + count, [&](const Polytope::Face* f) { polytope.setAside(*f); });
    return true;
  }

  EpaResult& result_;
  int caps_ = 0;
  std::array<Cap, kMaxCaps> proven_;
  StationaryDirection stationary_;  ///< the refined direction of the result, if that has points
  bool is_tried_ = true;
  bool is_searched_ = false;
  double depth_inside_;
};

/// Newton's method starts only from a face whose distance is more than this fraction of the depth along its normal: the
/// corners of a face farther inside seldom lie on the right smooth pieces. Evidence: 400 random pairs each of
/// cylinders, cones and ellipsoids, smallest processor time of 60 rounds. Against 0 (every face), 0.6 saves 3 to 12 %
/// in deep overlaps and costs 4 to 27 % in shallow ones; 0.99 costs more in shallow ones than 0.6. The rows "cylinder,
/// shallow" and "cylinder, deep" of ./dev bench narrowphase repeat it for cylinders.
constexpr double kWorthRefining = 0.6;

/// True if two cores of such kinds often have a depth that is the same, or nearly, in a ring of directions, or in two
/// opposite ones. For other curved pairs this is assumed only after kManyFaces expansions.
bool isRound(Shape::Kind kind) {
  return kind == Shape::Kind::Point || kind == Shape::Kind::Segment || kind == Shape::Kind::Cylinder ||
         kind == Shape::Kind::Ellipsoid;
}
constexpr int kManyFaces = 24;

/// The first expansion that tries the ellipsoid inside of the CSO. Evidence: 400 random pairs of each two kinds,
/// smallest time of 15 rounds: where it is tried at once, two ellipsoids need 0.53 to 0.61 of the time, pairs with a
/// box, a hull or a cone up to 1.25 of it. Two cylinders in deep overlap, 1000 pairs, smallest time of 20 rounds: from
/// 12 on instead of at once, 0.95 of the time, with coherent poses 0.90.
int firstEllipsoid(const Cso& cso) {
  constexpr int kSomeFaces = 12;
  const Shape::Kind a = cso.a().kind(), b = cso.b().kind();
  if (!isRound(a) || !isRound(b)) return kManyFaces;
  return a == Shape::Kind::Ellipsoid || b == Shape::Kind::Ellipsoid ? 1 : kSomeFaces;
}

/// After so many expansions, cores of some kinds are searched by patches of directions: there is probably
/// a ring of nearly equal depths. Evidence: 5000 pairs of each two round kinds within 1e-3 rad of one axis, mean of
/// all: 12.7, 12.5, 12.6 and 13.3 us from 36, 48, 64 and 80 expansions on, 24 us without. From 24 on, two cones take 10
/// instead of 6 us, as most of them need no more than 48.
constexpr int kExpansionsBeforePatches = 64;

/// After so many expansions on a curved CSO, the tolerance ends the search as well as the smaller width of
/// Cso::finalWidth(). Evidence: with 192, the accuracy table has an error of 2e-10 m for cylinder and cone instead of
/// 4e-12.
constexpr int kMaxForAccuracy = 320;

/// A direction, and the depth along it; infinite if none is known yet.
struct KnownDepth {
  Vector3d normal = Vector3d::Zero();
  double depth = std::numeric_limits<double>::infinity();
};

/// The expansion of a polytope: steps 3 to 7 of epa().
template <typename Observer>
class Expansion {
 public:
  Expansion(Cso& cso, Polytope& polytope, const KnownDepth& known, const Options& options, Observer observer)
      : cso_(cso),
        polytope_(polytope),
        options_(options),
        observer_(observer),
        final_width_(cso.finalWidth(options.distance_tolerance)),
        first_ellipsoid_(firstEllipsoid(cso)),
        is_round_(isRound(cso.a().kind()) && isRound(cso.b().kind())),
        result_(resultOf(known)),
        smallest_depth_(cso, result_) {}

  EpaResult run() {
    observer_.begins();
    for (result_.iterations = 1;; ++result_.iterations) {
      const Closest closest = closestFace();
      if (const auto ending = endingBelow(closest)) return finished(*ending);
      // Along the area vector: the support point need not wait for the root and the division of the normal.
      const Polytope::Face& face = *closest.face;
      const CsoVertex w = cso_.vertex(face.area);
      const Vector3d normal = face.area / closest.length;
      const double depth = normal.dot(w.point);
      observer_.tests(polytope_, face, w, {result_.lower_bound, result_.depth});
      if (const auto ending = endingAbove(face, normal, depth)) return finished(*ending);
      if (isWorthRefining(closest, depth) && smallest_depth_.refineFrom(cso_, polytope_, face)) continue;
      proveInside();
      if (polytope_.hasCorner(face, w) || !polytope_.expand(face, w, result_.depth))
        return finished({Status::Degenerate, nullptr});
    }
  }

 private:
  struct Closest {
    const Polytope::Face* face;  ///< nullptr if there is none
    double length;               ///< of its area vector
    double reach;                ///< [m] distance of the face from the origin; without a face, the known depth
  };
  /// How the search ends, and the face through which the normal leaves the polytope, if that is known.
  struct Ending {
    Status status;
    const Polytope::Face* face;
  };

  static EpaResult resultOf(const KnownDepth& known) {
    EpaResult result;
    result.depth = known.depth;
    result.normal = known.normal;
    result.has_normal = std::isfinite(known.depth);
    return result;
  }

  /// The closest face of those whose directions no cap has proven.
  Closest closestFace() {
    const Polytope::Face* face = polytope_.closest();
    while (face != nullptr && smallest_depth_.setAsideIfProven(polytope_, *face)) face = polytope_.closest();
    // Without a face the polytope proves only that the origin is inside, until a depth is known.
    if (face == nullptr) return {nullptr, 1.0, result_.has_normal ? result_.depth : 0.0};
    const double length = std::sqrt(face->area2);
    return {face, length, face->height / length};
  }

  /// Sets the lower bound. Returns how the search ends by it, or without a face to go on with.
  std::optional<Ending> endingBelow(const Closest& closest) {
    if (!polytope_.surroundsOrigin(closest.reach)) return Ending{Status::Degenerate, nullptr};
    // depthInside() proves a depth, but the polytope may not know yet where its points are.
    const double proven = result_.has_points ? std::max(closest.reach, smallest_depth_.depthInside()) : closest.reach;
    result_.lower_bound = std::min(proven, result_.depth) - cso_.rounding();
    if (-result_.lower_bound <= options_.stop_below) return Ending{Status::Threshold, nullptr};
    if (isFinal()) return Ending{Status::Converged, closest.face};
    if (closest.face == nullptr) return Ending{Status::Degenerate, nullptr};
    return std::nullopt;
  }

  /// Keeps the direction of a face if it is the shallowest. Returns how the search ends by the depth along this
  /// direction, or because it has taken too many steps.
  std::optional<Ending> endingAbove(const Polytope::Face& face, const Vector3d& normal, double depth) {
    // A direction with points, found by Newton's method, is not replaced by one that is shallower by rounding only.
    if (depth < result_.depth - (result_.has_points ? cso_.rounding() : 0.0)) {
      result_.depth = depth;
      result_.normal = normal;
      result_.has_normal = true;
      result_.has_points = false;
      if (isFinal()) return Ending{Status::Converged, &face};
    }
    if (-(result_.depth + cso_.rounding()) > options_.stop_above) return Ending{Status::Threshold, nullptr};
    if (result_.iterations >= options_.max_iterations || polytope_.full())
      return Ending{Status::IterationLimit, nullptr};
    return std::nullopt;
  }

  bool isWorthRefining(const Closest& closest, double depth) const {
    const bool is_near = !cso_.isPolytope() && closest.reach > kWorthRefining * depth;
    const bool may_be_ring = is_round_ || result_.iterations >= kManyFaces;
    return is_near && (!(depth > result_.depth) || (may_be_ring && !result_.has_points));
  }

  /// After some expansions: looks for a proof of the depth that needs no faces.
  void proveInside() {
    if (result_.iterations >= first_ellipsoid_) smallest_depth_.proveByEllipsoid(cso_, options_.distance_tolerance);
    if (result_.iterations >= kExpansionsBeforePatches)
      smallest_depth_.proveAboutAxis(cso_, options_.distance_tolerance);
  }

  /// The lower bound is lowered by rounding where it is set; the upper bound is raised by it here.
  double width() const { return result_.depth + cso_.rounding() - result_.lower_bound; }

  /// A depth found by Newton's method is more accurate than its lower bound, so the tolerance suffices for the width;
  /// and it has to suffice where a curved CSO needs many faces.
  bool isFinal() const {
    const bool is_long = !cso_.isPolytope() && result_.iterations > kMaxForAccuracy;
    return width() <= (result_.has_points || is_long ? options_.distance_tolerance : final_width_);
  }

  EpaResult finished(const Ending& ending) {
    const double inside = smallest_depth_.depthInside();
    result_.lower_bound = std::max(result_.lower_bound, std::min(inside, result_.depth) - cso_.rounding());
    const bool converged = ending.status != Status::Threshold && width() <= options_.distance_tolerance;
    result_.status = converged ? Status::Converged : ending.status;
    observer_.ends(polytope_, result_.depth);
    if (result_.has_points) observer_.endsWithPoints(polytope_, {inside, result_.depth});
    if (!result_.has_normal) return result_;
    if (!result_.has_points) setWitnesses(polytope_, ending.face, options_, result_);
    result_.unique = isUnique(polytope_, result_, options_) &&
                     !(inside >= result_.lower_bound + cso_.rounding() && isInRing(cso_, result_, options_));
    return result_;
  }

  Cso& cso_;
  Polytope& polytope_;
  const Options& options_;
  const Observer observer_;
  const double final_width_;
  const int first_ellipsoid_;
  const bool is_round_;
  EpaResult result_;
  SmallestDepth smallest_depth_;
};

/// It is not inlined, because the large polytope would cost a query that ends without one 10 ns.
template <typename Observer>
[[gnu::noinline]] EpaResult fromTetrahedron(Cso& cso, const std::array<CsoVertex, 4>& tetrahedron,
                                            const Options& options, Observer observer) {
  const auto coplanar = cso.isPolytope() ? Polytope::Coplanar::Replaced : Polytope::Coplanar::Kept;
  Polytope polytope(tetrahedron, cso.rounding(), coplanar);
  const EpaResult result = Expansion(cso, polytope, KnownDepth(), options, observer).run();
  if (cso.isPolytope() && cso.warmStart().polytope != nullptr) polytope.keep(*cso.warmStart().polytope);
  return result;
}

/// The result if a lower bound of the depth alone decides options.stop_below.
EpaResult decidedBy(double lower_bound) {
  EpaResult result;
  result.status = Status::Threshold;
  result.lower_bound = lower_bound;
  return result;
}

}  // namespace

template <typename Observer>
EpaResult epa(Cso& cso, const Simplex& simplex, const Options& options, Observer observer) {
  PROXIMITY_ASSERT(simplex.members != 0, "The simplex is empty: EPA begins with that of GJK.");
  observer.reaches(Algorithm::EnclosedBall);
  if (simplex.members == 0b1111 && std::isfinite(options.stop_below)) {
    const double enclosed = enclosedRadius(simplex) - cso.rounding();
    if (-enclosed <= options.stop_below) return decidedBy(enclosed);
  }
  const EpaStart start = epaStart(cso, simplex);
  observer.reaches(start.plane ? Algorithm::SurfacePlane : Algorithm::Epa);
  if (start.plane) return onSurface(cso, simplex, *start.plane, options);
  EpaResult result = fromTetrahedron(cso, start.vertices, options, observer);
  if (result.has_normal && !result.has_points && simplex.members != 0b1111) setWitnesses(simplex, options, result);
  return result;
}

template <typename Observer>
std::optional<EpaResult> epaRecalled(Cso& cso, const Vector3d& normal, const CsoVertex& w, const Options& options,
                                     Observer observer) {
  WarmPolytope* const last = cso.warmStart().polytope;
  if (!cso.isPolytope() || last->faceCount() == 0) return std::nullopt;
  const KnownDepth known{normal, normal.dot(w.point)};
  Polytope polytope(cso.rounding());
  // A face in the support plane is asked, too: the witness points lie on it.
  if (polytope.recall(*last, cso, known.depth + 2.0 * cso.rounding())) {
    observer.reaches(Algorithm::Epa);
    const EpaResult result = Expansion(cso, polytope, known, options, observer).run();
    if (result.iterations > 1) polytope.keep(*last);  // otherwise it is the same
    const bool is_answer = result.status == Status::Converged && result.has_points;
    if (is_answer || result.status == Status::Threshold) return result;
  }
  last->forget();
  return std::nullopt;
}

template EpaResult epa(Cso&, const Simplex&, const Options&, Unobserved);
template EpaResult epa(Cso&, const Simplex&, const Options&, Recorder);
template std::optional<EpaResult> epaRecalled(Cso&, const Vector3d&, const CsoVertex&, const Options&, Unobserved);
template std::optional<EpaResult> epaRecalled(Cso&, const Vector3d&, const CsoVertex&, const Options&, Recorder);

}  // namespace proximity_server::narrowphase
