#include "proximity_server/scene/objects/object_editor.h"

#include "proximity_server/scene/model/names.h"
#include "scene/objects/placed_object.h"

#include <stdexcept>
#include <utility>
#include <variant>

namespace proximity_server::scene {

using Eigen::Isometry3d;
using Operation = ObjectEdit::Operation;

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
  if (edit.operation == Operation::Add && find(edit.id)) refuseObject(edit.id, "there is one with this id already");
  Object object = is_whole ? Object{edit.id, std::move(edit.geometry), {}} : require(edit.id);
  const auto* held = std::get_if<Attached>(&object.placement);
  if (edit.operation == Operation::Move && held)
    refuseObject(edit.id, "it is attached to link " + quoted(held->link) + "; detach it, or attach it elsewhere");
  if (edit.operation == Operation::Detach && !held) refuseObject(edit.id, "it is not attached");
  if (edit.operation == Operation::Append)
    append(edit, object);
  else
    object.placement = placementFor(edit, object);
  if (!object.geometry || (!is_whole && !edit.shapes.empty())) {
    ObjectOptions options = options_;
    options.padding = is_whole ? edit.padding : paddingOf(object);
    object = makeObject(edit.id, std::move(edit.shapes), object.placement, options);
  }
  set(edit.id, std::make_shared<const Object>(std::move(object)));
}

void ObjectEditor::remove(const std::string& id) {
  if (id != "*") return set(id, nullptr);
  for (const std::string& each : ids()) set(each, nullptr);
}

/// Puts the shapes of the object before those of the edit, and transforms the latter into the object's frame.
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
  throw std::invalid_argument("there is no object " + unknownName(id, ids()));
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
