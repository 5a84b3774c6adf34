#include "scene/lanes/link_outline.h"

#include "proximity_server/narrowphase/shape/shape.h"
#include "proximity_server/narrowphase/signed_distance.h"
#include "scene/model/pieces.h"
#include "scene/pieces/interior.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>

namespace proximity_server::scene {
namespace {

using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using narrowphase::Shape;

// [1] Relative to the reach: qhull leaves out points that are outside of the hull by at most 2e-14 of the size of the
// cloud, and the corners of simplices have a rounding of a few eps.
constexpr double kRounding = 1e-12;

/// A surface of triangles around a convex core, and a point inside of it.
struct Surface {
  std::vector<Vector3d> points;
  std::vector<std::array<int, 3>> triangles;
  Vector3d centre;
};

// --- surfaces of cores, in the frame of the piece

Surface surfaceOfBox(const Vector3d& half) {
  Surface box{{}, {}, Vector3d::Zero()};
  for (int i = 0; i < 8; ++i)
    box.points.emplace_back((i & 1) != 0 ? half.x() : -half.x(), (i & 2) != 0 ? half.y() : -half.y(),
                            (i & 4) != 0 ? half.z() : -half.z());
  for (const int axis : {1, 2, 4}) {
    const int u = axis == 4 ? 1 : 2 * axis, v = 7 - axis - u;
    for (const int side : {0, axis}) {
      box.triangles.push_back({side, side + u, side + u + v});
      box.triangles.push_back({side, side + u + v, side + v});
    }
  }
  return box;
}

/// The surface of a prism around the cylinder.
Surface surfaceOfCylinder(double radius, double half_length) {
  constexpr int kSides = 24;
  const double pi = std::acos(-1.0), outer = radius / std::cos(pi / kSides);
  Surface prism{{}, {}, Vector3d::Zero()};
  for (int i = 0; i < kSides; ++i)
    for (const double z : {-half_length, half_length})
      prism.points.emplace_back(outer * std::cos(2 * pi * i / kSides), outer * std::sin(2 * pi * i / kSides), z);
  for (int i = 0; i < kSides; ++i) {
    const int low = 2 * i, next = 2 * ((i + 1) % kSides);
    prism.triangles.push_back({low, next, next + 1});
    prism.triangles.push_back({low, next + 1, low + 1});
    if (i == 0 || i == kSides - 1) continue;
    prism.triangles.push_back({0, low, next});
    prism.triangles.push_back({1, low + 1, next + 1});
  }
  return prism;
}

Surface surfaceOfHull(const narrowphase::ConvexHull& hull, const Vector3d& centre) {
  Surface surface{hull.vertices(), hull.triangles(), centre};
  if (hull.dimension() < 2) surface.triangles.push_back({0, hull.size() - 1, hull.size() - 1});
  if (hull.dimension() < 3) surface.centre = hull.vertices().front();
  return surface;
}

/// A surface that contains the core.
Surface surfaceOf(const Shape& shape) {
  const Vector3d& half = shape.halfExtents();
  switch (shape.kind()) {
    case Shape::Kind::Point:
    case Shape::Kind::Segment:
      return {{-half, half}, {{0, 1, 1}}, half};
    case Shape::Kind::Cylinder:
      return surfaceOfCylinder(half.x(), half.z());
    case Shape::Kind::Hull:
      return surfaceOfHull(shape.hull(), shape.centre());
    case Shape::Kind::Box:
    case Shape::Kind::Cone:
    case Shape::Kind::Ellipsoid:
      return surfaceOfBox(half);
    case Shape::Kind::Sweep:
      break;
  }
  Surface cube = surfaceOfBox(Vector3d::Constant(shape.coreRadius()));
  for (Vector3d& point : cube.points) point += shape.centre();
  cube.centre = shape.centre();
  return cube;
}

// --- depth

/// Bounds the depth of points in a piece.
class Depth {
 public:
  explicit Depth(const Piece& piece) : piece_(&piece), piece_T_body_(piece.body_T_piece.inverse(Eigen::Isometry)) {
    if (piece.shape.kind() != Shape::Kind::Hull) return;
    const narrowphase::ConvexHull& hull = piece.shape.hull();
    const auto vertex = [&](int i) -> const Vector3d& { return hull.vertices()[i]; };
    if (hull.dimension() < 3) return;
    for (const auto& [i, j, k] : hull.triangles()) {
      const Vector3d normal = (vertex(j) - vertex(i)).cross(vertex(k) - vertex(i)).stableNormalized();
      if (!normal.isZero(0.0)) planes_.push_back({normal, normal.dot(vertex(i))});
    }
  }

