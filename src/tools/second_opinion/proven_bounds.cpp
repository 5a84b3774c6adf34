#include "tools/second_opinion/proven_bounds.h"

#include "proximity_server/narrowphase/shape/support.h"
#include "proximity_server/narrowphase/signed_distance.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace proximity_server::tools {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;
using narrowphase::ConvexHull;
using narrowphase::Shape;
using Vector3l = Eigen::Matrix<long double, 3, 1>;

// The most expansions of a polytope: concentric balls come within 4 % of their depth, most others are much closer.
constexpr int kExpansions = 100;

Vector3d clampedTo(const Vector3d& half, const Vector3d& point) { return point.cwiseMax(-half).cwiseMin(half); }

Vector3d insideDisc(double radius, const Vector3d& point) {
  const double radial = std::hypot(point.x(), point.y());
  if (radial <= radius) return point;
  const double scale = radius / radial;
  return {scale * point.x(), scale * point.y(), point.z()};
}

/// Moves a point towards the mean of the vertices until it is behind every face. A flat hull has no inside: then it is
/// its nearest vertex.
Vector3d insideHull(const ConvexHull& hull, const Vector3d& point) {
  const std::vector<Vector3d>& vertices = hull.vertices();
  if (hull.dimension() < 3) {
    const auto nearer = [&](const Vector3d& p, const Vector3d& q) {
      return (p - point).squaredNorm() < (q - point).squaredNorm();
    };
    return *std::min_element(vertices.begin(), vertices.end(), nearer);
  }
  Vector3d middle = Vector3d::Zero();
  for (const Vector3d& vertex : vertices) middle += vertex / static_cast<double>(vertices.size());
  double share = 1.0;  // the part of the way from the middle to the point
  for (const auto& [i, j, k] : hull.triangles()) {
    const Vector3d& corner = vertices[i];
    const Vector3d normal = (vertices[j] - corner).cross(vertices[k] - corner);
    const double room = normal.dot(corner - middle), way = normal.dot(point - middle);
    if (way > room && room >= 0.0) share = std::min(share, room / way);
  }
  return middle + share * (point - middle);
}

Vector3d insideCore(const Shape& shape, const Vector3d& point) {
  const Vector3d& half = shape.halfExtents();
  switch (shape.kind()) {
    case Shape::Kind::Point:
    case Shape::Kind::Segment:
    case Shape::Kind::Box:
      return clampedTo(half, point);
    case Shape::Kind::Cylinder:
      return insideDisc(half.x(), {point.x(), point.y(), std::clamp(point.z(), -half.z(), half.z())});
    case Shape::Kind::Cone: {
      const double z = std::clamp(point.z(), -half.z(), half.z());
      return insideDisc(half.x() * (half.z() - z) / (2.0 * half.z()), {point.x(), point.y(), z});
    }
    case Shape::Kind::Ellipsoid:
      return point / std::max(point.cwiseQuotient(half).norm(), 1.0);
    case Shape::Kind::Hull:
      return insideHull(shape.hull(), point);
    case Shape::Kind::Sweep:
      break;
  }
  throw std::logic_error("no link and no object is a sweep");
}

const Shape& shapeOf(const PlacedPiece& piece) { return piece.piece->shape; }
Vector3d centreOf(const PlacedPiece& piece) { return piece.world_T_piece * shapeOf(piece).centre(); }
double radiusOf(const PlacedPiece& piece) { return shapeOf(piece).coreRadius() + shapeOf(piece).margin(); }

/// [m] The largest coordinate of a piece along a direction.
long double extentAlong(const PlacedPiece& piece, const Vector3l& direction) {
  const Vector3l turned = piece.world_T_piece.linear().cast<long double>().transpose() * direction;
  return direction.dot(piece.world_T_piece.translation().cast<long double>()) +
         tools::extentAlong(shapeOf(piece), turned);
}

