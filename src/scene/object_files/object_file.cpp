#include "proximity_server/scene/object_files/object_file.h"

#include "proximity_server/scene/mesh/mesh_resolver.h"
#include "proximity_server/scene/mesh/readable_file.h"
#include "proximity_server/scene/model/names.h"
#include "proximity_server/scene/sensed/cloud_file.h"
#include "scene/files/field.h"
#include "system/number_text.h"

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
using Operation = ObjectEdit::Operation;

constexpr std::uintmax_t kLargestFile = std::uintmax_t{256} << 20;
constexpr long kMostVertices = std::numeric_limits<int>::max();

double numberOf(const Field& field) { return field.number(); }
double angleOf(const Field& field) {
  const double angle = field.angle();
  if (!field.isText() && std::abs(angle) > 2.0 * M_PI) {
    const std::string number = system::shortest(angle);
    field.warn(number + " rad is more than a turn; degrees are written " + number + "deg");
  }
  return angle;
}

/// Reads numbers by their names, where a missing one is 0, or as a list in their order.
template <std::size_t N>
std::array<double, N> numbersOf(const Field& field, const std::array<const char*, N>& names,
                                double (*read)(const Field&) = numberOf) {
  std::array<double, N> numbers{};
  if (field.isList()) {
    const std::vector<Field> entries = field.entries();
    if (entries.size() != N)
      field.refuse("has " + std::to_string(entries.size()) + " numbers instead of " + std::to_string(N));
    for (std::size_t i = 0; i < N; ++i) numbers[i] = read(entries[i]);
    return numbers;
  }
  field.requireMembers({names.begin(), names.end()});
  for (std::size_t i = 0; i < N; ++i)
    if (const auto number = field.find(names[i])) numbers[i] = read(*number);
  return numbers;
}

Vector3d vectorOf(const Field& field) {
  const auto numbers = numbersOf<3>(field, {"x", "y", "z"});
  return {numbers[0], numbers[1], numbers[2]};
}

Eigen::Quaterniond rotationOfRpy(const Field& field) {
  const auto angles = numbersOf<3>(field, {"roll", "pitch", "yaw"}, angleOf);
  return Eigen::AngleAxisd(angles[2], Vector3d::UnitZ()) * Eigen::AngleAxisd(angles[1], Vector3d::UnitY()) *
         Eigen::AngleAxisd(angles[0], Vector3d::UnitX());
}

Isometry3d poseOf(const Field& field) {
  field.requireMembers({"position", "orientation", "rpy"});
  const auto position = field.find("position"), orientation = field.find("orientation"), rpy = field.find("rpy");
  if (orientation && rpy) rpy->refuse("it goes without orientation only");
  Isometry3d pose = Isometry3d::Identity();
  if (position) pose.translation() = vectorOf(*position);
  if (rpy) pose.linear() = rotationOfRpy(*rpy).toRotationMatrix();
  if (!orientation) return pose;
  const auto q = numbersOf<4>(*orientation, {"x", "y", "z", "w"});
  return poseFrom(pose.translation(), {q[3], q[0], q[1], q[2]});
}

// --- shapes

std::vector<Vector3d> vectorsOf(const Field& field) {
  std::vector<Vector3d> vectors;
  for (const Field& entry : field.entries()) vectors.push_back(vectorOf(entry));
  return vectors;
}

narrowphase::Shape primitiveOf(const Field& field) {
  field.requireMembers({"type", "dimensions"});
  const Field type = field.member("type");
  return field.checked(primitiveFrom, type.isText() ? type.text() : std::to_string(type.wholeNumber()),
                       field.member("dimensions").numbers());
}

/// The path of the file may be relative to the folder.
Boxes cloudOf(const std::filesystem::path& file, const std::string& folder, double resolution) {
  if (folder.empty() && file.is_relative())
    throw std::invalid_argument("cloud is '" + file.string() + "', a relative path, and there is no folder for it");
  return {readCloudBoxes(folder / file, resolution)};
}

Boxes boxesOf(const Field& field, const std::string& folder) {
  field.requireMembers({"centres", "sizes", "cloud", "resolution"});
  if (const auto cloud = field.find("cloud")) {
    field.requireMembers({"cloud", "resolution"});
    const auto resolution = field.find("resolution");
    return field.checked(cloudOf, cloud->text(), folder, resolution ? resolution->number() : kVoxelEdge);
  }
  field.requireMembers({"centres", "sizes"});
  return field.checked(boxesFrom, vectorsOf(field.member("centres")), vectorsOf(field.member("sizes")));
}

