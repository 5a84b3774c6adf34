#include "tools/second_opinion/fcl_shape.h"

#include <fcl/geometry/shape/box.h>
#include <fcl/geometry/shape/capsule.h>
#include <fcl/geometry/shape/cone.h>
#include <fcl/geometry/shape/convex.h>
#include <fcl/geometry/shape/cylinder.h>
#include <fcl/geometry/shape/ellipsoid.h>
#include <fcl/geometry/shape/sphere.h>

#include <stdexcept>
#include <vector>

namespace proximity_server::tools {

using namespace narrowphase;
namespace {

std::shared_ptr<fcl::CollisionGeometryd> fclConvex(const ConvexHull& hull) {
  if (hull.dimension() < 3) throw std::invalid_argument("FCL's convex hull must be a solid");
  const auto vertices = std::make_shared<const std::vector<Eigen::Vector3d>>(hull.vertices());
  auto faces = std::make_shared<std::vector<int>>();
  for (const auto& triangle : hull.triangles()) faces->insert(faces->end(), {3, triangle[0], triangle[1], triangle[2]});
  return std::make_shared<fcl::Convexd>(vertices, static_cast<int>(hull.triangles().size()), faces);
}

std::shared_ptr<fcl::CollisionGeometryd> fclCore(const Shape& shape) {
  const Eigen::Vector3d& half = shape.halfExtents();
  switch (shape.kind()) {
    case Shape::Kind::Box:
      return std::make_shared<fcl::Boxd>(2.0 * half);
    case Shape::Kind::Cylinder:
      return std::make_shared<fcl::Cylinderd>(half.x(), 2.0 * half.z());
    case Shape::Kind::Cone:
      return std::make_shared<fcl::Coned>(half.x(), 2.0 * half.z());
    case Shape::Kind::Ellipsoid:
      return std::make_shared<fcl::Ellipsoidd>(half);
    case Shape::Kind::Hull:
      return fclConvex(shape.hull());
    default:
      throw std::invalid_argument("FCL has no points and no segments");
  }
}

/// The hull of a box's corners.
ConvexHull hullOfBox(const Shape& box) {
  std::vector<Eigen::Vector3d> corners;
  for (const double x : {-1.0, 1.0})
    for (const double y : {-1.0, 1.0})
      for (const double z : {-1.0, 1.0}) corners.push_back(box.halfExtents().cwiseProduct(Eigen::Vector3d(x, y, z)));
  return ConvexHull(corners);
}

}  // namespace

std::shared_ptr<fcl::CollisionGeometryd> fclShape(const Shape& shape) {
  if (shape.kind() == Shape::Kind::Point) return std::make_shared<fcl::Sphered>(shape.margin());
  if (shape.kind() == Shape::Kind::Segment)
    return std::make_shared<fcl::Capsuled>(shape.margin(), 2.0 * shape.halfExtents().z());
  if (shape.margin() != 0.0) throw std::invalid_argument("FCL has no margin about boxes, hulls and round solids");
  return fclCore(shape);
}

void addTriangles(FclMesh& mesh, const Shape& polytope, const Eigen::Isometry3d& mesh_T_shape) {
  const ConvexHull hull = polytope.kind() == Shape::Kind::Box ? hullOfBox(polytope) : polytope.hull();
  if (hull.triangles().empty()) throw std::invalid_argument("FCL has no points and no segments");
  std::vector<Eigen::Vector3d> points;
  for (const Eigen::Vector3d& vertex : hull.vertices()) points.push_back(mesh_T_shape * vertex);
  std::vector<fcl::Triangle> triangles;
  for (const auto& [i, j, k] : hull.triangles())
    triangles.emplace_back(static_cast<std::size_t>(i), static_cast<std::size_t>(j), static_cast<std::size_t>(k));
  mesh.addSubModel(points, triangles);
}

}  // namespace proximity_server::tools