/// [m] The smallest coordinate of b less the largest of a: a lower bound of the signed distance.
double gapAlong(const PlacedPiece& a, const PlacedPiece& b, const Vector3d& axis) {
  const Vector3l n = axis.cast<long double>().normalized();
  if (!n.allFinite()) return -kInfinity;
  return static_cast<double>(-extentAlong(b, -n) - extentAlong(a, n));
}

Vector3d pointInside(const PlacedPiece& piece, const Vector3d& point) {
  return piece.world_T_piece * tools::pointInside(shapeOf(piece), piece.world_T_piece.inverse(Eigen::Isometry) * point);
}

/// [m] From a point of a to a point of b near the two.
double distanceOfPoints(const PlacedPiece& a, const PlacedPiece& b, const Vector3d& near_a, const Vector3d& near_b) {
  if (!near_a.allFinite() || !near_b.allFinite()) return kInfinity;
  const Vector3d in_a = pointInside(a, near_a), in_b = pointInside(b, near_b);
  // A point that is moved from one into the other is a point of both, if they overlap there.
  return std::min({(in_b - in_a).norm(), (pointInside(b, in_a) - in_a).norm(), (pointInside(a, in_b) - in_b).norm()});
}

/// The point of a that is farthest along a direction less the one of b that is farthest against it.
Vector3d differencePoint(const PlacedPiece& a, const PlacedPiece& b, const Vector3d& direction) {
  const auto farthest = [](const PlacedPiece& piece, const Vector3d& along) {
    int vertex = 0;
    const Vector3d turned = piece.world_T_piece.linear().transpose() * along;
    const Vector3d point = narrowphase::supportPoint(shapeOf(piece), turned, vertex);
    return pointInside(piece, piece.world_T_piece * (point + shapeOf(piece).margin() * turned.normalized()));
  };
  return farthest(a, direction) - farthest(b, -direction);
}

struct Face {
  Vector3d normal = Vector3d::Zero();  ///< outwards, unit
  double offset = kInfinity;           ///< [m] from the origin; negative if the origin is in front of it
};

Face nearestFace(const ConvexHull& hull) {
  Face nearest;
  for (const auto& [i, j, k] : hull.triangles()) {
    const Vector3d &p = hull.vertices()[i], &q = hull.vertices()[j], &r = hull.vertices()[k];
    const Vector3d normal = (q - p).cross(r - p).normalized();
    const double offset = std::min({normal.dot(p), normal.dot(q), normal.dot(r)});
    if (offset < nearest.offset) nearest = {normal, offset};
  }
  return nearest;
}

/// [m] The radius of a ball about the origin that the Minkowski difference holds: the two overlap at least so deep. 0
/// if none was found.
double provenDepth(const PlacedPiece& a, const PlacedPiece& b, const std::vector<Vector3d>& axes) {
  std::vector<Vector3d> points;
  for (const Vector3d& axis : axes)
    if (axis.allFinite() && axis.norm() > 0.0) points.push_back(differencePoint(a, b, axis.normalized()));
  for (const double x : {-1.0, 0.0, 1.0})
    for (const double y : {-1.0, 0.0, 1.0})
      for (const double z : {-1.0, 0.0, 1.0})
        if (x != 0.0 || y != 0.0 || z != 0.0) points.push_back(differencePoint(a, b, {x, y, z}));
  double depth = 0.0;
  for (int i = 0; i < kExpansions; ++i) {
    const ConvexHull hull(points);
    if (hull.dimension() < 3) return 0.0;
    const Face face = nearestFace(hull);
    depth = std::max(depth, face.offset);
    const Vector3d next = differencePoint(a, b, face.normal);
    const double growth = face.normal.dot(next) - face.offset;
    if (!(growth > 1e-12 * (radiusOf(a) + radiusOf(b)))) break;
    points.push_back(next);
  }
  return depth;
}

/// Adds the axis and the points of the narrowphase, and the centres, to the hints.
Hints withOurs(Hints hints, const PlacedPiece& a, const PlacedPiece& b) {
  const Isometry3d a_T_b = a.world_T_piece.inverse(Eigen::Isometry) * b.world_T_piece;
  const narrowphase::SignedDistance found = narrowphase::signedDistance(shapeOf(a), shapeOf(b), a_T_b);
  hints.axes.push_back(a.world_T_piece.linear() * found.normal);
  hints.points.emplace_back(a.world_T_piece * found.point_a, a.world_T_piece * found.point_b);
  hints.points.emplace_back(centreOf(a), centreOf(b));
  return hints;
}