  const Piece& piece() const { return *piece_; }

  /// [m] A lower bound of the depth of a point of the body; negative if the point may be outside.
  double at(const Vector3d& point) const {
    const Vector3d p = piece_T_body_ * point;
    const double lengths = point.norm() + piece_->shape.coreReach() + piece_->body_T_piece.translation().norm();
    const double depth = depthInCore(p) - kRounding * lengths;
    // For a point outside of a core with planes, the distance from the planes is not the distance from the core.
    return depth >= 0.0 || isRound() ? depth + piece_->shape.margin() : depth;
  }

 private:
  struct Plane {
    Vector3d normal;
    double offset;
  };

  /// True if depthInCore() is the distance from a ball within the core, or from the core itself.
  bool isRound() const {
    const Shape::Kind kind = piece_->shape.kind();
    return kind != Shape::Kind::Box && kind != Shape::Kind::Cylinder && planes_.empty();
  }

  double depthInCore(const Vector3d& p) const {
    const Shape& shape = piece_->shape;
    const Vector3d& half = shape.halfExtents();
    switch (shape.kind()) {
      case Shape::Kind::Point:
      case Shape::Kind::Segment:
        return -(p - Vector3d(0.0, 0.0, std::clamp(p.z(), -half.z(), half.z()))).norm();
      case Shape::Kind::Box:
        return (half - p.cwiseAbs()).minCoeff();
      case Shape::Kind::Cylinder:
        return std::min(half.x() - p.head<2>().norm(), half.z() - std::abs(p.z()));
      case Shape::Kind::Hull:
        return planes_.empty() ? -(p - shape.hull().vertices().front()).norm() : depthInPlanes(p);
      case Shape::Kind::Cone:
      case Shape::Kind::Ellipsoid:
      case Shape::Kind::Sweep:
        break;
    }
    return shape.innerRadius() - (p - shape.centre()).norm();
  }

  double depthInPlanes(const Vector3d& p) const {
    double depth = std::numeric_limits<double>::infinity();
    for (const Plane& plane : planes_) depth = std::min(depth, plane.offset - plane.normal.dot(p));
    return depth;
  }

