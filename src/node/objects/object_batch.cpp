#include "node/objects/object_batch.h"

#include "proximity_server/scene/model/names.h"
#include "proximity_server/scene/object_files/object_file.h"

#include <algorithm>
#include <stdexcept>
#include <utility>
#include <variant>
#include <vector>

namespace proximity_server::node {
namespace {

using Operation = scene::ObjectEdit::Operation;

/// The nearest name to an unknown one is searched among no more objects than this: the search must not slow down a
/// stream of changes that all name unknown objects.
constexpr std::size_t kMaxSearchedNames = 1000;

/// Refuses text that is not UTF-8: it cannot be written into a file, and clients in Python cannot read it.
void requireText(const std::string& text, const std::string& field) {
  try {
    scene::requireUtf8(text);
  } catch (const std::invalid_argument& error) {
    refuseField(field, error.what());
  }
}

void requireNoPlane(const std::vector<scene::ObjectShape>& shapes) {
  const auto is_plane = [](const scene::ObjectShape& shape) {
    return std::holds_alternative<scene::HalfSpace>(shape.geometry);
  };
  if (std::any_of(shapes.begin(), shapes.end(), is_plane))
    refuseField("link", "an object with a plane cannot be attached");
}

void requireLink(const scene::RobotModel& robot, const std::string& link, const std::string& field) {
  if (robot.findLink(link) < 0)
    refuseField(field, "there is no link '" + link + "' (did you mean '" +
                           scene::nearestName(link, scene::namesOf(robot.links)) + "'?)");
}

bool makesObject(const scene::ObjectEdit& edit) {
  return edit.operation == Operation::Add || edit.operation == Operation::Replace;
}

scene::ObjectOptions objectOptions(const Robot& robot) {
  const scene::ModelOptions& model = robot.config().model;
  scene::ObjectOptions options;
  options.resolve = meshResolver(robot.config());
  options.meshes.tolerance = model.mesh_tolerance;
  options.meshes.cache = model.mesh_cache;
  options.meshes.time_budget = model.mesh_time_budget;
  options.meshes.stop = model.stop;
  return options;
}

/// Puts the name of the object in front of the error, unless that begins with it already.
ChangeError withObjectName(const std::string& id, const std::invalid_argument& error) {
  const std::string name = "object " + scene::quoted(id), text = error.what(), start = name + ": ";
  if (dynamic_cast<const ChangeError*>(&error) || text.compare(0, start.size(), start) != 0)
    return ChangeError::within(name, error);
  return ChangeError::within(name, std::invalid_argument(text.substr(start.size())));
}

}  // namespace

PreparedGeometry prepareGeometry(const Robot& robot, const ObjectChanges& message) {
  PreparedGeometry prepared;
  scene::ObjectOptions options = objectOptions(robot);
  for (const ObjectChange& change : message.changes) {
    if (change.meshes.empty() && change.mesh_files.empty()) continue;
    try {
      const scene::ObjectEdit edit = editOf(change);
      if (!makesObject(edit)) continue;
      options.padding = edit.padding;
      prepared.emplace(&change, scene::makeObject(edit.id, edit.shapes, scene::Fixed{}, options).geometry);
    } catch (const std::invalid_argument&) {
      break;  // ObjectBatch::apply() finds the same error, and then refuses the message
    }
  }
  return prepared;
}

ObjectBatch::ObjectBatch(const Robot& robot, const scene::Objects& before, const FindFrame& find_frame,
                         const PreparedGeometry& prepared)
    : robot_(robot),
      prepared_(prepared),
      frames_(robot, find_frame),
      options_(objectOptions(robot)),
      objects_(before, frames_, options_) {}

void ObjectBatch::apply(const ObjectChanges& message) {
  for (std::size_t i = 0; i < message.changes.size(); ++i) {
    try {
      apply(message.changes[i]);
    } catch (const std::invalid_argument& error) {
      throw ChangeError::within("changes[" + std::to_string(i) + "]", withObjectName(message.changes[i].id, error));
    }
  }
}

void ObjectBatch::apply(const ObjectChange& change) {
  scene::ObjectEdit edit = editOf(change);
  check(edit);
  if (edit.operation == Operation::Move)
    edit.shapes = movedShapes(change, scene::givenShapesOf(*objects_.find(edit.id)));
  if (const auto found = prepared_.find(&change); found != prepared_.end()) edit.geometry = found->second;
  objects_.apply(std::move(edit));
}

void ObjectBatch::add(const scene::ObjectEdit& object) {
  try {
    requireLength(object.place.link, "link");
    requireLength(object.place.frame, "frame");
    requireReach(object.place.pose);
    check(object);
    objects_.apply(object);
  } catch (const std::invalid_argument& error) {
    throw std::invalid_argument(object.source + ": " + withObjectName(object.id, error).what());
  }
}

void ObjectBatch::check(const scene::ObjectEdit& edit) const {
  if (edit.operation == Operation::Remove) {
    if (edit.id.empty()) refuseField("id", "it is empty");
  } else if (makesObject(edit)) {
    if (edit.operation == Operation::Add && objects_.find(edit.id))
      refuseField("id", "there is an object with this id already");
    requireUsableId(edit.id);
    checkPlace(edit, nullptr);
  } else {
    checkPlace(edit, &require(edit.id));
  }
}

void ObjectBatch::checkPlace(const scene::ObjectEdit& edit, const scene::Object* before) const {
  const auto* held = before ? std::get_if<scene::Attached>(&before->placement) : nullptr;
  const scene::ObjectPlace& place = edit.place;
  const bool appends = edit.operation == Operation::Append;
  if (edit.operation == Operation::Move && held)
    refuseField("operation", "link " + scene::quoted(held->link) + " holds it: DETACH it, or ATTACH it elsewhere");
  if (edit.operation == Operation::Detach && !held) refuseField("operation", "no link holds it");
  if (edit.operation == Operation::Attach && place.link.empty()) refuseField("link", "it is empty");
  if (!place.link.empty() || (appends && held)) {
    requireNoPlane(edit.shapes);
    if (before) requireNoPlane(scene::givenShapesOf(*before));
  } else if (!place.touch_links.empty()) {
    refuseField("touch_links", "no link holds the object");
  } else if (!appends) {
    requireText(frames_.named(place.frame), "frame");
  }
  if (!place.link.empty()) requireLink(robot_.robotModel(), place.link, "link");
  for (const std::string& link : place.touch_links) requireLink(robot_.robotModel(), link, "touch_links");
}

void ObjectBatch::requireUsableId(const std::string& id) const {
  if (id.empty()) refuseField("id", "it is empty");
  if (id == "*") refuseField("id", "it stands for all objects");
  requireLength(id, "id");
  if (robot_.robotModel().findLink(id) >= 0) refuseField("id", "a link has this name");
  requireText(id, "id");
}

const scene::Object& ObjectBatch::require(const std::string& id) const {
  if (const scene::Object* found = objects_.find(id)) return *found;
  const std::size_t count = static_cast<std::size_t>(objects_.before().size()) + objects_.changed().size();
  const std::string nearest = count > kMaxSearchedNames ? "" : scene::nearestName(id, objects_.ids());
  refuseField("id", "there is no object with this id" + (nearest.empty() ? "" : " (did you mean '" + nearest + "'?)"));
}

}  // namespace proximity_server::node