ProvenBounds boundsOf(const PlacedPiece& a, const PlacedPiece& b, const Hints& given) {
  const Hints hints = withOurs(given, a, b);
  ProvenBounds bounds;
  for (const Vector3d& axis : hints.axes) bounds.lower = std::max(bounds.lower, gapAlong(a, b, axis));
  for (const auto& [near_a, near_b] : hints.points)
    bounds.upper = std::min(bounds.upper, distanceOfPoints(a, b, near_a, near_b));
  if (!(bounds.lower > 0.0)) {
    const double depth = provenDepth(a, b, hints.axes);
    if (depth > 0.0) bounds.upper = -depth;
  }
  return bounds;
}

/// [m] Bounds the rounding of the coordinates that the proof computes with: a pose of double precision is off by some
/// epsilon of its reach for each joint that led to it, and each step of the proof by a few.
double roundingOf(const PlacedPieces& a, const PlacedPieces& b) {
  double reach = 0.0;
  for (const PlacedPieces* body : {&a, &b})
    for (const PlacedPiece& piece : body->pieces)
      reach = std::max(reach,
                       piece.world_T_piece.translation().norm() + shapeOf(piece).coreReach() + shapeOf(piece).margin());
  return 256.0 * std::numeric_limits<double>::epsilon() * reach;
}

}  // namespace

long double extentAlong(const Shape& shape, const Vector3l& direction) {
  const Vector3l half = shape.halfExtents().cast<long double>(), size = direction.cwiseAbs();
  const long double radial = std::hypot(direction.x(), direction.y()), margin = shape.margin() * direction.norm();
  switch (shape.kind()) {
    case Shape::Kind::Point:
    case Shape::Kind::Segment:
    case Shape::Kind::Box:
      return half.dot(size) + margin;
    case Shape::Kind::Cylinder:
      return half.x() * radial + half.z() * size.z() + margin;
    case Shape::Kind::Cone:
      return std::max(half.z() * direction.z(), half.x() * radial - half.z() * direction.z()) + margin;
    case Shape::Kind::Ellipsoid:
      return half.cwiseProduct(direction).norm() + margin;
    case Shape::Kind::Hull: {
      long double extent = -std::numeric_limits<long double>::infinity();
      for (const Vector3d& vertex : shape.hull().vertices())
        extent = std::max(extent, direction.dot(vertex.cast<long double>()));
      return extent + margin;
    }
    case Shape::Kind::Sweep:
      break;
  }
  throw std::logic_error("no link and no object is a sweep");
}

Vector3d pointInside(const Shape& shape, const Vector3d& point) {
  const Vector3d core = insideCore(shape, point);
  const Vector3d way = point - core;
  const double length = way.norm();
  if (length <= shape.margin()) return point;
  return core + (shape.margin() / length) * way;
}

ProvenBounds provenBounds(const PlacedPieces& a, const PlacedPieces& b, const Hints& hints) {
  ProvenBounds whole{kInfinity, kInfinity};
  for (const PlacedPiece& piece_a : a.pieces)
    for (const PlacedPiece& piece_b : b.pieces) {
      const double centres = (centreOf(piece_b) - centreOf(piece_a)).norm() - radiusOf(piece_a) - radiusOf(piece_b);
      if (centres > std::max(whole.lower, whole.upper)) continue;  // neither the closest nor near to it
      const ProvenBounds bounds = boundsOf(piece_a, piece_b, hints);
      whole.lower = std::min(whole.lower, bounds.lower);
      whole.upper = std::min(whole.upper, bounds.upper);
    }
  const double rounding = roundingOf(a, b);
  return {whole.lower - rounding, whole.upper + rounding};
}

}  // namespace proximity_server::tools
