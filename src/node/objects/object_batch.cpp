#include "node/objects/object_batch.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>
#include <variant>

#include "proximity_server/QueryStatus.h"
#include "proximity_server/scene/model/names.h"

namespace proximity_server::node {
namespace {

using Eigen::Isometry3d;

/// [m] As far as the geometry of an object may reach from its frame.
constexpr double kFarthest = 1e6;

/// Characters of a name of a client, as of one in a URDF: every cycle of the monitor may have to say it.
constexpr std::size_t kLongestName = 1024;

/// Objects among which the nearest name to an unknown one is looked for. More take longer than a change may, when a
/// stream of changes names what is not there.
constexpr std::size_t kMostSuggested = 1000;

[[noreturn]] void refuse(const std::string& field, const std::string& reason) {
  throw std::invalid_argument(field + ": " + reason);
}

void requireEmpty(bool empty, const std::string& field, const std::string& operation) {
  if (!empty) refuse(field, operation + " does not take it");
}

/// Which of the optional fields an operation takes.
struct Takes {
  const char* name;
  bool shapes, shape_poses, padding, link, touch_links, keep_pose, frame;
};

Takes fieldsOf(const ObjectChange& change) {
  switch (change.operation) {
    case ObjectChange::ADD:
      return {"ADD", true, true, true, true, true, false, true};
    case ObjectChange::REPLACE:
      return {"REPLACE", true, true, true, true, true, false, true};
    case ObjectChange::APPEND:
      return {"APPEND", true, true, false, false, true, false, false};
    case ObjectChange::MOVE:
      return {"MOVE", false, true, false, false, false, false, true};
    case ObjectChange::ATTACH:
      return {"ATTACH", false, false, false, true, true, true, false};
    case ObjectChange::DETACH:
      return {"DETACH", false, false, false, false, false, false, true};
    case ObjectChange::REMOVE:
      return {"REMOVE", false, false, false, false, false, false, false};
    default:
      refuse("operation", std::to_string(change.operation) + " does not exist");
  }
}

void requireLength(const std::string& name, const std::string& field) {
  if (name.size() > kLongestName)
    refuse(field, "it has " + std::to_string(name.size()) + " characters, more than " + std::to_string(kLongestName));
}

void requireLengths(const ObjectChange& change) {
  requireLength(change.id, "id");
  requireLength(change.link, "link");
  requireLength(change.frame, "frame");
  requireLength(change.header.frame_id, "header.frame_id");
  for (const std::string& link : change.touch_links) requireLength(link, "touch_links");
}

/// A name for an error, which is logged.
std::string quoted(const std::string& name) {
  return scene::quoted(name.size() > kLongestName ? name.substr(0, 40) + "..." : name);
}

void requireFieldsOfOperation(const ObjectChange& change) {
  const Takes takes = fieldsOf(change);
  if (!takes.shapes) requireEmpty(!hasShapes(change), "shapes", takes.name);
  if (!takes.shape_poses) {
    for (const ShapeKind kind : kShapeKinds)
      requireEmpty(posesOf(change, kind).empty(), posesFieldOf(kind), takes.name);
  }
  if (!takes.padding) requireEmpty(change.padding == 0.0, "padding", takes.name);
  if (!takes.link) requireEmpty(change.link.empty(), "link", takes.name);
  if (!takes.touch_links) requireEmpty(change.touch_links.empty(), "touch_links", takes.name);
  if (!takes.keep_pose) requireEmpty(!change.keep_pose, "keep_pose", takes.name);
  if (!takes.frame) requireEmpty(change.frame.empty(), "frame", takes.name);
  if (takes.link && !change.link.empty() && !change.frame.empty()) refuse("frame", "it goes without link only");
  const bool adds = takes.padding;
  if (adds && change.link.empty() && !change.touch_links.empty()) refuse("touch_links", "they go with link only");
}

/// Other bytes cannot be kept in a file, and clients in Python cannot read them.
void requireText(const std::string& text, const std::string& field) {
  try {
    scene::requireUtf8(text);
  } catch (const std::invalid_argument& error) {
    refuse(field, error.what());
  }
}

Isometry3d checked(const Isometry3d& pose) {
  if (!pose.matrix().allFinite() || pose.translation().norm() > kFarthest)
    refuse("pose", "it is farther than 1e6 m from its frame, or not finite");
  return pose;
}

void requireNoPlane(const StoredObject& stored) {
  const auto is_plane = [](const SourceShape& shape) { return shape.kind == ShapeKind::Plane; };
  if (std::any_of(stored.shapes->begin(), stored.shapes->end(), is_plane))
    refuse("link", "an object with a plane cannot be attached");
}

const scene::Attached* attached(const StoredObject& stored) {
  return std::get_if<scene::Attached>(&stored.object.placement);
}

/// Makes the geometry of an object from its shapes.
scene::Object objectOf(const Robot& robot, const std::string& id, const StoredObject& stored) {
  const scene::ModelOptions& model = robot.config().model;
  scene::ObjectOptions options;
  options.padding = stored.padding;
  options.resolve = meshResolver(robot.config());
  options.meshes.tolerance = model.mesh_tolerance;
  options.meshes.cache = model.mesh_cache;
  options.meshes.time_budget = model.mesh_time_budget;
  std::vector<scene::ObjectShape> shapes;
  for (const SourceShape& shape : *stored.shapes) shapes.push_back(shape.shape);
  return scene::makeObject(id, shapes, stored.object.placement, options);
}

bool addsMeshes(const ObjectChange& change) {
  const bool adds = change.operation == ObjectChange::ADD || change.operation == ObjectChange::REPLACE;
  return adds && (!change.meshes.empty() || !change.mesh_files.empty());
}

/// The text of an error of makeObject() without the name of the object.
std::string withoutId(const std::string& text, const std::string& id) {
  const std::string start = "object " + scene::quoted(id) + ": ";
  return text.compare(0, start.size(), start) == 0 ? text.substr(start.size()) : text;
}

/// Gives the shapes of a kind new poses.
void replacePoses(const ObjectChange& change, ShapeKind kind, std::vector<SourceShape>& shapes) {
  const std::vector<Isometry3d> poses = posesOf(change, kind);
  if (poses.empty()) return;
  std::vector<SourceShape*> of_kind;
  for (SourceShape& shape : shapes)
    if (shape.kind == kind) of_kind.push_back(&shape);
  if (of_kind.size() != poses.size())
    refuse(posesFieldOf(kind),
           std::to_string(poses.size()) + " poses for " + std::to_string(of_kind.size()) + " shapes of this kind");
  for (std::size_t i = 0; i < poses.size(); ++i) of_kind[i]->shape.object_T_shape = poses[i];
}

}  // namespace

ChangeError ChangeError::within(const std::string& where, const std::invalid_argument& error) {
  const auto* with_code = dynamic_cast<const ChangeError*>(&error);
  return {with_code ? with_code->code() : static_cast<std::int8_t>(QueryStatus::INVALID_ARGUMENT),
          where + ": " + error.what()};
}

MadeObjects madeAhead(const Robot& robot, const ObjectChanges& message) {
  MadeObjects made;
  for (const ObjectChange& change : message.changes) {
    if (!addsMeshes(change)) continue;
    try {
      requireLengths(change);
      requireFieldsOfOperation(change);
      const StoredObject stored{std::make_shared<const std::vector<SourceShape>>(shapesOf(change)), change.padding, {}};
      made.emplace(&change, objectOf(robot, change.id, stored));
    } catch (const std::invalid_argument&) {
      break;  // it is found again, and told, when it is the turn of the change, and the message is refused
    }
  }
  return made;
}

void ObjectBatch::apply(const ObjectChange& change) {
  try {
    requireLengths(change);
    requireFieldsOfOperation(change);
    switch (change.operation) {
      case ObjectChange::ADD:
        requireNew(change.id);
        return add(change);
      case ObjectChange::REPLACE:
        return add(change);
      case ObjectChange::APPEND:
        return append(change);
      case ObjectChange::MOVE:
        return move(change);
      case ObjectChange::ATTACH:
        return attach(change);
      case ObjectChange::DETACH:
        return detach(change);
      default:
        return remove(change);
    }
  } catch (const std::invalid_argument& error) {
    const std::invalid_argument short_error(withoutId(error.what(), change.id));
    const auto* with_code = dynamic_cast<const ChangeError*>(&error);
    throw ChangeError::within("object " + quoted(change.id), with_code ? *with_code : short_error);
  }
}

std::vector<scene::ObjectChange> ObjectBatch::difference() const {
  std::vector<scene::ObjectChange> changes;
  for (const auto& [id, now] : touched_) {
    const bool was_there = before_.count(id) > 0;
    if (now && was_there) changes.emplace_back(scene::ReplaceObject{now->object});
    if (now && !was_there) changes.emplace_back(scene::AddObject{now->object});
    if (!now && was_there) changes.emplace_back(scene::RemoveObject{id});
  }
  return changes;
}

// --- operations

void ObjectBatch::add(const ObjectChange& change) {
  requireLegal(change.id);
  if (!(change.padding >= 0.0) || !std::isfinite(change.padding)) refuse("padding", "it is negative, or not finite");
  StoredObject stored{std::make_shared<const std::vector<SourceShape>>(shapesOf(change)), change.padding, {}};
  if (change.link.empty()) {
    const std::string frame = frameNamed(change.frame);
    stored.object.placement = placementIn(frame, placeIn(frame, change));
  } else {
    requireNoPlane(stored);
    scene::Attached held =
        attachedTo(change.link, change.touch_links, Isometry3d::Identity());  // refuses an unknown link
    held.link_T_object = placeIn(frameNamed(change.link), change);
    stored.object.placement = held;
  }
  const auto made = made_.find(&change);
  if (made == made_.end()) return make(change.id, std::move(stored));
  stored.object.id = change.id;
  stored.object.geometry = made->second.geometry;
  put(change.id, std::move(stored));
}

void ObjectBatch::add(const scene::WrittenObject& object) {
  const scene::WrittenPlace& place = object.place;
  try {
    requireNew(object.id);
    requireLegal(object.id);
    requireLength(place.link, "link");
    requireLength(place.frame, "frame");
    std::vector<SourceShape> shapes;
    for (const scene::ObjectShape& shape : object.shapes) shapes.push_back({kindOf(shape), shape});
    StoredObject stored{std::make_shared<const std::vector<SourceShape>>(std::move(shapes)), object.padding, {}};
    const Isometry3d pose = checked(place.pose);
    if (place.link.empty()) {
      stored.object.placement = placementIn(frameNamed(place.frame), pose);
    } else {
      requireNoPlane(stored);
      stored.object.placement = attachedTo(place.link, place.touch_links, pose);
    }
    make(object.id, std::move(stored));
  } catch (const std::invalid_argument& error) {
    throw std::invalid_argument(object.source + ": object " + quoted(object.id) + ": " +
                                withoutId(error.what(), object.id));
  }
}

void ObjectBatch::append(const ObjectChange& change) {
  StoredObject stored = require(change.id);
  std::vector<SourceShape> added = shapesOf(change);
  if (added.empty()) refuse("shapes", "there are none");
  const Carried carried = carriedBy(robot_, stored.object.placement);
  const Isometry3d object_T_added = carried.frame_T_object.inverse() * placeIn(carried.frame, change);
  std::vector<SourceShape> shapes = *stored.shapes;
  for (SourceShape& shape : added) {
    shape.shape.object_T_shape = object_T_added * shape.shape.object_T_shape;
    shapes.push_back(std::move(shape));
  }
  stored.shapes = std::make_shared<const std::vector<SourceShape>>(std::move(shapes));
  if (auto* held = std::get_if<scene::Attached>(&stored.object.placement)) {
    requireNoPlane(stored);
    held->touch_links = attachedTo("", change.touch_links, held->link_T_object).touch_links;
    const auto& before = attached(require(change.id))->touch_links;
    held->touch_links.insert(held->touch_links.begin(), before.begin(), before.end());
  } else if (!change.touch_links.empty()) {
    refuse("touch_links", "no link holds the object");
  }
  make(change.id, std::move(stored));
}

void ObjectBatch::move(const ObjectChange& change) {
  StoredObject stored = require(change.id);
  if (attached(stored))
    refuse("operation",
           "link " + scene::quoted(attached(stored)->link) + " holds it: DETACH it, or ATTACH it elsewhere");
  const std::string frame = frameNamed(change.frame);
  stored.object.placement = placementIn(frame, placeIn(frame, change));
  const auto has_poses = [&](ShapeKind kind) { return !posesOf(change, kind).empty(); };
  if (std::none_of(kShapeKinds.begin(), kShapeKinds.end(), has_poses)) return put(change.id, std::move(stored));
  std::vector<SourceShape> shapes = *stored.shapes;
  for (const ShapeKind kind : kShapeKinds) replacePoses(change, kind, shapes);
  stored.shapes = std::make_shared<const std::vector<SourceShape>>(std::move(shapes));
  make(change.id, std::move(stored));
}

void ObjectBatch::attach(const ObjectChange& change) {
  StoredObject stored = require(change.id);
  if (change.link.empty()) refuse("link", "it is empty");
  requireNoPlane(stored);
  const scene::Attached unplaced =
      attachedTo(change.link, change.touch_links, Isometry3d::Identity());  // refuses an unknown link
  const std::string frame = frameNamed(change.link);
  const Carried carried = carriedBy(robot_, stored.object.placement);
  const Isometry3d link_T_object =
      change.keep_pose ? checked(seenFrom(frame, carried.frame, carried.frame_T_object)) : placeIn(frame, change);
  stored.object.placement = scene::Attached{unplaced.link, unplaced.touch_links, link_T_object};
  put(change.id, std::move(stored));
}

void ObjectBatch::detach(const ObjectChange& change) {
  StoredObject stored = require(change.id);
  if (!attached(stored)) refuse("operation", "no link holds it");
  const Carried carried = carriedBy(robot_, stored.object.placement);
  const std::string frame = frameNamed(change.frame);
  stored.object.placement = placementIn(frame, checked(seenFrom(frame, carried.frame, carried.frame_T_object)));
  put(change.id, std::move(stored));
}

void ObjectBatch::remove(const ObjectChange& change) {
  if (change.id.empty()) refuse("id", "it is empty");
  if (change.id != "*") {
    touch(change.id, nullptr);
    return;
  }
  for (const auto& [id, object] : StoredObjects(touched_)) touch(id, nullptr);
  for (const auto& [id, object] : before_) touch(id, nullptr);
}

// --- objects

const StoredObject* ObjectBatch::find(const std::string& id) const {
  if (const auto found = touched_.find(id); found != touched_.end()) return found->second.get();
  const auto found = before_.find(id);
  return found == before_.end() ? nullptr : found->second.get();
}

const StoredObject& ObjectBatch::require(const std::string& id) const {
  if (const StoredObject* found = find(id)) return *found;
  const std::string unknown = "there is no object with this id";
  if (before_.size() + touched_.size() > kMostSuggested) refuse("id", unknown);
  std::vector<std::string> known;
  for (const StoredObjects* objects : {&before_, &touched_})
    for (const auto& [other, object] : *objects)
      if (find(other)) known.push_back(other);
  const std::string nearest = scene::nearestName(id, known);
  refuse("id", unknown + (nearest.empty() ? "" : " (did you mean '" + nearest + "'?)"));
}

void ObjectBatch::touch(const std::string& id, std::shared_ptr<const StoredObject> object) {
  const auto [place, is_new] = touched_.try_emplace(id);
  before_touched_.emplace_back(id, is_new ? std::nullopt : std::make_optional(place->second));
  place->second = std::move(object);
}

void ObjectBatch::undo() {
  for (; !before_touched_.empty(); before_touched_.pop_back()) {
    auto& [id, before] = before_touched_.back();
    if (before)
      touched_[id] = *before;
    else
      touched_.erase(id);
  }
}

void ObjectBatch::requireNew(const std::string& id) const {
  if (find(id)) refuse("id", "there is an object with this id already");
}

void ObjectBatch::requireLegal(const std::string& id) const {
  if (id.empty()) refuse("id", "it is empty");
  if (id == "*") refuse("id", "it stands for all objects");
  requireLength(id, "id");
  if (robot_.robotModel().findLink(id) >= 0) refuse("id", "a link has this name");
  requireText(id, "id");
}

void ObjectBatch::put(const std::string& id, StoredObject object) {
  touch(id, std::make_shared<const StoredObject>(std::move(object)));
}

/// Makes the geometry anew.
void ObjectBatch::make(const std::string& id, StoredObject stored) {
  stored.object = objectOf(robot_, id, stored);
  put(id, std::move(stored));
}

// --- frames

/// The frame in tf that a client names: "" is the reference frame, and a link has its frame.
std::string ObjectBatch::frameNamed(const std::string& name) const {
  const std::string plain = !name.empty() && name.front() == '/' ? name.substr(1) : name;
  if (plain.empty()) return robot_.referenceFrame();
  const int link = robot_.linkOfFrame(plain);
  return link < 0 ? plain : robot_.frameOf(link);
}

const Isometry3d& ObjectBatch::referenceTo(const std::string& frame) {
  if (const auto failed = no_frames_.find(frame); failed != no_frames_.end()) throw failed->second;
  const auto [found, is_new] = frames_.try_emplace(frame, Isometry3d::Identity());
  if (!is_new || frame == robot_.referenceFrame()) return found->second;
  try {
    found->second = find_frame_(robot_, frame);
  } catch (const ChangeError& error) {
    frames_.erase(found);
    no_frames_.emplace(frame, error);
    throw;
  } catch (...) {
    frames_.erase(found);
    throw;
  }
  return found->second;
}

/// What has the pose `pose` in the frame `other`, seen from `frame`.
Isometry3d ObjectBatch::seenFrom(const std::string& frame, const std::string& other, const Isometry3d& pose) {
  if (frame == other) return pose;
  return referenceTo(frame).inverse() * referenceTo(other) * pose;
}

/// The pose of a change in the frame.
Isometry3d ObjectBatch::placeIn(const std::string& frame, const ObjectChange& change) {
  const Isometry3d pose = checked(poseFrom(change.pose, "pose"));
  return checked(seenFrom(frame, frameNamed(change.header.frame_id), pose));
}

scene::Attached ObjectBatch::attachedTo(const std::string& link_name, const std::vector<std::string>& touch_links,
                                        const Isometry3d& link_T_object) const {
  const scene::RobotModel& robot = robot_.robotModel();
  const auto requireLink = [&](const std::string& link, const std::string& field) {
    if (robot.findLink(link) < 0)
      refuse(field, "there is no link '" + link + "' (did you mean '" +
                        scene::nearestName(link, scene::namesOf(robot.links)) + "'?)");
  };
  if (!link_name.empty()) requireLink(link_name, "link");
  for (const std::string& link : touch_links) requireLink(link, "touch_links");
  return {link_name, touch_links, link_T_object};
}

scene::Placement ObjectBatch::placementIn(const std::string& frame, const Isometry3d& frame_T_object) const {
  requireText(frame, "frame");
  if (frame == robot_.referenceFrame()) return scene::Fixed{frame_T_object};
  return scene::Moving{frame, frame_T_object};
}

Carried carriedBy(const Robot& robot, const scene::Placement& placement) {
  if (const auto* fixed = std::get_if<scene::Fixed>(&placement)) return {robot.referenceFrame(), fixed->world_T_object};
  if (const auto* moving = std::get_if<scene::Moving>(&placement)) return {moving->frame, moving->frame_T_object};
  const auto& held = std::get<scene::Attached>(placement);
  return {robot.frameOf(robot.robotModel().findLink(held.link)), held.link_T_object};
}

}  // namespace proximity_server::node
