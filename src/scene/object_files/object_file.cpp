#include "proximity_server/scene/object_files/object_file.h"

#include "proximity_server/scene/mesh/mesh_resolver.h"
#include "proximity_server/scene/mesh/readable_file.h"
#include "proximity_server/scene/model/names.h"
#include "scene/files/field.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <stdexcept>
#include <utility>

namespace proximity_server::scene {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

constexpr std::uintmax_t kLargestFile = std::uintmax_t{256} << 20;

/// Reads numbers by their names, where a missing one is 0, or as a list in their order.
template <std::size_t N>
std::array<double, N> numbersOf(const Field& field, const std::array<const char*, N>& names) {
  std::array<double, N> numbers{};
  if (field.isList()) {
    const std::vector<Field> entries = field.entries();
    if (entries.size() != N)
      field.refuse("has " + std::to_string(entries.size()) + " numbers instead of " + std::to_string(N));
    for (std::size_t i = 0; i < N; ++i) numbers[i] = entries[i].number();
    return numbers;
  }
  field.requireMembers({names.begin(), names.end()});
  for (std::size_t i = 0; i < N; ++i)
    if (const auto number = field.find(names[i])) numbers[i] = number->number();
  return numbers;
}

Vector3d vectorOf(const Field& field) {
  const auto numbers = numbersOf<3>(field, {"x", "y", "z"});
  return {numbers[0], numbers[1], numbers[2]};
}

/// A quaternion of zeros is the identity; any other is normalised.
Eigen::Quaterniond orientationOf(const Field& field) {
  const auto numbers = numbersOf<4>(field, {"x", "y", "z", "w"});
  Eigen::Quaterniond rotation(numbers[3], numbers[0], numbers[1], numbers[2]);
  if (rotation.coeffs() == Eigen::Vector4d::Zero()) return Eigen::Quaterniond::Identity();
  rotation.coeffs().stableNormalize();
  return rotation;
}

Eigen::Quaterniond rotationOfRpy(const Field& field) {
  const auto angles = numbersOf<3>(field, {"roll", "pitch", "yaw"});
  return Eigen::AngleAxisd(angles[2], Vector3d::UnitZ()) * Eigen::AngleAxisd(angles[1], Vector3d::UnitY()) *
         Eigen::AngleAxisd(angles[0], Vector3d::UnitX());
}

Isometry3d poseOf(const Field& field) {
  field.requireMembers({"position", "orientation", "rpy"});
  const auto position = field.find("position"), orientation = field.find("orientation"), rpy = field.find("rpy");
  if (orientation && rpy) rpy->refuse("it goes without orientation only");
  Isometry3d pose = Isometry3d::Identity();
  if (position) pose.translation() = vectorOf(*position);
  if (orientation) pose.linear() = orientationOf(*orientation).toRotationMatrix();
  if (rpy) pose.linear() = rotationOfRpy(*rpy).toRotationMatrix();
  return pose;
}

// --- shapes

narrowphase::Shape shapeOf(const Field& field) {
  field.requireMembers({"type", "dimensions"});
  const Field type = field.member("type"), dimensions = field.member("dimensions");
  const auto is_meant = [&](const PrimitiveType& known) {
    return type.isText() ? type.text() == known.name : type.number() == known.number;
  };
  const auto known = std::find_if(primitiveTypes().begin(), primitiveTypes().end(), is_meant);
  if (known == primitiveTypes().end()) type.refuse("is none of BOX, SPHERE, CYLINDER and CONE");
  const std::vector<double> size = dimensions.numbers();
  if (size.size() != known->dimensions)
    dimensions.refuse("has " + std::to_string(size.size()) + " numbers instead of " + known->meaning);
  try {
    return known->shape(size);
  } catch (const std::invalid_argument& error) {
    dimensions.refuse(error.what());
  }
}

TriangleMesh meshOf(const Field& field) {
  field.requireMembers({"triangles", "vertices"});
  TriangleMesh mesh;
  const Field vertex_list = field.member("vertices"), triangle_list = field.member("triangles");
  for (const Field& vertex : vertex_list.entries()) mesh.vertices.push_back(vectorOf(vertex));
  for (const Field& triangle : triangle_list.entries()) {
    triangle.requireMembers({"vertex_indices"});
    const Field indices = triangle.member("vertex_indices");
    const std::vector<Field> corners = indices.entries();
    if (corners.size() != 3) indices.refuse("has " + std::to_string(corners.size()) + " numbers instead of 3");
    std::array<int, 3> vertices{};
    for (std::size_t i = 0; i < vertices.size(); ++i) {
      const long vertex = corners[i].wholeNumber();
      if (vertex >= static_cast<long>(mesh.vertices.size()))
        corners[i].refuse("names vertex " + std::to_string(vertex) + " of " + std::to_string(mesh.vertices.size()));
      vertices[i] = static_cast<int>(vertex);
    }
    mesh.triangles.push_back(vertices);
  }
  return mesh;
}

MeshFile meshFileOf(const Field& field, const std::string& folder) {
  field.requireMembers({"uri", "scale"});
  const Field uri = field.member("uri");
  MeshFile file;
  try {
    file.uri = absoluteUri(uri.text(), folder);
  } catch (const std::invalid_argument& error) {
    uri.refuse(error.what());
  }
  if (const auto scale = field.find("scale")) {
    file.scale = vectorOf(*scale);
    if (file.scale == Vector3d::Zero()) file.scale.setOnes();
    if ((file.scale.array() == 0.0).any()) scale->refuse("has a number that is zero");
  }
  return file;
}

/// The half-space a x + b y + c z + d <= 0.
HalfSpace planeOf(const Field& field) {
  field.requireMembers({"coef"});
  const Field coef = field.member("coef");
  const std::vector<double> numbers = coef.numbers();
  if (numbers.size() != 4) coef.refuse("has " + std::to_string(numbers.size()) + " numbers instead of 4");
  const auto half_space = halfSpaceOf({numbers[0], numbers[1], numbers[2]}, numbers[3]);
  if (!half_space) coef.refuse("a, b and c are zero, or beyond what a number can be");
  return *half_space;
}

Vector3d edgesOf(const Field& field) {
  const Vector3d edges = vectorOf(field);
  if (!(edges.array() > 0.0).all()) field.refuse("has an edge that is not positive");
  return edges;
}

Boxes boxesOf(const Field& field) {
  field.requireMembers({"centres", "sizes"});
  const Field centre_list = field.member("centres"), size_list = field.member("sizes");
  const std::vector<Field> centres = centre_list.entries(), sizes = size_list.entries();
  if (sizes.size() != 1 && sizes.size() != centres.size())
    size_list.refuse("has " + std::to_string(sizes.size()) + " entries, neither 1 nor one for each of " +
                     std::to_string(centres.size()) + " centres");
  Boxes boxes;
  boxes.boxes.reserve(centres.size());
  std::vector<Vector3d> edges;
  edges.reserve(sizes.size());
  for (const Field& size : sizes) edges.push_back(edgesOf(size));
  for (std::size_t i = 0; i < centres.size(); ++i) {
    const Vector3d half = 0.5 * edges[edges.size() == 1 ? 0 : i];
    const Vector3d middle = vectorOf(centres[i]);
    boxes.boxes.emplace_back(middle - half, middle + half);
    if (!(boxes.boxes.back().sizes().array() > 0.0).all())
      centres[i].refuse("is so far away that rounding leaves nothing of a box of this size");
  }
  return boxes;
}

/// Adds the shapes of one kind in their poses; `read` makes the geometry of one shape.
template <class Read>
void addShapes(const Field& object, const std::string& kind, const std::string& poses_name, Read read,
               std::vector<ObjectShape>& shapes) {
  const auto list = object.find(kind), poses = object.find(poses_name);
  const std::size_t begin = shapes.size();
  if (list)
    for (const Field& entry : list->entries()) shapes.push_back({read(entry)});
  if (!poses) return;
  const std::vector<Field> entries = poses->entries();
  const std::size_t count = shapes.size() - begin;
  if (!entries.empty() && entries.size() != count)
    poses->refuse("has " + std::to_string(entries.size()) + " entries, " + kind + " has " + std::to_string(count));
  for (std::size_t i = 0; i < entries.size(); ++i) shapes[begin + i].object_T_shape = poseOf(entries[i]);
}

// --- objects

const std::vector<std::string> kPlaceFields = {"link", "touch_links", "frame", "pose"};
const std::vector<std::string> kShapeFields = {"primitives", "primitive_poses", "boxes",      "boxes_poses",
                                               "meshes",     "mesh_poses",      "mesh_files", "mesh_file_poses",
                                               "planes",     "plane_poses",     "padding"};

std::vector<std::string> fields(std::initializer_list<std::vector<std::string>> groups) {
  std::vector<std::string> all;
  for (const std::vector<std::string>& group : groups) all.insert(all.end(), group.begin(), group.end());
  return all;
}

ObjectPlace placeOf(const Field& field) {
  ObjectPlace place;
  const auto link = field.find("link"), touch_links = field.find("touch_links"), frame = field.find("frame");
  if (link) place.link = link->text();
  if (frame) place.frame = frame->text();
  if (touch_links) place.touch_links = touch_links->texts();
  if (const auto pose = field.find("pose")) place.pose = poseOf(*pose);
  if (!place.link.empty() && !place.frame.empty()) frame->refuse("it goes without link only");
  if (place.link.empty() && !place.touch_links.empty()) touch_links->refuse("they go with link only");
  return place;
}

// Reads the id and the place of an object, and ignores other fields.

ObjectEdit placedObject(const Field& field) {
  ObjectEdit object;
  object.source = field.place();
  object.id = field.member("id").text();
  object.place = placeOf(field);
  return object;
}

/// Reads an object with its shapes, for Add and Replace.
ObjectEdit shapedObject(const Field& field, const std::string& folder) {
  ObjectEdit object = placedObject(field);
  if (const auto padding = field.find("padding")) {
    object.padding = padding->number();
    if (object.padding < 0.0) padding->refuse("is negative");
  }
  addShapes(field, "primitives", "primitive_poses", shapeOf, object.shapes);
  addShapes(field, "boxes", "boxes_poses", boxesOf, object.shapes);
  addShapes(field, "meshes", "mesh_poses", meshOf, object.shapes);
  const auto readMeshFile = [&](const Field& mesh) { return meshFileOf(mesh, folder); };
  addShapes(field, "mesh_files", "mesh_file_poses", readMeshFile, object.shapes);
  addShapes(field, "planes", "plane_poses", planeOf, object.shapes);
  if (object.shapes.empty()) field.refuse("has no shape: none of primitives, boxes, meshes, mesh_files and planes");
  return object;
}

ObjectEdit objectOf(const Field& field, const std::string& folder) {
  field.requireMembers(fields({{"id"}, kPlaceFields, kShapeFields}));
  return shapedObject(field, folder);
}

WrittenRule ruleOf(const Field& field) {
  field.requireMembers({"a", "b", "allowed"});
  const auto name = [&](const char* which) {
    const Field text = field.member(which);
    if (text.text().empty()) text.refuse("is empty");
    return text.text();
  };
  const bool allowed = field.member("allowed").truth();
  return {name("a"), name("b"), allowed ? AllowedPairs::Rule::Allowed : AllowedPairs::Rule::Checked};
}

// --- changes

using Operation = ObjectEdit::Operation;

struct OperationFields {
  const char* name;
  Operation operation;
  std::vector<std::string> takes;
};
const std::array<OperationFields, 6> kOperations = {
    {{"ADD", Operation::Add, fields({kPlaceFields, kShapeFields})},
     {"REPLACE", Operation::Replace, fields({kPlaceFields, kShapeFields})},
     {"MOVE", Operation::Move, {"frame", "pose"}},
     {"ATTACH", Operation::Attach, {"link", "touch_links", "pose", "keep_pose"}},
     {"DETACH", Operation::Detach, {"frame"}},
     {"REMOVE", Operation::Remove, {}}}};

const OperationFields& operationOf(const Field& field) {
  for (const OperationFields& operation : kOperations)
    if (field.text() == operation.name) return operation;
  field.refuse("is none of ADD, REPLACE, MOVE, ATTACH, DETACH and REMOVE");
}

Moment momentOf(const Field& field) {
  field.requireMembers({"row", "time"});
  const auto row = field.find("row"), time = field.find("time");
  if (static_cast<bool>(row) == static_cast<bool>(time)) field.refuse("must have either row or time");
  if (row) return AtRow{row->wholeNumber()};
  return AtTime{time->number()};
}

WrittenChange changeOf(const Field& field, const std::string& folder) {
  const OperationFields& operation = operationOf(field.member("operation"));
  field.requireMembers(fields({{"at", "operation", "id"}, operation.takes}));
  const bool has_shapes = operation.operation == Operation::Add || operation.operation == Operation::Replace;
  const Moment at = momentOf(field.member("at"));
  ObjectEdit edit = has_shapes ? shapedObject(field, folder) : placedObject(field);
  edit.operation = operation.operation;
  if (edit.operation == Operation::Detach) edit.pose = ObjectEdit::Pose::Kept;
  if (edit.operation != Operation::Attach) return {at, edit};
  field.member("link");
  const auto keep_pose = field.find("keep_pose");
  if (keep_pose && keep_pose->truth()) {
    if (const auto pose = field.find("pose")) pose->refuse("it goes without keep_pose only");
    edit.pose = ObjectEdit::Pose::Kept;
  }
  return {at, edit};
}

/// Refuses a change that would be made before the change above it.
void requireOrder(const std::vector<Field>& entries, const std::vector<WrittenChange>& changes) {
  long row = 0;
  double time = -std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < changes.size(); ++i) {
    const auto* at_row = std::get_if<AtRow>(&changes[i].at);
    const auto* at_time = std::get_if<AtTime>(&changes[i].at);
    if ((at_row && at_row->row < row) || (at_time && at_time->time < time))
      entries[i].member("at").refuse("comes before a change above it: changes are made in their order");
    if (at_row) row = at_row->row;
    if (at_time) time = at_time->time;
  }
}

}  // namespace

