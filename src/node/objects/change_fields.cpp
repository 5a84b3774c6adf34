#include "node/objects/change_fields.h"

#include "proximity_server/QueryStatus.h"
#include "proximity_server/narrowphase/shape/shape.h"
#include "proximity_server/scene/object_files/object_file.h"

#include <array>
#include <cmath>
#include <utility>

namespace proximity_server::node {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

constexpr double kMaxReach = 1e6;  // [m] an object must not be farther from its frame

constexpr std::size_t kMaxNameLength = 1024;  // [characters] as for names in a URDF

std::string entry(const std::string& list, std::size_t index) { return list + "[" + std::to_string(index) + "]"; }

narrowphase::Shape shapeOf(const shape_msgs::SolidPrimitive& primitive) {
  for (const scene::PrimitiveType& type : scene::primitiveTypes()) {
    if (type.number != primitive.type) continue;
    if (primitive.dimensions.size() != type.dimensions)
      throw std::invalid_argument("dimensions has " + std::to_string(primitive.dimensions.size()) +
                                  " numbers instead of " + type.meaning);
    return type.shape({primitive.dimensions.begin(), primitive.dimensions.end()});
  }
  throw std::invalid_argument("type " + std::to_string(primitive.type) + " is none of BOX, SPHERE, CYLINDER and CONE");
}

/// Boxes that are too thin or not finite are refused later, when the object is made of them.
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
  // A relative path is refused: the client may run on another machine, so there is no folder in which it could begin.
  scene::MeshFile file{scene::absoluteUri(message.uri, ""), {message.scale.x, message.scale.y, message.scale.z}};
  if (file.scale == Vector3d::Zero()) file.scale.setOnes();
  if (!file.scale.allFinite() || (file.scale.array() == 0.0).any())
    throw std::invalid_argument("scale has a number that is zero or not finite");
  return file;
}

/// Makes the half-space a x + b y + c z + d <= 0.
scene::HalfSpace halfSpaceOf(const shape_msgs::Plane& plane) {
  const auto half_space = scene::halfSpaceOf({plane.coef[0], plane.coef[1], plane.coef[2]}, plane.coef[3]);
  if (!half_space) throw std::invalid_argument("coef: a number is not finite, or a, b and c are zero");
  return *half_space;
}

/// A quaternion of zeros is the identity; any other is normalised. `field` begins the error message.
Isometry3d poseFrom(const geometry_msgs::Pose& pose, const std::string& field) {
  const Vector3d position(pose.position.x, pose.position.y, pose.position.z);
  Eigen::Quaterniond rotation(pose.orientation.w, pose.orientation.x, pose.orientation.y, pose.orientation.z);
  if (!position.allFinite()) throw std::invalid_argument(field + ": the position is not finite");
  if (!rotation.coeffs().allFinite()) throw std::invalid_argument(field + ": the orientation is not finite");
  if (rotation.coeffs() == Eigen::Vector4d::Zero()) rotation.setIdentity();
  rotation.coeffs().stableNormalize();
  return Eigen::Translation3d(position) * rotation;
}

/// A kind of shapes with the names of its lists in the message.
struct GeometryKind {
  const char* shapes;
  const char* poses;
  decltype(&ObjectChange::primitive_poses) pose_list;
};
/// In the order of the kinds of geometry in scene::ObjectShape.
const std::array<GeometryKind, 5> kKinds = {{{"primitives", "primitive_poses", &ObjectChange::primitive_poses},
                                             {"boxes", "boxes_poses", &ObjectChange::boxes_poses},
                                             {"meshes", "mesh_poses", &ObjectChange::mesh_poses},
                                             {"mesh_files", "mesh_file_poses", &ObjectChange::mesh_file_poses},
                                             {"planes", "plane_poses", &ObjectChange::plane_poses}}};

std::vector<Isometry3d> posesOf(const ObjectChange& change, const GeometryKind& kind) {
  std::vector<Isometry3d> poses;
  for (const geometry_msgs::Pose& pose : change.*kind.pose_list)
    poses.push_back(poseFrom(pose, entry(kind.poses, poses.size())));
  return poses;
}

/// Adds the shapes of one kind at their poses. `read` makes the geometry of a shape from its message.
template <class Messages, class Read>
void addAll(const ObjectChange& change, const GeometryKind& kind, const Messages& messages, Read read,
            std::vector<scene::ObjectShape>& shapes) {
  const std::vector<Isometry3d> poses = posesOf(change, kind);
  if (!poses.empty() && poses.size() != messages.size()) {
    throw std::invalid_argument(std::string(kind.poses) + " has " + std::to_string(poses.size()) + " entries, " +
                                kind.shapes + " has " + std::to_string(messages.size()));
  }
  for (std::size_t i = 0; i < messages.size(); ++i) {
    try {
      shapes.push_back({read(messages[i]), poses.empty() ? Isometry3d::Identity() : poses[i]});
    } catch (const std::invalid_argument& error) {
      refuseField(entry(kind.shapes, i), error.what());
    }
  }
}

std::vector<scene::ObjectShape> shapesOf(const ObjectChange& change) {
  std::vector<scene::ObjectShape> shapes;
  addAll(change, kKinds[0], change.primitives, shapeOf, shapes);
  addAll(change, kKinds[1], change.boxes, boxesOf, shapes);
  addAll(change, kKinds[2], change.meshes, meshOf, shapes);
  addAll(change, kKinds[3], change.mesh_files, meshFileOf, shapes);
  addAll(change, kKinds[4], change.planes, halfSpaceOf, shapes);
  return shapes;
}

// --- fields

