#include "node/objects/change_fields.h"

#include "proximity_server/QueryStatus.h"
#include "proximity_server/scene/model/names.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <utility>

namespace proximity_server::node {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;
using Operation = scene::ObjectEdit::Operation;
using Rule = scene::AllowedPairs::Rule;

constexpr std::uint32_t kNoVertex = std::numeric_limits<int>::max();  // no mesh has as many

constexpr std::size_t kMaxNameLength = 1024;  // [characters] as for names in a URDF

/// Returns the result of `act`. Its errors become a ChangeError, and get where() in front unless they begin with it.
template <class Where, class Act>
auto within(const Where& where, const Act& act) {
  try {
    return act();
  } catch (const std::invalid_argument& error) {
    const auto* with_code = dynamic_cast<const ChangeError*>(&error);
    const std::string start = where() + ": ", text = error.what();
    throw ChangeError(with_code ? with_code->code() : static_cast<std::int8_t>(QueryStatus::INVALID_ARGUMENT),
                      text.compare(0, start.size(), start) == 0 ? text : start + text);
  }
}

template <class Act>
auto withinEntry(const char* list, std::size_t index, const Act& act) {
  return within([&] { return std::string(list) + "[" + std::to_string(index) + "]"; }, act);
}

template <class Act>
auto withinObject(const std::string& id, const Act& act) {
  return within([&] { return "object " + scene::quoted(id); }, act);
}

// --- shapes

template <class Message>
Vector3d vectorOf(const Message& message) {
  return {message.x, message.y, message.z};
}

template <class Messages>
std::vector<Vector3d> vectorsOf(const Messages& messages) {
  std::vector<Vector3d> vectors;
  vectors.reserve(messages.size());
  for (const auto& message : messages) vectors.push_back(vectorOf(message));
  return vectors;
}

scene::TriangleMesh meshOf(const shape_msgs::Mesh& message) {
  std::vector<std::array<int, 3>> triangles;
  triangles.reserve(message.triangles.size());
  for (const shape_msgs::MeshTriangle& triangle : message.triangles) {
    std::array<int, 3>& vertices = triangles.emplace_back();
    std::transform(triangle.vertex_indices.begin(), triangle.vertex_indices.end(), vertices.begin(),
                   [](std::uint32_t vertex) { return static_cast<int>(std::min<std::uint32_t>(vertex, kNoVertex)); });
  }
  return scene::meshFrom(vectorsOf(message.vertices), std::move(triangles));
}

scene::MeshFile meshFileOf(const MeshFile& message) {
  scene::requireUtf8(message.uri);
  // A relative path is refused: the client may run on another machine, so there is no folder in which it could begin.
  return scene::meshFileFrom(message.uri, "", vectorOf(message.scale));
}

Isometry3d poseOf(const geometry_msgs::Pose& pose) {
  const geometry_msgs::Quaternion& q = pose.orientation;
  return scene::poseFrom(vectorOf(pose.position), {q.w, q.x, q.y, q.z});
}

/// Reads the shapes of one kind and their poses. `read` makes the geometry of a shape from its message.
template <class Messages, class Read>
void readShapes(std::size_t kind, const Messages& messages, const std::vector<geometry_msgs::Pose>& poses,
                const Read& read, scene::ObjectEdit& edit) {
  const scene::ShapeKind& names = scene::kShapeKinds[kind];
  for (std::size_t i = 0; i < messages.size(); ++i)
    withinEntry(names.shapes, i, [&] { edit.shapes.push_back({read(messages[i])}); });
  for (std::size_t i = 0; i < poses.size(); ++i)
    withinEntry(names.poses, i, [&] { edit.shape_poses[kind].push_back(poseOf(poses[i])); });
}

// --- fields

/// Refuses a name that is too long, because every cycle of the monitor may have to publish it, and one that is not
/// UTF-8: it cannot be written into a file, and clients in Python cannot read it.
void requireName(const std::string& field, const std::string& name) {
  if (name.empty()) return;
  if (name.size() > kMaxNameLength)
    scene::refuseField(
        field, "it has " + std::to_string(name.size()) + " characters, more than " + std::to_string(kMaxNameLength));
  within([&] { return field; }, [&] { scene::requireUtf8(name); });
}

void requireNames(const scene::ObjectEdit& edit) {
  requireName("id", edit.id);
  requireName("link", edit.place.link);
  requireName("frame", edit.place.frame);
  if (edit.place.pose_frame) requireName("header.frame_id", *edit.place.pose_frame);
  for (const std::string& link : edit.place.touch_links) requireName("touch_links", link);
}

/// Refuses the name of a tracked source.
void requireUntracked(const Robot& robot, const std::string& id) {
  if (const TrackedSource* const source = robot.config().findTracked(id))
    scene::refuseField("id",
                       "it is a " + source->kind() + " source: only messages on '" + source->topic + "' change it");
}

/// Reads a change, and makes the geometry of an object with meshes.
scene::ObjectEdit editOf(const Robot& robot, const ObjectChange& change, scene::ObjectOptions& options) {
  requireUntracked(robot, change.id);
  if (change.operation >= scene::operationFields().size())
    scene::refuseField("operation", std::to_string(change.operation) + " does not exist");
  scene::ObjectEdit edit;
  edit.id = change.id;
  edit.operation = static_cast<Operation>(change.operation);
  edit.place = {change.link, change.touch_links, change.frame};
  edit.padding = change.padding;
  const auto primitive = [](const auto& p) { return scene::primitiveFrom(std::to_string(p.type), p.dimensions); };
  const auto boxes = [](const auto& b) { return scene::boxesFrom(vectorsOf(b.centres), vectorsOf(b.sizes)); };
  const auto plane = [](const auto& p) { return scene::halfSpaceFrom(p.coef[0], p.coef[1], p.coef[2], p.coef[3]); };
  readShapes(0, change.primitives, change.primitive_poses, primitive, edit);
  readShapes(1, change.boxes, change.boxes_poses, boxes, edit);
  readShapes(2, change.meshes, change.mesh_poses, meshOf, edit);
  readShapes(3, change.mesh_files, change.mesh_file_poses, meshFileOf, edit);
  readShapes(4, change.planes, change.plane_poses, plane, edit);
  if (edit.operation == Operation::Detach || change.keep_pose) edit.pose = scene::ObjectEdit::Pose::Kept;
  if (edit.operation != Operation::Remove && edit.pose == scene::ObjectEdit::Pose::Given) {
    edit.place.pose =
        scene::requireReach(within([] { return std::string("pose"); }, [&] { return poseOf(change.pose); }));
    edit.place.pose_frame = change.header.frame_id;
  }
  requireNames(edit);
  scene::completeFields(edit);
  const bool has_meshes = !change.meshes.empty() || !change.mesh_files.empty();
  if (!has_meshes || edit.operation == Operation::Append) return edit;
  options.padding = edit.padding;
  edit.geometry = scene::makeObject(edit.id, std::move(edit.shapes), scene::Fixed{}, options).geometry;
  return edit;
}

std::vector<scene::WrittenRule> rulesOf(const std::vector<PairRule>& messages) {
  std::vector<scene::WrittenRule> rules;
  for (const PairRule& message : messages) {
    withinEntry("rules", rules.size(), [&] {
      if (message.a.empty() || message.b.empty()) throw std::invalid_argument("a name is empty");
      scene::requireUtf8(message.a);
      scene::requireUtf8(message.b);
    });
    rules.push_back({message.a, message.b, message.allowed ? Rule::Allowed : Rule::Checked});
  }
  return rules;
}

/// Removes all objects but those of tracked sources.
void removeAll(const std::vector<std::string>& tracked, scene::ObjectEditor& objects) {
  for (const std::string& id : objects.ids())
    if (std::find(tracked.begin(), tracked.end(), id) == tracked.end()) objects.apply(removalOf(id));
}

}  // namespace