Objects withRules(const Objects& objects, const std::vector<WrittenRule>& rules) {
  ObjectRules next = objects.rules();
  next.allowed = {};
  for (const WrittenRule& rule : rules) next.allowed.set(rule.a, rule.b, rule.rule);
  return objects.withRules(std::move(next));
}

const std::array<PrimitiveType, 4>& primitiveTypes() {
  using Sizes = std::vector<double>;
  using narrowphase::Shape;
  static const std::array<PrimitiveType, 4> all = {{
      {"BOX", 1, 3, "3, the edges along x, y and z",
       [](const Sizes& d) -> Shape {
         return narrowphase::Box{{d[0], d[1], d[2]}};
       }},
      {"SPHERE", 2, 1, "1, the radius", [](const Sizes& d) -> Shape { return narrowphase::Sphere{d[0]}; }},
      {"CYLINDER", 3, 2, "2, height and radius",
       [](const Sizes& d) -> Shape {
         return narrowphase::Cylinder{d[1], d[0]};
       }},
      {"CONE", 4, 2, "2, height and radius",
       [](const Sizes& d) -> Shape {
         return narrowphase::Cone{d[1], d[0]};
       }},
  }};
  return all;
}

std::optional<HalfSpace> halfSpaceOf(const Vector3d& normal, double d) {
  const double length = normal.stableNorm(), offset = -d / length;
  if (!(length > 0.0) || !std::isfinite(length) || !std::isfinite(offset)) return std::nullopt;
  return HalfSpace{normal / length, offset};
}

