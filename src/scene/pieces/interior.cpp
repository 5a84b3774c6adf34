#include "scene/pieces/interior.h"

#include "system/numbers.h"

#include <algorithm>
#include <cmath>

namespace proximity_server::scene {
namespace {

using Eigen::Vector3d;

Vector3d normalOf(const Triangle& triangle) {
  return (triangle[1] - triangle[0]).cross(triangle[2] - triangle[0]).stableNormalized();
}

/// [m] How far along a direction the corners of a triangle are from p.
struct Extent {
  Extent(const Triangle& triangle, const Vector3d& p, const Vector3d& direction) {
    for (const Vector3d& corner : triangle) {
      const double along = direction.dot(corner - p);
      smallest = std::min(smallest, along);
      largest = std::max(largest, along);
    }
  }
  double smallest = kInfinity, largest = -kInfinity;
};

/// [m] A lower bound of the distance of a triangle from p: how far all its corners are on one side of the plane through
/// p that is parallel to the triangle; negative if they are not. It is tight if the nearest point is inside of the
/// triangle, however near p is.
double gapAlong(const Vector3d& normal, const Triangle& triangle, const Vector3d& p) {
  const Extent extent(triangle, p, normal);
  return std::max(extent.smallest, -extent.largest);
}

/// The nearest of the triangles considered so far. Only triangles nearer than the first upper bound count.
struct NearestTriangle {
  explicit NearestTriangle(double reach) : lower_bound(reach), upper_bound(reach) {}

  const Triangle* triangle = nullptr;
  Vector3d point = Vector3d::Zero();
  double lower_bound, upper_bound;  ///< [m] of the distance from all triangles considered

  /// The bound along the normal costs little and is enough for most triangles. The bound along the way to the nearest
  /// point is tight if that point is on an edge.
  void consider(const Triangle& candidate, const Vector3d& normal, const Vector3d& p) {
    const double gap = gapAlong(normal, candidate, p);
    if (gap > upper_bound) return;
    const Vector3d on_it = nearestCombination(candidate, p);
    const double length = (on_it - p).norm();
    const double proven = std::max({0.0, gap, Extent(candidate, p, (on_it - p).stableNormalized()).smallest});
    lower_bound = std::min(lower_bound, std::min(length, proven));
    if (!(length < upper_bound)) return;
    upper_bound = length;
    point = on_it;
    triangle = &candidate;
  }
};

/// Searches depth first, the nearer part first. A part that is farther away than the nearest triangle found changes
/// neither bound. `normals`: of the triangles.
NearestTriangle nearestOf(const TriangleBoxes& tree, const std::vector<Vector3d>& normals, const Vector3d& p,
                          double reach) {
  NearestTriangle nearest(reach);
  const auto isFar = [&](double squared) { return std::sqrt(squared) > nearest.upper_bound; };
  tree.lookAround(p, isFar, [&](const TriangleBoxes::Node& leaf) {
    for (int i = leaf.begin; i < leaf.end; ++i) nearest.consider(tree.triangles[i], normals[i], p);
  });
  return nearest;
}

}  // namespace

Interior::Interior(const std::vector<Triangle>& closed)
    : surface_(closed), space_(surface_), box_(surface_.nodes.front().box) {
  for (const Triangle& triangle : surface_.triangles) normals_.push_back(normalOf(triangle));
}

Interior::Place Interior::placeOf(const Vector3d& p, double reach) const {
  const bool is_inside = box_.contains(p) && space_.mayHold(p);
  const NearestTriangle nearest = nearestOf(surface_, normals_, p, is_inside ? kInfinity : reach);
  if (!nearest.triangle) return {nearest.lower_bound, kInfinity, p, Vector3d::UnitZ()};
  Vector3d outwards = (p - nearest.point).stableNormalized();
  if (outwards.isZero(0.0)) outwards = normalOf(*nearest.triangle);
  if (outwards.isZero(0.0)) outwards = Vector3d::UnitZ();
  Place place{nearest.lower_bound, nearest.upper_bound, nearest.point, outwards};
  if (is_inside) {
    place.lower_bound = -nearest.upper_bound;
    place.upper_bound = -nearest.lower_bound;
    place.outwards = -place.outwards;
  }
  return place;
}

bool Interior::hasSurfaceWithin(const Vector3d& p, double distance) const {
  if (!(distance > 0.0)) return false;
  const auto isNear = [&](const Eigen::AlignedBox3d& box) { return box.exteriorDistance(p) <= distance; };
  return surface_.anyLeaf(isNear, [&](const TriangleBoxes::Node& leaf) {
    for (int i = leaf.begin; i < leaf.end; ++i) {
      const Triangle& triangle = surface_.triangles[i];
      if (gapAlong(normals_[i], triangle, p) > distance) continue;
      if ((nearestCombination(triangle, p) - p).norm() <= distance) return true;
    }
    return false;
  });
}

}  // namespace proximity_server::scene
