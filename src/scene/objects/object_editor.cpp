#include "proximity_server/scene/objects/object_editor.h"

#include "proximity_server/scene/model/names.h"
#include "scene/objects/placed_object.h"

#include <algorithm>
#include <stdexcept>
#include <utility>
#include <variant>

namespace proximity_server::scene {

using Eigen::Isometry3d;
using Operation = ObjectEdit::Operation;

namespace {

/// The nearest name to an unknown one is searched among no more objects than this: the search must not slow down a
/// stream of changes that all name unknown objects.
constexpr std::size_t kMaxSearchedNames = 1000;

}  // namespace

std::string carrierOf(const Object& object, const ObjectFrames& frames) {
  if (const auto* moving = std::get_if<Moving>(&object.placement)) return moving->frame;
  const auto* held = std::get_if<Attached>(&object.placement);
  return held ? frames.ofLink(held->link) : frames.named("");
}

const Isometry3d& poseInCarrier(const Object& object) {
  if (const auto* fixed = std::get_if<Fixed>(&object.placement)) return fixed->world_T_object;
  if (const auto* moving = std::get_if<Moving>(&object.placement)) return moving->frame_T_object;
  return std::get<Attached>(object.placement).link_T_object;
}

void ObjectEditor::apply(ObjectEdit edit) {
  if (edit.operation == Operation::Remove) return remove(edit.id);
  const bool is_whole = edit.operation == Operation::Add || edit.operation == Operation::Replace;
  Object object = is_whole ? Object{edit.id, std::move(edit.geometry), {}} : require(edit.id);
  check(edit, object);
  const auto has_poses = [](const std::vector<Isometry3d>& of_kind) { return !of_kind.empty(); };
  if (edit.operation == Operation::Move && std::any_of(edit.shape_poses.begin(), edit.shape_poses.end(), has_poses)) {
    edit.shapes = givenShapesOf(object);
    placeShapes(edit.shape_poses, edit.shapes);
  }
  if (edit.operation == Operation::Append)
    append(edit, object);
  else
    object.placement = placementFor(edit, object);
  if (!object.geometry || (!is_whole && !edit.shapes.empty())) {
    ObjectOptions options = options_;
    options.padding = is_whole ? edit.padding : paddingOf(object);
    object = makeObject(edit.id, std::move(edit.shapes), object.placement, options);
  }
  if (std::holds_alternative<Attached>(object.placement) && hasHalfSpace(object))
    refuseObject(edit.id, "link: an object with a plane cannot be attached");
  set(edit.id, std::make_shared<const Object>(std::move(object)));
}

/// Refuses an operation that does not fit the robot and the present objects.
void ObjectEditor::check(const ObjectEdit& edit, const Object& before) const {
  const RobotModel& robot = before_.model().robot;
  const ObjectPlace& place = edit.place;
  const auto* held = std::get_if<Attached>(&before.placement);
  if (edit.operation == Operation::Add || edit.operation == Operation::Replace) {
    if (edit.operation == Operation::Add && find(edit.id))
      refuseObject(edit.id, "id: there is an object with this id already");
    requireUsableId(robot, edit.id);
  }
  if (edit.operation == Operation::Move && held)
    refuseObject(edit.id, "operation: link " + quoted(held->link) + " holds it: DETACH it, or ATTACH it elsewhere");
  if (edit.operation == Operation::Detach && !held) refuseObject(edit.id, "operation: no link holds it");
  if (edit.operation == Operation::Attach && place.link.empty()) refuseObject(edit.id, "link: it is empty");
  if (!place.touch_links.empty() && place.link.empty() && !(edit.operation == Operation::Append && held))
    refuseObject(edit.id, "touch_links: no link holds the object");
  if (!place.link.empty()) requireLink(robot, place.link, "link", edit.id);
  for (const std::string& link : place.touch_links) requireLink(robot, link, "touch_links", edit.id);
}

void ObjectEditor::remove(const std::string& id) {
  if (id.empty()) refuseObject(id, "id: it is empty");
  if (id != "*") return set(id, nullptr);
  for (const std::string& each : ids()) set(each, nullptr);
}

/// Puts the shapes of the object before the shapes of the edit, and transforms the latter into the object's frame.
void ObjectEditor::append(ObjectEdit& edit, Object& object) {
  const Isometry3d object_T_added = poseInCarrier(object).inverse() * poseIn(carrierOf(object, frames_), edit.place);
  for (ObjectShape& shape : edit.shapes) shape.object_T_shape = object_T_added * shape.object_T_shape;
  const std::vector<ObjectShape>& shapes = givenShapesOf(object);
  edit.shapes.insert(edit.shapes.begin(), shapes.begin(), shapes.end());
  if (auto* held = std::get_if<Attached>(&object.placement))
    held->touch_links.insert(held->touch_links.end(), edit.place.touch_links.begin(), edit.place.touch_links.end());
}

// --- places

Placement ObjectEditor::placementFor(const ObjectEdit& edit, const Object& before) {
  const ObjectPlace& place = edit.place;
  const bool is_held = edit.operation == Operation::Attach || !place.link.empty();
  const std::string frame = is_held ? frames_.ofLink(place.link) : frames_.named(place.frame);
  const Isometry3d pose = edit.pose == ObjectEdit::Pose::Given
                              ? poseIn(frame, place)
                              : frames_.seenFrom(frame, carrierOf(before, frames_), poseInCarrier(before));
  if (is_held) return Attached{place.link, place.touch_links, pose};
  if (frame == frames_.named("")) return Fixed{pose};
  return Moving{frame, pose};
}

Isometry3d ObjectEditor::poseIn(const std::string& frame, const ObjectPlace& place) {
  return place.pose_frame ? frames_.seenFrom(frame, frames_.named(*place.pose_frame), place.pose) : place.pose;
}

// --- objects

const Object* ObjectEditor::find(const std::string& id) const {
  if (const auto found = changed_.find(id); found != changed_.end()) return found->second.get();
  return before_.object(before_.find(id));
}

const Object& ObjectEditor::require(const std::string& id) const {
  if (const Object* found = find(id)) return *found;
  const std::size_t count = static_cast<std::size_t>(before_.size()) + changed_.size();
  const std::string nearest = count > kMaxSearchedNames ? "" : nearestName(id, ids());
  refuseObject(
      id, "id: there is no object with this id" + (nearest.empty() ? "" : " (did you mean " + quoted(nearest) + "?)"));
}

std::vector<std::string> ObjectEditor::ids() const {
  std::vector<std::string> ids;
  for (const int number : before_.numbers())
    if (const std::string& id = before_.object(number)->id; find(id)) ids.push_back(id);
  for (const auto& [id, object] : changed_)
    if (object && before_.find(id) < 0) ids.push_back(id);
  return ids;
}

void ObjectEditor::set(const std::string& id, std::shared_ptr<const Object> object) {
  const auto [place, is_new] = changed_.try_emplace(id);
  log_.emplace_back(id, is_new ? std::nullopt : std::make_optional(place->second));
  place->second = std::move(object);
}

void ObjectEditor::undo() {
  for (; log_.size() > kept_; log_.pop_back()) {
    auto& [id, before] = log_.back();
    if (before)
      changed_[id] = *before;
    else
      changed_.erase(id);
  }
}

std::vector<ObjectChange> ObjectEditor::difference() const {
  std::vector<ObjectChange> changes;
  for (const auto& [id, changed_before] : log_) {
    if (changed_before) continue;
    const auto& now = changed_.at(id);
    const bool was_there = before_.find(id) >= 0;
    if (now && was_there) changes.emplace_back(ReplaceObject{*now});
    if (now && !was_there) changes.emplace_back(AddObject{*now});
    if (!now && was_there) changes.emplace_back(RemoveObject{id});
  }
  return changes;
}

}  // namespace proximity_server::scene