ObjectFile objectFileFrom(const FileValue& value, const std::string& source, const std::string& folder) {
  const Field root(value, source);
  ObjectFile file;
  const auto readObjects = [&](const Field& list) {
    for (const Field& entry : list.entries()) file.objects.push_back(objectOf(entry, folder));
  };
  if (root.isList()) {
    readObjects(root);
    return file;
  }
  root.requireMembers({"objects", "rules", "changes"});
  if (const auto objects = root.find("objects")) readObjects(*objects);
  if (const auto rules = root.find("rules"))
    for (const Field& entry : rules->entries()) file.rules.push_back(ruleOf(entry));
  if (const auto changes = root.find("changes")) {
    const std::vector<Field> entries = changes->entries();
    for (const Field& entry : entries) file.changes.push_back(changeOf(entry, folder));
    requireOrder(entries, file.changes);
  }
  return file;
}

ObjectFile readObjectFile(const std::string& path) {
  requireReadable(path);
  std::error_code failed;
  const std::uintmax_t size = std::filesystem::file_size(path, failed);
  if (failed) throw std::invalid_argument(path + ": is no file");  // for example a pipe
  if (size > kLargestFile) throw std::invalid_argument(path + ": is larger than 256 MiB");
  std::ifstream stream(path, std::ios::binary);
  const std::string text{std::istreambuf_iterator<char>(stream), {}};
  if (stream.bad()) throw std::invalid_argument(path + ": reading failed");
  if (std::filesystem::path(path).extension() == ".scene") return readMoveitScene(text, path);
  return objectFileFrom(readYaml(text, path), path, std::filesystem::absolute(path).parent_path());
}

}  // namespace proximity_server::scene