TriangleMesh meshOf(const Field& field) {
  field.requireMembers({"triangles", "vertices"});
  std::vector<std::array<int, 3>> triangles;
  const Field list = field.member("triangles");
  for (const Field& triangle : list.entries()) {
    triangle.requireMembers({"vertex_indices"});
    const Field indices = triangle.member("vertex_indices");
    const std::vector<Field> corners = indices.entries();
    if (corners.size() != 3) indices.refuse("has " + std::to_string(corners.size()) + " numbers instead of 3");
    const auto vertex = [&](std::size_t i) {
      return static_cast<int>(std::min(corners[i].wholeNumber(), kMostVertices));
    };
    triangles.push_back({vertex(0), vertex(1), vertex(2)});
  }
  return field.checked(meshFrom, vectorsOf(field.member("vertices")), std::move(triangles));
}

MeshFile meshFileOf(const Field& field, const std::string& folder) {
  field.requireMembers({"uri", "scale"});
  const auto scale = field.find("scale");
  return field.checked(meshFileFrom, field.member("uri").text(), folder, scale ? vectorOf(*scale) : Vector3d::Ones());
}

HalfSpace planeOf(const Field& field) {
  field.requireMembers({"coef"});
  const Field coef = field.member("coef");
  const std::vector<double> n = coef.numbers();
  if (n.size() != 4) coef.refuse("has " + std::to_string(n.size()) + " numbers instead of 4");
  return field.checked(halfSpaceFrom, n[0], n[1], n[2], n[3]);
}

/// Reads the shapes of one kind and their poses; `read` makes the geometry of one shape.
template <class Read>
void readShapes(std::size_t kind, const Field& object, const Read& read, ObjectEdit& edit) {
  if (const auto list = object.find(kShapeKinds[kind].shapes))
    for (const Field& entry : list->entries()) edit.shapes.push_back({read(entry)});
  if (const auto poses = object.find(kShapeKinds[kind].poses))
    for (const Field& entry : poses->entries()) edit.shape_poses[kind].push_back(poseOf(entry));
}

// --- objects

/// Reads an operation on an object. The map has the `others` besides the fields of the operation and the id.
ObjectEdit editOf(const Field& field, const OperationFields& operation, std::vector<std::string> others,
                  const std::string& folder) {
  others.emplace_back("id");
  others.insert(others.end(), operation.takes.begin(), operation.takes.end());
  field.requireMembers(others);
  ObjectEdit edit;
  edit.source = field.place();
  edit.operation = operation.operation;
  edit.id = field.member("id").text();
  const auto link = field.find("link"), touch_links = field.find("touch_links"), frame = field.find("frame"),
             pose = field.find("pose"), padding = field.find("padding"), keep_pose = field.find("keep_pose");
  if (link) edit.place.link = link->text();
  if (touch_links) edit.place.touch_links = touch_links->texts();
  if (frame) edit.place.frame = frame->text();
  if (pose) edit.place.pose = poseOf(*pose);
  if (padding) edit.padding = padding->number();
  const bool keeps = keep_pose && keep_pose->truth();
  if (keeps && pose) pose->refuse("it goes without keep_pose only");
  if (keeps || edit.operation == Operation::Detach) edit.pose = ObjectEdit::Pose::Kept;
  readShapes(0, field, primitiveOf, edit);
  readShapes(
      1, field, [&](const Field& boxes) { return boxesOf(boxes, folder); }, edit);
  readShapes(2, field, meshOf, edit);
  readShapes(
      3, field, [&](const Field& mesh) { return meshFileOf(mesh, folder); }, edit);
  readShapes(4, field, planeOf, edit);
  field.checked(completeFields, edit);
  return edit;
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

const OperationFields& operationOf(const Field& field) {
  for (const OperationFields& operation : operationFields())
    if (operation.operation != Operation::Append && field.text() == operation.name) return operation;
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
  ObjectEdit edit = editOf(field, operation, {"at", "operation"}, folder);
  if (edit.operation == Operation::Attach) field.member("link");
  return {momentOf(field.member("at")), std::move(edit)};
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

ObjectFile objectFileFrom(const FileValue& value, const std::string& source, const std::string& folder) {
  ObjectFile file;
  const Field root(value, source, &file.warnings);
  const auto readObjects = [&](const Field& list) {
    for (const Field& entry : list.entries())
      file.objects.push_back(editOf(entry, operationFields().front(), {}, folder));
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
  if (isCloudFile(path)) {
    ObjectEdit cloud;
    cloud.source = path;
    cloud.id = std::filesystem::path(path).stem();
    cloud.shapes.push_back({Boxes{readCloudBoxes(path, kVoxelEdge)}});
    ObjectFile file;
    file.objects.push_back(std::move(cloud));
    return file;
  }
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
