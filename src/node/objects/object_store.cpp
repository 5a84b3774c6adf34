#include "node/objects/object_store.h"

#include <stdexcept>
#include <string>
#include <utility>
#include <variant>

#include "proximity_server/scene/model/names.h"

namespace proximity_server::node {
namespace {

using Lock = std::lock_guard<std::mutex>;

/// `rules` for pairs with objects, beside the other rules of `before`.
scene::ObjectRules rulesFrom(const std::vector<PairRule>& rules, scene::ObjectRules before) {
  before.allowed = {};
  for (std::size_t i = 0; i < rules.size(); ++i) {
    const PairRule& rule = rules[i];
    const std::string place = "rules[" + std::to_string(i) + "]: ";
    if (rule.a.empty() || rule.b.empty()) throw std::invalid_argument(place + "a name is empty");
    try {
      scene::requireUtf8(rule.a);
      scene::requireUtf8(rule.b);
    } catch (const std::invalid_argument& error) {
      throw std::invalid_argument(place + error.what());
    }
    using Rule = scene::AllowedPairs::Rule;
    before.allowed.set(rule.a, rule.b, rule.allowed ? Rule::Allowed : Rule::Checked);
  }
  return before;
}

std::vector<PairRule> messagesOf(const std::vector<scene::WrittenRule>& rules) {
  std::vector<PairRule> messages(rules.size());
  for (std::size_t i = 0; i < rules.size(); ++i) {
    messages[i].a = rules[i].a;
    messages[i].b = rules[i].b;
    messages[i].allowed = rules[i].rule == scene::AllowedPairs::Rule::Allowed;
  }
  return messages;
}

scene::WrittenObject written(const Robot& robot, const StoredObject& stored) {
  scene::WrittenObject object;
  object.id = stored.object.id;
  object.padding = stored.padding;
  const Carried carried = carriedBy(robot, stored.object.placement);
  object.place.pose = carried.frame_T_object;
  if (const auto* held = std::get_if<scene::Attached>(&stored.object.placement)) {
    object.place.link = held->link;
    object.place.touch_links = held->touch_links;
  } else {
    object.place.frame = carried.frame;  // also the reference frame: the next start may have another one
  }
  for (const SourceShape& shape : *stored.shapes) object.shapes.push_back(shape.shape);
  return object;
}

/// Throws std::invalid_argument if an object stands in a reference frame that is another one now.
void requireSameReference(const StoredObjects& stored, const Robot& before, const Robot& now) {
  if (before.referenceFrame() == now.referenceFrame()) return;
  for (const auto& [id, object] : stored) {
    if (std::holds_alternative<scene::Fixed>(object->object.placement))
      throw std::invalid_argument("object " + scene::quoted(id) + ": it stands in the reference frame '" +
                                  before.referenceFrame() + "', which would be '" + now.referenceFrame() +
                                  "': remove it first");
  }
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

ObjectInfo objectInfo(const Robot& robot, const StoredObject& stored) {
  ObjectInfo info;
  info.id = stored.object.id;
  if (const auto* held = std::get_if<scene::Attached>(&stored.object.placement)) {
    info.link = held->link;
    info.touch_links = held->touch_links;
  }
  const Carried carried = carriedBy(robot, stored.object.placement);
  info.frame = carried.frame;
  info.pose = toMessage(carried.frame_T_object);
  info.padding = stored.padding;
  const std::vector<scene::ObjectShapeInfo>& shapes = scene::shapesOf(stored.object);
  for (std::size_t i = 0; i < shapes.size(); ++i) info.shapes.push_back(shapeInfo(info.id, i, shapes[i]));
  info.warnings = scene::warningsOf(stored.object);
  return info;
}

void add(const ObjectChanges& message, ObjectBatch& batch) {
  for (std::size_t i = 0; i < message.changes.size(); ++i) {
    try {
      batch.apply(message.changes[i]);
    } catch (const std::invalid_argument& error) {
      throw ChangeError::within("changes[" + std::to_string(i) + "]", error);
    }
  }
}

std::int64_t trianglesOf(const StoredObject* stored) {
  std::int64_t count = 0;
  if (!stored) return count;
  for (const SourceShape& shape : *stored->shapes) {
    const auto* mesh = std::get_if<scene::TriangleMesh>(&shape.shape.geometry);
    if (mesh) count += static_cast<std::int64_t>(mesh->triangles.size());
  }
  return count;
}

void requireAtMost(std::int64_t limit, std::int64_t count, const std::string& what) {
  if (count > limit)
    throw std::invalid_argument("there would be " + std::to_string(count) + " " + what +
                                " of all objects together, more than " + std::to_string(limit));
}

}  // namespace

ObjectStore::ObjectStore(std::shared_ptr<const Robot> robot, std::uint64_t node_start, FindFrame find_frame,
                         std::function<void(const Robot&)> in_use, const ObjectLimits& limits,
                         const scene::ObjectFile& at_start)
    : node_start_(node_start),
      find_frame_(std::move(find_frame)),
      in_use_(std::move(in_use)),
      limits_(limits),
      robot_(std::move(robot)) {
  begin(at_start);
}

void ObjectStore::begin(const scene::ObjectFile& file) {
  if (!file.changes.empty()) {
    throw std::invalid_argument(file.changes.front().object.source +
                                ": only the tool clearance makes changes at a row or time");
  }
  const MadeObjects none;
  ObjectBatch batch(*robot_, stored_, find_frame_, none);
  for (const scene::WrittenObject& object : file.objects) batch.add(object);
  const std::vector<PairRule> rules = messagesOf(file.rules);
  auto first = std::make_shared<const scene::Objects>(objectsAfter(batch, &rules));
  triangles_ = trianglesAfter(batch);
  stored_ = batch.touched();
  rules_ = rules;
  robot_->objects().set({std::move(first), revision_});
}

std::uint64_t ObjectStore::apply(const ObjectChanges& changes) {
  return applyTogether({&changes}, [](const std::exception&) { throw; });
}

std::uint64_t ObjectStore::applyTogether(const std::vector<const ObjectChanges*>& messages, const Refused& refused) {
  const std::shared_ptr<const Robot> robot = robotNow();
  MadeObjects made;
  for (const ObjectChanges* message : messages) made.merge(madeAhead(*robot, *message));
  const Lock only_one(changing_);
  if (robot != robot_) made.clear();  // a reload may have changed how meshes are read
  applyLocked(messages, refused, made);
  return revision_;
}

std::shared_ptr<const Robot> ObjectStore::robotNow() const {
  const Lock lock(mutex_);
  return robot_;
}

void ObjectStore::applyLocked(const std::vector<const ObjectChanges*>& messages, const Refused& refused,
                              const MadeObjects& made) {
  ObjectBatch batch(*robot_, stored_, find_frame_, made);
  const std::vector<PairRule>* rules = nullptr;
  for (const ObjectChanges* message : messages) {
    batch.keep();
    try {
      add(*message, batch);
      if (message->set_rules) {
        rulesFrom(message->rules, {});  // throws if one is wrong
        rules = &message->rules;
      }
    } catch (const std::exception& error) {
      batch.undo();
      refused(error);
    }
  }
  try {
    commit(batch, rules);
  } catch (const std::exception& error) {
    // Rare, because nearly all is checked before: the one to blame is found by trying each.
    if (messages.size() == 1) return refused(error);
    for (const ObjectChanges* message : messages) applyLocked({message}, refused, made);
  }
}

/// Makes the objects of a batch those of the robot.
void ObjectStore::commit(const ObjectBatch& batch, const std::vector<PairRule>* rules) {
  if (batch.difference().empty() && !rules) return;
  auto next = std::make_shared<const scene::Objects>(objectsAfter(batch, rules));
  const std::int64_t triangles = trianglesAfter(batch);
  {
    const Lock lock(mutex_);
    for (const auto& [id, object] : batch.touched()) {
      if (object)
        stored_[id] = object;
      else
        stored_.erase(id);
    }
    if (rules) rules_ = *rules;
    triangles_ = triangles;
    ++revision_;
  }
  robot_->objects().set({std::move(next), revision_});
  in_use_(*robot_);
}

/// The objects and, if there are any, the rules of a batch, within the limits.
scene::Objects ObjectStore::objectsAfter(const ObjectBatch& batch, const std::vector<PairRule>* rules) const {
  requireAtMost(limits_.triangles, trianglesAfter(batch), "triangles");
  scene::Objects next = robot_->objects().get().all->changed(batch.difference());
  if (rules) next = next.withRules(rulesFrom(*rules, next.rules()));
  requireAtMost(limits_.objects, next.size(), "ids");
  requireAtMost(limits_.pieces, next.pieceCount(), "convex pieces");
  requireAtMost(limits_.frames, static_cast<std::int64_t>(next.frames().size()), "tf frames");
  return next;
}

std::int64_t ObjectStore::trianglesAfter(const ObjectBatch& batch) const {
  std::int64_t count = triangles_;
  for (const auto& [id, object] : batch.touched()) {
    const auto before = stored_.find(id);
    count += trianglesOf(object.get()) - (before == stored_.end() ? 0 : trianglesOf(before->second.get()));
  }
  return count;
}

void ObjectStore::follow(const std::shared_ptr<const Robot>& robot, const std::function<void()>& replace) {
  const Lock only_one(changing_);
  requireSameReference(stored_, *robot_, *robot);
  const std::shared_ptr<const scene::Objects> none = robot->objects().get().all;
  std::vector<scene::ObjectChange> additions;
  for (const auto& [id, object] : stored_) additions.emplace_back(scene::AddObject{object->object});
  scene::Objects next = none->withRules(rulesFrom(rules_, none->rules())).changed(additions);
  robot->objects().set({std::make_shared<const scene::Objects>(std::move(next)), revision_});
  {
    const Lock lock(mutex_);
    robot_ = robot;
  }
  replace();
}

ObjectStore::Present ObjectStore::present() const {
  const Lock lock(mutex_);
  return {robot_, stored_, rules_, revision_};
}

// Many objects make a long message: it is written without the lock, so that no change waits for it.
ObjectList ObjectStore::list(const Present& now) const {
  ObjectList list;
  list.header.frame_id = now.robot->referenceFrame();
  list.node_start = node_start_;
  list.revision = now.revision;
  for (const auto& [id, object] : now.objects) list.objects.push_back(objectInfo(*now.robot, *object));
  list.rules = now.rules;
  return list;
}

ObjectStore::Snapshot ObjectStore::snapshot() const {
  const Present now = present();
  Snapshot snapshot{{}, now.revision};
  for (const auto& [id, object] : now.objects) snapshot.file.objects.push_back(written(*now.robot, *object));
  for (const PairRule& rule : now.rules) {
    using Rule = scene::AllowedPairs::Rule;
    snapshot.file.rules.push_back({rule.a, rule.b, rule.allowed ? Rule::Allowed : Rule::Checked});
  }
  return snapshot;
}

std::uint64_t ObjectStore::revision() const {
  const Lock lock(mutex_);
  return revision_;
}

}  // namespace proximity_server::node
