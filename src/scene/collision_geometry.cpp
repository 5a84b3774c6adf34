#include "collision_geometry.h"

#include <limits>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <type_traits>

namespace urdf {
class Capsule;  // not in every urdfdom
}

namespace proximity_server {
namespace {

using Eigen::Vector3d;

Vector3d toEigen(const urdf::Vector3& v) { return {v.x, v.y, v.z}; }

template <typename... Parts>
std::string text(const Parts&... parts) {
  std::ostringstream stream;
  (stream << ... << parts);
  return stream.str();
}

/// A <capsule>, where this urdfdom has a class for it.
template <typename UrdfCapsule, typename = void>
struct CapsuleReader {
  static std::optional<CollisionGeometry> read(const urdf::Geometry& /*geometry*/) { return std::nullopt; }
};
template <typename UrdfCapsule>
struct CapsuleReader<UrdfCapsule, std::void_t<decltype(sizeof(UrdfCapsule))>> {
  static std::optional<CollisionGeometry> read(const urdf::Geometry& geometry) {
    const auto* capsule = dynamic_cast<const UrdfCapsule*>(&geometry);
    if (!capsule) return std::nullopt;
    return CollisionGeometry{text("capsule, radius ", capsule->radius, ", length ", capsule->length),
                             {Capsule{capsule->radius, capsule->length}}};
  }
};

/// The collision that is a sphere of this radius centred here, or -1.
int findSphere(const std::vector<urdf::CollisionSharedPtr>& collisions, double radius, const Vector3d& centre,
               double rounding) {
  for (std::size_t i = 0; i < collisions.size(); ++i) {
    const auto* sphere = dynamic_cast<const urdf::Sphere*>(collisions[i]->geometry.get());
    if (!sphere || sphere->radius != radius) continue;
    if ((toEigen(collisions[i]->origin.position) - centre).norm() <= rounding) return static_cast<int>(i);
  }
  return -1;
}

}  // namespace

Eigen::Isometry3d toEigen(const urdf::Pose& pose) {
  const urdf::Rotation& q = pose.rotation;
  return Eigen::Translation3d(toEigen(pose.position)) * Eigen::Quaterniond(q.w, q.x, q.y, q.z).normalized();
}

CollisionGeometry GeometryReader::read(const urdf::Geometry& geometry, const MeshOptions& options) {
  if (const auto* mesh = dynamic_cast<const urdf::Mesh*>(&geometry)) return readMesh(*mesh, options);
  if (const auto* sphere = dynamic_cast<const urdf::Sphere*>(&geometry)) {
    return {text("sphere, radius ", sphere->radius), {Sphere{sphere->radius}}};
  }
  if (const auto* box = dynamic_cast<const urdf::Box*>(&geometry)) {
    return {text("box ", box->dim.x, " x ", box->dim.y, " x ", box->dim.z), {Box{toEigen(box->dim)}}};
  }
  if (const auto* cylinder = dynamic_cast<const urdf::Cylinder*>(&geometry)) {
    return {text("cylinder, radius ", cylinder->radius, ", length ", cylinder->length),
            {Cylinder{cylinder->radius, cylinder->length}}};
  }
  if (auto capsule = CapsuleReader<urdf::Capsule>::read(geometry)) return *capsule;
  throw std::invalid_argument("a shape that is no sphere, box, cylinder, capsule or mesh");
}

CollisionGeometry GeometryReader::readMesh(const urdf::Mesh& mesh, const MeshOptions& options) {
  const MeshKey key{resolve_(mesh.filename), {mesh.scale.x, mesh.scale.y, mesh.scale.z}, options.tolerance};
  if (const auto known = meshes_.find(key); known != meshes_.end()) return known->second;

  MeshPieces pieces = convexPieces(loadMesh(key.file, toEigen(mesh.scale)), options);
  CollisionGeometry geometry{
      "mesh " + mesh.filename, {}, pieces.representation, pieces.deviation, pieces.uncovered, pieces.volume_ratio,
      pieces.warnings};
  for (ConvexHull& hull : pieces.hulls) geometry.shapes.emplace_back(std::move(hull));
  return meshes_.emplace(key, std::move(geometry)).first->second;
}

std::vector<CapsuleParts> findCapsules(const std::vector<urdf::CollisionSharedPtr>& collisions) {
  std::vector<CapsuleParts> capsules;
  for (std::size_t i = 0; i < collisions.size(); ++i) {
    const auto* cylinder = dynamic_cast<const urdf::Cylinder*>(collisions[i]->geometry.get());
    if (!cylinder) continue;
    const Eigen::Isometry3d pose = toEigen(collisions[i]->origin);
    // Sines of rpy, the quaternion's products and the sums of a rotated end: each adds an eps or two of the lengths.
    const double rounding =
        16.0 * std::numeric_limits<double>::epsilon() * (pose.translation().norm() + cylinder->length);
    const auto sphereAt = [&](double z) {
      return findSphere(collisions, cylinder->radius, pose * Vector3d(0, 0, z), rounding);
    };
    const std::array<int, 2> spheres{sphereAt(-0.5 * cylinder->length), sphereAt(0.5 * cylinder->length)};
    if (spheres[0] < 0 || spheres[1] < 0) continue;
    capsules.push_back({static_cast<int>(i), spheres, {cylinder->radius, cylinder->length}});
  }
  return capsules;
}

}  // namespace proximity_server
