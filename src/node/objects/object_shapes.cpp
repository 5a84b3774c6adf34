#include "node/objects/object_shapes.h"

#include <cmath>
#include <cstdint>
#include <stdexcept>
#include <utility>
#include <variant>

#include "proximity_server/narrowphase/shape/shape.h"
#include "proximity_server/scene/object_files/object_file.h"

namespace proximity_server::node {
namespace {

using Eigen::Vector3d;
using shape_msgs::SolidPrimitive;

std::string entry(const std::string& list, std::size_t index) { return list + "[" + std::to_string(index) + "]"; }

/// Runs `read`; an error of it gets the name of the field.
template <class Read>
auto readField(const std::string& field, Read read) {
  try {
    return read();
  } catch (const std::invalid_argument& error) {
    throw std::invalid_argument(field + ": " + error.what());
  }
}

void requireDimensions(const SolidPrimitive& primitive, std::size_t count, const char* meaning) {
  if (primitive.dimensions.size() == count) return;
  throw std::invalid_argument("dimensions has " + std::to_string(primitive.dimensions.size()) + " numbers instead of " +
                              meaning);
}

narrowphase::Shape shapeOf(const SolidPrimitive& primitive) {
  const auto& size = primitive.dimensions;
  switch (primitive.type) {
    case SolidPrimitive::BOX:
      requireDimensions(primitive, 3, "3, the edges along x, y and z");
      return narrowphase::Box{{size[SolidPrimitive::BOX_X], size[SolidPrimitive::BOX_Y], size[SolidPrimitive::BOX_Z]}};
    case SolidPrimitive::SPHERE:
      requireDimensions(primitive, 1, "1, the radius");
      return narrowphase::Sphere{size[SolidPrimitive::SPHERE_RADIUS]};
    case SolidPrimitive::CYLINDER:
      requireDimensions(primitive, 2, "2, height and radius");
      return narrowphase::Cylinder{size[SolidPrimitive::CYLINDER_RADIUS], size[SolidPrimitive::CYLINDER_HEIGHT]};
    case SolidPrimitive::CONE:
      requireDimensions(primitive, 2, "2, height and radius");
      return narrowphase::Cone{size[SolidPrimitive::CONE_RADIUS], size[SolidPrimitive::CONE_HEIGHT]};
    default:
      throw std::invalid_argument("type " + std::to_string(primitive.type) +
                                  " is none of BOX, SPHERE, CYLINDER and CONE");
  }
}

/// Which of the boxes is too thin or not finite is found when the object is made of them.
scene::Boxes boxesOf(const Boxes& message) {
  if (message.sizes.size() != 1 && message.sizes.size() != message.centres.size()) {
    throw std::invalid_argument("sizes has " + std::to_string(message.sizes.size()) + " entries, neither 1 nor the " +
                                std::to_string(message.centres.size()) + " of centres");
  }
  scene::Boxes boxes;
  boxes.boxes.reserve(message.centres.size());
  for (std::size_t i = 0; i < message.centres.size(); ++i) {
    const geometry_msgs::Vector3& size = message.sizes[message.sizes.size() == 1 ? 0 : i];
    const geometry_msgs::Point& centre = message.centres[i];
    const Vector3d half = 0.5 * Vector3d(size.x, size.y, size.z), middle(centre.x, centre.y, centre.z);
    boxes.boxes.emplace_back(middle - half, middle + half);
  }
  return boxes;
}

scene::TriangleMesh meshOf(const shape_msgs::Mesh& message) {
  scene::TriangleMesh mesh;
  mesh.vertices.reserve(message.vertices.size());
  for (const geometry_msgs::Point& vertex : message.vertices) mesh.vertices.emplace_back(vertex.x, vertex.y, vertex.z);
  mesh.triangles.reserve(message.triangles.size());
  for (std::size_t i = 0; i < message.triangles.size(); ++i) {
    std::array<int, 3> corners{};
    for (std::size_t k = 0; k < corners.size(); ++k) {
      const std::uint32_t vertex = message.triangles[i].vertex_indices[k];
      if (vertex >= mesh.vertices.size()) {
        throw std::invalid_argument(entry("triangles", i) + " names vertex " + std::to_string(vertex) + " of " +
                                    std::to_string(mesh.vertices.size()));
      }
      corners[k] = static_cast<int>(vertex);
    }
    mesh.triangles.push_back(corners);
  }
  return mesh;
}

scene::MeshFile meshFileOf(const MeshFile& message) {
  scene::requireUtf8(message.uri);
  // There is no folder in which a relative path could begin: the client may run elsewhere.
  scene::MeshFile file{scene::absoluteUri(message.uri, ""), {message.scale.x, message.scale.y, message.scale.z}};
  if (file.scale == Vector3d::Zero()) file.scale.setOnes();
  if (!file.scale.allFinite() || (file.scale.array() == 0.0).any())
    throw std::invalid_argument("scale has a number that is zero or not finite");
  return file;
}

/// The half-space a x + b y + c z + d <= 0.
scene::HalfSpace halfSpaceOf(const shape_msgs::Plane& plane) {
  const Vector3d normal(plane.coef[0], plane.coef[1], plane.coef[2]);
  const double length = normal.stableNorm();
  const double offset = -plane.coef[3] / length;
  if (!(length > 0.0) || !std::isfinite(length) || !std::isfinite(offset))
    throw std::invalid_argument("coef: a number is not finite, or a, b and c are zero");
  return {normal / length, offset};
}

const std::vector<geometry_msgs::Pose>& posesField(const ObjectChange& change, ShapeKind kind) {
  switch (kind) {
    case ShapeKind::Primitive:
      return change.primitive_poses;
    case ShapeKind::Boxes:
      return change.boxes_poses;
    case ShapeKind::Mesh:
      return change.mesh_poses;
    case ShapeKind::MeshFile:
      return change.mesh_file_poses;
    case ShapeKind::Plane:
      break;
  }
  return change.plane_poses;
}

/// Adds the shapes of one kind at their poses; `read` makes the geometry of one.
template <class Messages, class Read>
void addAll(const ObjectChange& change, ShapeKind kind, const std::string& field, const Messages& messages, Read read,
            std::vector<SourceShape>& shapes) {
  const std::vector<Eigen::Isometry3d> poses = posesOf(change, kind);
  if (!poses.empty() && poses.size() != messages.size()) {
    throw std::invalid_argument(std::string(posesFieldOf(kind)) + " has " + std::to_string(poses.size()) +
                                " entries, " + field + " has " + std::to_string(messages.size()));
  }
  for (std::size_t i = 0; i < messages.size(); ++i) {
    readField(entry(field, i), [&] {
      shapes.push_back({kind, {read(messages[i]), poses.empty() ? Eigen::Isometry3d::Identity() : poses[i]}});
    });
  }
}

}  // namespace

const char* posesFieldOf(ShapeKind kind) {
  switch (kind) {
    case ShapeKind::Primitive:
      return "primitive_poses";
    case ShapeKind::Boxes:
      return "boxes_poses";
    case ShapeKind::Mesh:
      return "mesh_poses";
    case ShapeKind::MeshFile:
      return "mesh_file_poses";
    case ShapeKind::Plane:
      break;
  }
  return "plane_poses";
}

ShapeKind kindOf(const scene::ObjectShape& shape) {
  if (std::holds_alternative<scene::TriangleMesh>(shape.geometry)) return ShapeKind::Mesh;
  if (std::holds_alternative<scene::MeshFile>(shape.geometry)) return ShapeKind::MeshFile;
  if (std::holds_alternative<scene::Boxes>(shape.geometry)) return ShapeKind::Boxes;
  return std::holds_alternative<scene::HalfSpace>(shape.geometry) ? ShapeKind::Plane : ShapeKind::Primitive;
}

bool hasShapes(const ObjectChange& change) {
  return !change.primitives.empty() || !change.boxes.empty() || !change.meshes.empty() || !change.mesh_files.empty() ||
         !change.planes.empty();
}

std::vector<SourceShape> shapesOf(const ObjectChange& change) {
  std::vector<SourceShape> shapes;
  addAll(change, ShapeKind::Primitive, "primitives", change.primitives, shapeOf, shapes);
  addAll(change, ShapeKind::Boxes, "boxes", change.boxes, boxesOf, shapes);
  addAll(change, ShapeKind::Mesh, "meshes", change.meshes, meshOf, shapes);
  addAll(change, ShapeKind::MeshFile, "mesh_files", change.mesh_files, meshFileOf, shapes);
  addAll(change, ShapeKind::Plane, "planes", change.planes, halfSpaceOf, shapes);
  return shapes;
}

std::vector<Eigen::Isometry3d> posesOf(const ObjectChange& change, ShapeKind kind) {
  std::vector<Eigen::Isometry3d> poses;
  for (const geometry_msgs::Pose& pose : posesField(change, kind))
    poses.push_back(poseFrom(pose, entry(posesFieldOf(kind), poses.size())));
  return poses;
}

Eigen::Isometry3d poseFrom(const geometry_msgs::Pose& pose, const std::string& field) {
  const Vector3d position(pose.position.x, pose.position.y, pose.position.z);
  Eigen::Quaterniond rotation(pose.orientation.w, pose.orientation.x, pose.orientation.y, pose.orientation.z);
  if (!position.allFinite()) throw std::invalid_argument(field + ": the position is not finite");
  if (!rotation.coeffs().allFinite()) throw std::invalid_argument(field + ": the orientation is not finite");
  if (rotation.coeffs() == Eigen::Vector4d::Zero()) rotation.setIdentity();
  rotation.coeffs().stableNormalize();
  return Eigen::Translation3d(position) * rotation;
}

geometry_msgs::Pose toMessage(const Eigen::Isometry3d& pose) {
  const Eigen::Quaterniond rotation(pose.linear());
  geometry_msgs::Pose message;
  message.position.x = pose.translation().x();
  message.position.y = pose.translation().y();
  message.position.z = pose.translation().z();
  message.orientation.x = rotation.x();
  message.orientation.y = rotation.y();
  message.orientation.z = rotation.z();
  message.orientation.w = rotation.w();
  return message;
}

}  // namespace proximity_server::node
