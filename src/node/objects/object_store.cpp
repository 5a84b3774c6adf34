#include "node/objects/object_store.h"

#include "proximity_server/scene/model/names.h"

#include <algorithm>
#include <stdexcept>
#include <string>
#include <utility>
#include <variant>

namespace proximity_server::node {
namespace {

using Lock = std::lock_guard<std::mutex>;
using Rule = scene::AllowedPairs::Rule;

PairRule messageOf(const scene::WrittenRule& rule) {
  PairRule message;
  message.a = rule.a;
  message.b = rule.b;
  message.allowed = rule.rule == Rule::Allowed;
  return message;
}

const scene::Attached* holderOf(const scene::Object& object) { return std::get_if<scene::Attached>(&object.placement); }

/// The operation that adds an object at the next start of the node.
scene::ObjectEdit fileEntryOf(const ChangeFrames& frames, const scene::Object& object) {
  scene::ObjectEdit edit;
  edit.id = object.id;
  edit.padding = scene::paddingOf(object);
  edit.place.pose = scene::poseInCarrier(object);
  if (const auto* held = holderOf(object)) {
    edit.place.link = held->link;
    edit.place.touch_links = held->touch_links;
  } else {  // also if this is the reference frame: at the next start, another one may be set
    edit.place.frame = scene::carrierOf(object, frames);
  }
  edit.shapes = scene::givenShapesOf(object);
  return edit;
}

bool isTracked(const Robot& robot, const std::string& id) { return robot.config().findTracked(id) != nullptr; }

/// Returns whether a reload keeps an object. Those of tracked sources are taken away with the source, and if the
/// reference frame has changed.
/// Failure: throws std::invalid_argument for another object that is fixed in a reference frame which has changed, or has
///          the id of a new tracked source.
bool isKept(const scene::Object& object, const Robot& before, const Robot& now) {
  const bool is_same_reference = before.referenceFrame() == now.referenceFrame();
  if (isTracked(before, object.id)) return is_same_reference && isTracked(now, object.id);
  const std::string where = "object " + scene::quoted(object.id) + ": ";
  if (const TrackedSource* const source = now.config().findTracked(object.id))
    throw std::invalid_argument(where + "a " + source->kind() + " source has its id: remove it first");
  if (!is_same_reference && std::holds_alternative<scene::Fixed>(object.placement))
    throw std::invalid_argument(where + "it stands in the reference frame '" + before.referenceFrame() +
                                "', which would be '" + now.referenceFrame() + "': remove it first");
  return true;
}

ShapeInfo shapeInfo(const std::string& id, std::size_t index, const scene::ObjectShapeInfo& shape) {
  ShapeInfo info;
  info.shape.link = id;
  info.shape.kind = ShapeRef::OBJECT;
  info.shape.index = static_cast<std::uint32_t>(index + 1);
  info.description = shape.description;
  info.representation = static_cast<std::uint8_t>(shape.representation);
  info.deviation = shape.deviation;
  info.uncovered = shape.uncovered;
  info.volume_ratio = shape.volume_ratio;
  info.pieces = static_cast<std::uint32_t>(shape.pieces);
  info.vertices = static_cast<std::uint32_t>(shape.vertices);
  return info;
}

ObjectInfo objectInfo(const ChangeFrames& frames, const scene::Object& object) {
  ObjectInfo info;
  info.id = object.id;
  if (const auto* held = holderOf(object)) {
    info.link = held->link;
    info.touch_links = held->touch_links;
  }
  info.frame = scene::carrierOf(object, frames);
  info.pose = toMessage(scene::poseInCarrier(object));
  info.padding = scene::paddingOf(object);
  const std::vector<scene::ObjectShapeInfo>& shapes = scene::shapesOf(object);
  for (std::size_t i = 0; i < shapes.size(); ++i) info.shapes.push_back(shapeInfo(info.id, i, shapes[i]));
  info.warnings = scene::warningsOf(object);
  return info;
}

std::int64_t trianglesOf(const scene::Object* object) {
  std::int64_t count = 0;
  if (!object) return count;
  for (const scene::ObjectShape& shape : scene::givenShapesOf(*object)) {
    const auto* mesh = std::get_if<scene::TriangleMesh>(&shape.geometry);
    if (mesh) count += static_cast<std::int64_t>(mesh->triangles.size());
  }
  return count;
}

/// The changes in the order of the ids, so that the numbers that new objects get do not depend on the order in a
/// message.
std::vector<scene::ObjectChange> sortedDifference(const scene::ObjectEditor& edited) {
  struct Id {
    const std::string& operator()(const scene::RemoveObject& change) const { return change.id; }
    const std::string& operator()(const scene::AddObject& change) const { return change.object.id; }
    const std::string& operator()(const scene::ReplaceObject& change) const { return change.object.id; }
  };
  std::vector<scene::ObjectChange> changes = edited.difference();
  std::sort(changes.begin(), changes.end(),
            [](const auto& a, const auto& b) { return std::visit(Id(), a) < std::visit(Id(), b); });
  return changes;
}

std::vector<ReadChanges> readAll(const Robot& robot, const std::vector<const ObjectChanges*>& messages) {
  std::vector<ReadChanges> read;
  for (const ObjectChanges* message : messages) read.push_back(readChanges(robot, *message));
  return read;
}

void requireAtMost(std::int64_t limit, std::int64_t count, const std::string& what) {
  if (count > limit)
    throw std::invalid_argument("there would be " + std::to_string(count) + " " + what +
                                " of all objects together, more than " + std::to_string(limit));
}

/// Whether an object consists of these boxes, as it does if nothing moves that a sensor sees.
bool hasTheBoxes(const scene::Objects& objects, const std::string& id, const std::vector<scene::ObjectShape>& shapes) {
  const int number = objects.find(id);
  if (number < 0 || shapes.size() != 1) return false;
  const auto boxes = [](const std::vector<scene::ObjectShape>& of) {
    return std::get_if<scene::Boxes>(&of[0].geometry);
  };
  const scene::Boxes *const old = boxes(givenShapesOf(*objects.object(number))), *const now = boxes(shapes);
  const auto is_same = [](const Eigen::AlignedBox3d& a, const Eigen::AlignedBox3d& b) {
    return a.min() == b.min() && a.max() == b.max();
  };
  return old && now && std::equal(old->boxes.begin(), old->boxes.end(), now->boxes.begin(), now->boxes.end(), is_same);
}

}  // namespace

ObjectStore::ObjectStore(std::shared_ptr<const Robot> robot, std::uint64_t node_start, FindFrame find_frame,
                         std::function<void(const Robot&)> on_change, const ObjectLimits& limits,
                         const scene::ObjectFile& at_start)
    : node_start_(node_start),
      find_frame_(std::move(find_frame)),
      on_change_(std::move(on_change)),
      limits_(limits),
      robot_(std::move(robot)) {
  loadAtStart(at_start);
}

void ObjectStore::loadAtStart(const scene::ObjectFile& file) {
  if (!file.changes.empty()) {
    throw std::invalid_argument(file.changes.front().edit.source +
                                ": only the tool clearance makes changes at a row or time");
  }
  const RobotObjects before = robot_->objects().get();
  ChangeFrames frames(*robot_, find_frame_);
  const scene::ObjectOptions options = objectOptions(*robot_);
  scene::ObjectEditor objects(*before.all, frames, options);
  for (const scene::ObjectEdit& object : file.objects) add(object, objects);
  commit(objects, file.rules, before.revision);
}

std::uint64_t ObjectStore::apply(const ObjectChanges& changes, const Remarked& remarked) {
  return applyTogether(
      {&changes}, [](const std::exception&) { throw; }, remarked);
}

std::uint64_t ObjectStore::applyTogether(const std::vector<const ObjectChanges*>& messages, const Refused& refused,
                                         const Remarked& remarked) {
  const std::shared_ptr<const Robot> robot = currentRobot();
  std::vector<ReadChanges> read = readAll(*robot, messages);
  const Lock only_one(change_mutex_);
  if (robot != robot_) read = readAll(*robot_, messages);  // a reload may have changed how meshes are read
  applyLocked(messages, refused, remarked, std::move(read));
  return revision();
}

std::shared_ptr<const Robot> ObjectStore::currentRobot() const {
  const Lock lock(mutex_);
  return robot_;
}

void ObjectStore::applyLocked(const std::vector<const ObjectChanges*>& messages, const Refused& refused,
                              const Remarked& remarked, std::vector<ReadChanges> read) {
  const RobotObjects before = robot_->objects().get();
  ChangeFrames frames(*robot_, find_frame_);
  const scene::ObjectOptions options = objectOptions(*robot_);
  scene::ObjectEditor objects(*before.all, frames, options);
  Rules rules;
  for (ReadChanges& changes : read) {
    objects.keep();
    try {
      const std::string remark = node::apply(changes, objects);
      if (remarked && !remark.empty()) remarked(remark);
      if (changes.rules) rules = std::move(changes.rules);
    } catch (const std::exception& error) {
      objects.undo();
      refused(error);
    }
  }
  try {
    if (commit(objects, rules, before.revision + 1)) on_change_(*robot_);
  } catch (const std::exception& error) {
    // This is rare, because nearly everything is checked before. Applying each message alone finds the one that is
    // wrong.
    if (messages.size() == 1) return refused(error);
    for (const ObjectChanges* message : messages)
      applyLocked({message}, refused, remarked, readAll(*robot_, {message}));
  }
}

/// Gives the edited objects to the robot, with the rules if there are any. Returns false if nothing has changed.
/// Failure: throws std::invalid_argument if the objects exceed a limit.
bool ObjectStore::commit(const scene::ObjectEditor& edited, const Rules& rules, std::uint64_t revision, By by) {
  const scene::Objects& before = edited.before();
  const std::vector<scene::ObjectChange> changes = sortedDifference(edited);
  if (changes.empty() && !rules) return false;
  std::int64_t triangles = triangles_;
  for (const auto& [id, object] : edited.changed())
    triangles += trianglesOf(object.get()) - trianglesOf(before.object(before.find(id)));
  requireAtMost(limits_.triangles, triangles, "triangles");
  auto next = std::make_shared<scene::Objects>(before.changed(changes));
  if (rules) *next = withRules(*next, *rules);
  requireAtMost(limits_.objects, next->size(), "ids");
  requireAtMost(limits_.pieces, next->pieceCount(), "convex pieces");
  requireAtMost(limits_.frames, static_cast<std::int64_t>(next->frames().size()), "tf frames");
  const Lock lock(mutex_);
  robot_->objects().set({std::move(next), revision});
  if (rules) rules_ = *rules;
  if (by == By::Client) listed_ = revision;
  triangles_ = triangles;
  return true;
}

void ObjectStore::track(const std::shared_ptr<const Robot>& robot, const TrackedSource& source, SeenShapes seen,
                        const std::function<void()>& placed) {
  scene::ObjectOptions options = objectOptions(*robot);
  scene::ObjectEdit edit = removalOf(source.name);
  const bool is_there = seen.frame.empty() && hasTheBoxes(*robot->objects().get().all, source.name, seen.shapes);
  if (!seen.shapes.empty() && !is_there) {
    edit.operation = scene::ObjectEdit::Operation::Replace;
    edit.place.pose = scene::requireReach(seen.place);
    edit.place.frame = seen.frame;
    edit.geometry = scene::makeObject(source.name, std::move(seen.shapes), scene::Fixed{}, options).geometry;
  }
  const Lock only_one(change_mutex_);
  const TrackedSource* const now = robot_->config().findTracked(source.name);
  if (robot != robot_ || !now || !(*now == source)) return;
  if (is_there) return placed();
  const RobotObjects before = robot_->objects().get();
  ChangeFrames frames(*robot_, find_frame_);
  scene::ObjectEditor objects(*before.all, frames, options);
  objects.apply(std::move(edit));
  if (commit(objects, {}, before.revision + 1, By::TrackedSource)) on_change_(*robot_);
  placed();
}

void ObjectStore::follow(const std::shared_ptr<const Robot>& robot, const std::function<void()>& replace) {
  const Lock only_one(change_mutex_);
  const RobotObjects now = robot_->objects().get();
  std::vector<scene::ObjectChange> additions;
  for (const int number : now.all->numbers())
    if (const scene::Object& object = *now.all->object(number); isKept(object, *robot_, *robot))
      additions.emplace_back(scene::AddObject{object});
  scene::Objects next = withRules(*robot->objects().get().all, rules_).changed(additions);
  robot->objects().set({std::make_shared<const scene::Objects>(std::move(next)), now.revision});
  {
    const Lock lock(mutex_);
    robot_ = robot;
  }
  replace();
}

ObjectStore::CurrentObjects ObjectStore::current() const {
  const Lock lock(mutex_);
  return {robot_, robot_->objects().get(), rules_, listed_};
}

ObjectStore::CurrentObjects ObjectStore::recorded() const {
  CurrentObjects now = current();
  std::vector<scene::ObjectChange> removals;
  for (const TrackedSource& source : now.robot->config().tracked)
    if (source.sensing && now.objects.all->find(source.name) >= 0)
      removals.emplace_back(scene::RemoveObject{source.name});
  if (!removals.empty()) now.objects.all = std::make_shared<const scene::Objects>(now.objects.all->changed(removals));
  return now;
}

// The message of many objects is long. It is made without the lock, so that no change waits for it.
ObjectList ObjectStore::list(const CurrentObjects& now) const {
  ObjectList list;
  list.header.frame_id = now.robot->referenceFrame();
  list.node_start = node_start_;
  list.revision = now.listed;
  const ChangeFrames frames(*now.robot);
  for (const int number : now.objects.all->numbers())
    if (const scene::Object& object = *now.objects.all->object(number); !isTracked(*now.robot, object.id))
      list.objects.push_back(objectInfo(frames, object));
  for (const scene::WrittenRule& rule : now.rules) list.rules.push_back(messageOf(rule));
  return list;
}

ObjectStore::Snapshot ObjectStore::snapshot() const {
  const CurrentObjects now = current();
  scene::ObjectFile file = fileOf(now);
  const auto is_tracked = [&](const scene::ObjectEdit& object) { return isTracked(*now.robot, object.id); };
  file.objects.erase(std::remove_if(file.objects.begin(), file.objects.end(), is_tracked), file.objects.end());
  return {std::move(file), now.listed};
}

scene::ObjectFile ObjectStore::fileOf(const CurrentObjects& now) {
  scene::ObjectFile file;
  const ChangeFrames frames(*now.robot);
  for (const int number : now.objects.all->numbers())
    file.objects.push_back(fileEntryOf(frames, *now.objects.all->object(number)));
  file.rules = now.rules;
  return file;
}

std::uint64_t ObjectStore::revision() const { return current().listed; }

}  // namespace proximity_server::node