  const Piece* piece_;
  Isometry3d piece_T_body_;
  std::vector<Plane> planes_;
};

// --- inner balls

/// A point of the surface of a piece, and the direction into it.
struct SurfacePoint {
  const Depth* piece;
  Vector3d point, inwards;
  double gap = std::numeric_limits<double>::infinity();  ///< [m] to the nearest ball
};

std::vector<SurfacePoint> surfacePoints(const std::vector<Depth>& pieces) {
  std::vector<SurfacePoint> samples;
  for (const Depth& depth : pieces) {
    const Piece& piece = depth.piece();
    const Surface surface = surfaceOf(piece.shape);
    for (const auto& [i, j, k] : surface.triangles) {
      const Vector3d a = surface.points[i], b = surface.points[j], c = surface.points[k];
      Vector3d inwards = (b - a).cross(c - a).stableNormalized();
      if (inwards.dot(surface.centre - a) < 0.0) inwards = -inwards;
      for (const Vector3d& weights : {Vector3d(1, 1, 1), Vector3d(4, 1, 1), Vector3d(1, 4, 1), Vector3d(1, 1, 4),
                                      Vector3d(10, 10, 1), Vector3d(10, 1, 10), Vector3d(1, 10, 10)}) {
        const Vector3d point = (weights.x() * a + weights.y() * b + weights.z() * c) / weights.sum();
        samples.push_back({&depth,
                           piece.body_T_piece * point - piece.shape.margin() * (piece.body_T_piece.linear() * inwards),
                           piece.body_T_piece.linear() * inwards});
      }
    }
  }
  return samples;
}

/// The largest ball with its centre on the inward normal of the sample whose gap to the sample is accepted: hardly more
/// than the gap that there is anyway.
Ball touchingBall(const SurfacePoint& sample, double largest) {
  constexpr double kGap = 2e-4;  // [m] a gap that is accepted in exchange for a larger ball
  const auto gapAt = [&](double t) { return t - sample.piece->at(sample.point + t * sample.inwards); };
  const double accepted = std::max(0.0, gapAt(0.0)) + kGap;
  double low = 0.0, high = largest;
  for (int i = 0; i < 20; ++i) {
    const double middle = 0.5 * (low + high);
    (gapAt(middle) <= accepted ? low : high) = middle;
  }
  const Vector3d centre = sample.point + low * sample.inwards;
  return {centre, sample.piece->at(centre)};
}

std::vector<Ball> fitInner(const std::vector<Depth>& pieces, double largest) {
  std::vector<Ball> balls;
  std::vector<SurfacePoint> samples = surfacePoints(pieces);
  const auto add = [&](const Ball& ball) {
    if (!(ball.radius >= 0.0)) return;
    balls.push_back(ball);
  };
  const auto update = [&](const Ball& ball) {
    for (SurfacePoint& sample : samples)
      sample.gap = std::min(sample.gap, (sample.point - ball.centre).norm() - ball.radius);
  };
  for (const Depth& depth : pieces) {
    const Piece& piece = depth.piece();
    const int along = piece.shape.kind() == Shape::Kind::Segment ? 9 : 1;
    if (static_cast<int>(balls.size()) + along > kInnerBalls) break;
    for (int i = 0; i < along; ++i) {
      const double place = along == 1 ? 0.0 : 2.0 * i / (along - 1) - 1.0;
      const Vector3d centre =
          piece.body_T_piece *
          (piece.shape.centre() + place * Vector3d(0, 0, along == 1 ? 0.0 : piece.shape.halfExtents().z()));
      const Ball ball{centre, depth.at(centre)};
      if (ball.radius >= 0.0) update(ball);
      add(ball);
    }
  }
  for (int tries = 0; tries < 2 * kInnerBalls && static_cast<int>(balls.size()) < kInnerBalls; ++tries) {
    const auto farthest = std::max_element(samples.begin(), samples.end(),
                                           [](const SurfacePoint& a, const SurfacePoint& b) { return a.gap < b.gap; });
    if (farthest == samples.end() || !(farthest->gap > 0.0)) break;
    const Ball ball = touchingBall(*farthest, largest);
    if (ball.radius >= 0.0) update(ball);
    farthest->gap = 0.0;
    add(ball);
  }
  std::sort(balls.begin(), balls.end(), [](const Ball& a, const Ball& b) { return a.radius > b.radius; });
  return balls;
}

// --- outline

/// The corners of the pieces, with their margins as radii. If all margins are equal, only the corners of the common
/// hull.
std::vector<Ball> cornersOf(const RobotModel& model, const std::vector<int>& pieces) {
  std::vector<Vector3d> points;
  std::vector<Ball> corners;
  bool same_margin = true;
  const double margin = model.pieces[pieces.front()].shape.margin();
  for (const int index : pieces) {
    const Piece& piece = model.pieces[index];
    same_margin &= piece.shape.margin() == margin;
    for (const Vector3d& point : surfaceOf(piece.shape).points) {
      points.push_back(piece.body_T_piece * point);
      corners.push_back({points.back(), piece.shape.margin()});
    }
  }
  if (!same_margin) return corners;
  corners.clear();
  const narrowphase::ConvexHull hull(points);
  for (const Vector3d& vertex : hull.vertices()) corners.push_back({vertex, margin});
  return corners;
}

/// Puts up to `count` balls first, each of which is the farthest from all before it.
void putSpreadFirst(std::vector<Ball>& balls, std::size_t count) {
  Vector3d mean = Vector3d::Zero();
  for (const Ball& ball : balls) mean += ball.centre / static_cast<double>(balls.size());
  std::vector<double> distances;
  for (const Ball& ball : balls) distances.push_back((ball.centre - mean).norm());
  for (std::size_t i = 0; i < count; ++i) {
    const auto next = static_cast<std::size_t>(
        std::max_element(distances.begin() + static_cast<std::ptrdiff_t>(i), distances.end()) - distances.begin());
    std::swap(balls[i], balls[next]);
    std::swap(distances[i], distances[next]);
    for (std::size_t j = i + 1; j < balls.size(); ++j) {
      const double distance = (balls[j].centre - balls[i].centre).norm();
      distances[j] = i == 0 ? distance : std::min(distances[j], distance);
    }
  }
}

/// [m] An upper bound of how far balls stick out of the hull of the first `count` balls.
double uncoveredBy(const std::vector<Ball>& balls, std::size_t count) {
  std::vector<Vector3d> points;
  double smallest_radius = std::numeric_limits<double>::infinity(), uncovered = 0.0;
  for (std::size_t i = 0; i < count; ++i) {
    points.push_back(balls[i].centre);
    smallest_radius = std::min(smallest_radius, balls[i].radius);
  }
  const Shape hull{narrowphase::ConvexHull(points)};
  for (std::size_t i = count; i < balls.size(); ++i) {
    constexpr double kRadius = 1e-3;  // any value, because a point is not a shape
    Isometry3d hull_T_ball = Isometry3d::Identity();
    hull_T_ball.translation() = balls[i].centre;
    const double distance = signedDistance(hull, narrowphase::Sphere{kRadius}, hull_T_ball).upper_bound + kRadius;
    uncovered = std::max(uncovered, std::max(0.0, distance) + std::max(0.0, balls[i].radius - smallest_radius));
  }
  return uncovered;
}

/// True if surfaceOf() is the surface of the core.
bool hasExactSurface(const Shape& shape) {
  switch (shape.kind()) {
    case Shape::Kind::Point:
    case Shape::Kind::Segment:
    case Shape::Kind::Box:
    case Shape::Kind::Hull:
      return true;
    default:
      return false;
  }
}

PieceOutline outlineOf(std::vector<Vector3d> corners, const Isometry3d& body_T_piece, double margin, bool is_exact) {
  for (Vector3d& corner : corners) corner = body_T_piece * corner;
  return {std::move(corners), margin, is_exact};
}

void addPiece(const Piece& piece, LinkOutline& outline) {
  const Shape& shape = piece.shape;
  outline.pieces.push_back(
      outlineOf(surfaceOf(shape).points, piece.body_T_piece, shape.margin(), hasExactSurface(shape)));
  if (piece.is_representative)
    outline.representatives.push_back(
        {piece.body_T_piece * shape.centre(), std::max(0.0, shape.innerRadius()) + shape.margin()});
  if (!piece.interior) return;
  const Eigen::AlignedBox3d& box = piece.interior->box();
  std::vector<Vector3d> corners = surfaceOfBox(0.5 * box.sizes()).points;
  for (Vector3d& corner : corners) corner += box.center();
  outline.interiors.push_back(outlineOf(std::move(corners), piece.body_T_piece, shape.margin(), false));
}

}  // namespace

double depthIn(const Piece& piece, const Vector3d& point) { return Depth(piece).at(point); }

LinkOutline outlineOf(const RobotModel& model, int link, const Bounds& bounds) {
  const std::vector<int> pieces = model.piecesOf(link);
  LinkOutline outline;
  outline.bounds = bounds;
  outline.is_exact = pieces.size() == 1 && hasExactSurface(model.pieces[pieces.front()].shape);
  std::vector<Depth> depths;
  for (const int index : pieces) {
    const Piece& piece = model.pieces[index];
    depths.emplace_back(piece);
    addPiece(piece, outline);
    if (piece.interior) outline.uncovered = std::max(outline.uncovered, model.collisions[piece.collision].uncovered);
  }
  outline.corners = cornersOf(model, pieces);
  outline.coarse_corners = std::min<std::size_t>(outline.corners.size(), kCoarseCorners);
  putSpreadFirst(outline.corners, outline.coarse_corners);
  outline.uncovered += kRounding * outline.bounds.reach;
  outline.coarse_uncovered = outline.uncovered + uncoveredBy(outline.corners, outline.coarse_corners);
  for (const Ball& corner : outline.corners)
    outline.inside += corner.centre / static_cast<double>(outline.corners.size());
  outline.inner = fitInner(depths, outline.bounds.radius);
  return outline;
}

}  // namespace proximity_server::scene