scene::ObjectOptions objectOptions(const Robot& robot) {
  const scene::ModelOptions& model = robot.config().model;
  scene::ObjectOptions options;
  options.resolve = robot.config().meshResolver();
  options.meshes.tolerance = model.mesh_tolerance;
  options.meshes.cache = model.mesh_cache;
  options.meshes.time_budget = model.mesh_time_budget;
  options.meshes.stop = model.stop;
  return options;
}

scene::ObjectEdit removalOf(const std::string& id) {
  scene::ObjectEdit removal;
  removal.id = id;
  removal.operation = Operation::Remove;
  return removal;
}

ReadChanges readChanges(const Robot& robot, const ObjectChanges& message) {
  scene::ObjectOptions options = objectOptions(robot);
  ReadChanges read;
  for (const TrackedSource& source : robot.config().tracked) read.tracked.push_back(source.name);
  try {
    for (const ObjectChange& change : message.changes) {
      const auto read_change = [&] { return editOf(robot, change, options); };
      read.edits.push_back(
          withinEntry("changes", read.edits.size(), [&] { return withinObject(change.id, read_change); }));
    }
    if (message.set_rules) read.rules = rulesOf(message.rules);
  } catch (const ChangeError& error) {
    read.error = error;
  }
  return read;
}

std::string apply(ReadChanges& changes, scene::ObjectEditor& objects) {
  if (changes.error) throw *changes.error;
  std::vector<std::string> missing;
  for (std::size_t i = 0; i < changes.edits.size(); ++i) {
    const std::string id = changes.edits[i].id;
    const bool is_removed = changes.edits[i].operation == scene::ObjectEdit::Operation::Remove;
    if (is_removed && id != "*" && !objects.find(id)) missing.push_back(id);
    const auto apply_change = [&] {
      is_removed&& id == "*" ? removeAll(changes.tracked, objects) : objects.apply(std::move(changes.edits[i]));
    };
    withinEntry("changes", i, [&] { withinObject(id, apply_change); });
  }
  if (missing.empty()) return {};
  const std::string more = missing.size() > 1 ? " (and " + std::to_string(missing.size() - 1) + " more)" : "";
  return "REMOVE: there was no object " + scene::quoted(missing.front()) + more;
}

void add(const scene::ObjectEdit& object, scene::ObjectEditor& objects) {
  const auto check_and_add = [&] {
    requireNames(object);
    scene::requireReach(object.place.pose);
    objects.apply(object);
  };
  within([&] { return object.source; }, [&] { withinObject(object.id, check_and_add); });
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