/// The optional fields that an operation may have.
struct OperationFields {
  const char* name;
  bool shapes, shape_poses, padding, link, touch_links, keep_pose, frame;
};
/// The index is the number of the operation in the message, which is also that of scene::ObjectEdit::Operation.
constexpr std::array<OperationFields, 7> kOperations = {{{"ADD", true, true, true, true, true, false, true},
                                                         {"REPLACE", true, true, true, true, true, false, true},
                                                         {"APPEND", true, true, false, false, true, false, false},
                                                         {"MOVE", false, true, false, false, false, false, true},
                                                         {"ATTACH", false, false, false, true, true, true, false},
                                                         {"DETACH", false, false, false, false, false, false, true},
                                                         {"REMOVE", false, false, false, false, false, false, false}}};

void requireFieldsOf(const OperationFields& allowed, const ObjectChange& change) {
  const auto require_empty = [&](bool is_allowed, bool is_empty, const char* field) {
    if (!is_allowed && !is_empty) refuseField(field, std::string(allowed.name) + " does not take it");
  };
  const bool has_no_shapes = change.primitives.empty() && change.boxes.empty() && change.meshes.empty() &&
                             change.mesh_files.empty() && change.planes.empty();
  require_empty(allowed.shapes, has_no_shapes, "shapes");
  for (const GeometryKind& kind : kKinds)
    require_empty(allowed.shape_poses, (change.*kind.pose_list).empty(), kind.poses);
  require_empty(allowed.padding, change.padding == 0.0, "padding");
  require_empty(allowed.link, change.link.empty(), "link");
  require_empty(allowed.touch_links, change.touch_links.empty(), "touch_links");
  require_empty(allowed.keep_pose, !change.keep_pose, "keep_pose");
  require_empty(allowed.frame, change.frame.empty(), "frame");
  if (allowed.link && !change.link.empty() && !change.frame.empty()) refuseField("frame", "it goes without link only");
  const bool adds = allowed.padding;
  if (adds && change.link.empty() && !change.touch_links.empty()) refuseField("touch_links", "they go with link only");
  if (adds && (!(change.padding >= 0.0) || !std::isfinite(change.padding)))
    refuseField("padding", "it is negative, or not finite");
}

void requireLengths(const ObjectChange& change) {
  requireLength(change.id, "id");
  requireLength(change.link, "link");
  requireLength(change.frame, "frame");
  requireLength(change.header.frame_id, "header.frame_id");
  for (const std::string& link : change.touch_links) requireLength(link, "touch_links");
}

}  // namespace

ChangeError ChangeError::within(const std::string& where, const std::invalid_argument& error) {
  const auto* with_code = dynamic_cast<const ChangeError*>(&error);
  return {with_code ? with_code->code() : static_cast<std::int8_t>(QueryStatus::INVALID_ARGUMENT),
          where + ": " + error.what()};
}

void refuseField(const std::string& field, const std::string& reason) {
  throw std::invalid_argument(field + ": " + reason);
}

void requireLength(const std::string& name, const std::string& field) {
  if (name.size() > kMaxNameLength)
    refuseField(field,
                "it has " + std::to_string(name.size()) + " characters, more than " + std::to_string(kMaxNameLength));
}

Isometry3d requireReach(const Isometry3d& pose) {
  if (!pose.matrix().allFinite() || pose.translation().norm() > kMaxReach)
    refuseField("pose", "it is farther than 1e6 m from its frame, or not finite");
  return pose;
}

scene::ObjectEdit editOf(const ObjectChange& change) {
  using Operation = scene::ObjectEdit::Operation;
  requireLengths(change);
  if (change.operation >= kOperations.size())
    refuseField("operation", std::to_string(change.operation) + " does not exist");
  requireFieldsOf(kOperations[change.operation], change);
  scene::ObjectEdit edit;
  edit.id = change.id;
  edit.operation = static_cast<Operation>(change.operation);
  edit.place.link = change.link;
  edit.place.touch_links = change.touch_links;
  edit.place.frame = change.frame;
  edit.padding = change.padding;
  if (kOperations[change.operation].shapes) edit.shapes = shapesOf(change);
  if (edit.operation == Operation::Append && edit.shapes.empty()) refuseField("shapes", "there are none");
  if (edit.operation == Operation::Detach || change.keep_pose) edit.pose = scene::ObjectEdit::Pose::Kept;
  if (edit.operation == Operation::Remove || edit.pose == scene::ObjectEdit::Pose::Kept) return edit;
  edit.place.pose = requireReach(poseFrom(change.pose, "pose"));
  edit.place.pose_frame = change.header.frame_id;
  return edit;
}

std::vector<scene::ObjectShape> movedShapes(const ObjectChange& change, const std::vector<scene::ObjectShape>& shapes) {
  std::vector<scene::ObjectShape> moved;
  for (std::size_t kind = 0; kind < kKinds.size(); ++kind) {
    const std::vector<Isometry3d> poses = posesOf(change, kKinds[kind]);
    if (poses.empty()) continue;
    if (moved.empty()) moved = shapes;
    std::vector<scene::ObjectShape*> of_kind;
    for (scene::ObjectShape& shape : moved)
      if (shape.geometry.index() == kind) of_kind.push_back(&shape);
    if (of_kind.size() != poses.size())
      refuseField(kKinds[kind].poses, std::to_string(poses.size()) + " poses for " + std::to_string(of_kind.size()) +
                                          " shapes of this kind");
    for (std::size_t i = 0; i < poses.size(); ++i) of_kind[i]->object_T_shape = poses[i];
  }
  return moved;
}

geometry_msgs::Pose toMessage(const Isometry3d& pose) {
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
