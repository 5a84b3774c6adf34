#include "proximity_server/scene/objects/objects.h"

#include "proximity_server/narrowphase/assertion.h"
#include "proximity_server/scene/model/names.h"
#include "scene/mesh/input_limits.h"
#include "scene/model/body_pose.h"
#include "scene/objects/placed_object.h"
#include "scene/scene_model/given_model.h"

#include <algorithm>
#include <set>
#include <stdexcept>
#include <utility>

namespace proximity_server::scene {
namespace {

using Eigen::Isometry3d;
using Kind = PlacedObject::Kind;

Isometry3d required(const Isometry3d& pose, const std::string& id) {
  const auto usable = usablePose(pose);
  if (!usable) refuseObject(id, "its pose is not finite, or no rotation");
  return *usable;
}

/// Transforms an object into the frame of its body, for each kind of placement.
class Placing {
 public:
  Placing(const RobotModel& robot, const Object& object) : robot_(robot), object_(object) {}

  PlacedObject operator()(const Fixed& fixed) const {
    PlacedObject placed{object_, Kind::Fixed, object_.geometry};
    placed.world_T_object = required(fixed.world_T_object, object_.id);
    if (!placed.isUnbounded()) {
      placed.box = boxAround(placed.geometry->root().bounds, placed.world_T_object.linear(),
                             placed.world_T_object.translation());
    }
    return placed;
  }

  PlacedObject operator()(const Moving& moving) const {
    if (moving.frame.empty()) refuseObject(object_.id, "the name of its frame is empty");
    PlacedObject placed{object_, Kind::Moving, in(moving.frame_T_object)};
    placed.frame = moving.frame;
    return placed;
  }

  PlacedObject operator()(const Attached& attached) const {
    const Link& link = robot_.links[requireLink(robot_, attached.link, "link", object_.id)];
    if (!object_.geometry->halfSpaces().empty()) refuseObject(object_.id, "a half-space cannot be attached");
    PlacedObject placed{object_, Kind::Attached, in(link.body_T_link * required(attached.link_T_object, object_.id))};
    placed.body = link.body;
    for (const std::string& name : attached.touch_links)
      placed.touch_links.push_back(requireLink(robot_, name, "touch_links", object_.id));
    std::sort(placed.touch_links.begin(), placed.touch_links.end());
    return placed;
  }

 private:
  std::shared_ptr<const ObjectGeometry> in(const Isometry3d& frame_T_object) const {
    auto geometry = ObjectGeometry::in(required(frame_T_object, object_.id), object_.geometry);
    if (!(geometry->root().bounds.reach <= kFarthest))
      refuseObject(object_.id, std::string("it is ") + kTooFar + " from its frame");
    return geometry;
  }

  const RobotModel& robot_;
  const Object& object_;
};

void insertSorted(int number, std::vector<int>& numbers) {
  numbers.insert(std::lower_bound(numbers.begin(), numbers.end(), number), number);
}

void eraseSorted(int number, std::vector<int>& numbers) {
  const auto found = std::lower_bound(numbers.begin(), numbers.end(), number);
  if (found != numbers.end() && *found == number) numbers.erase(found);
}

}  // namespace

void refuseObject(const std::string& id, const std::string& reason) {
  throw std::invalid_argument("object " + quoted(id) + ": " + reason);
}

void requireUsableId(const RobotModel& robot, const std::string& id) {
  if (id.empty()) refuseObject(id, "id: it is empty");
  if (id == "*") refuseObject(id, "id: it stands for all objects");
  if (id.find_first_not_of(" \t\r\n") == std::string::npos) refuseObject(id, "id: it is blank");
  if (id.find_first_of("\r\n") != std::string::npos) refuseObject(id, "id: it has a line break");
  if (robot.findLink(id) >= 0) refuseObject(id, "id: a link has this name");
}

int requireLink(const RobotModel& robot, const std::string& link, const std::string& field, const std::string& id) {
  const int found = robot.findLink(link);
  if (found < 0) refuseObject(id, field + ": there is no link " + unknownName(link, namesOf(robot.links)));
  return found;
}

Objects::Objects(std::shared_ptr<const SceneModel> model)
    : model_(std::move(model)),
      rules_(std::make_shared<const ObjectRules>()),
      fixed_(std::make_shared<FixedObjects>()) {
  given(model_);
}

Objects Objects::changed(const std::vector<ObjectChange>& changes) const {
  Objects next = *this;
  next.fixed_ = std::make_shared<FixedObjects>(*fixed_);
  for (const ObjectChange& change : changes) std::visit([&](const auto& of_kind) { next.apply(of_kind); }, change);
  next.findFrames();
  next.fixed_->tidy(next.slots_);
  return next;
}

Objects Objects::withRules(ObjectRules rules) const {
  Objects next = *this;
  next.rules_ = std::make_shared<const ObjectRules>(std::move(rules));
  next.searchers_.clear();
  for (int number = 0; number < next.numberLimit(); ++number)
    if (next.placed(number) && next.isSearcher(number)) next.searchers_.push_back(number);
  next.pair_count_ = 0;
  next.forEachCheckedPair([&](const ShapeRef&, const ShapeRef&) { ++next.pair_count_; });
  return next;
}

// --- changes

void Objects::apply(const AddObject& change) {
  const std::string& id = change.object.id;
  requireUsableId(model_->robot, id);
  const auto place = std::lower_bound(by_id_.begin(), by_id_.end(), id, [&](int number, const std::string& wanted) {
    return placed(number)->object.id < wanted;
  });
  if (place != by_id_.end() && placed(*place)->object.id == id) refuseObject(id, "there is one with this id already");
  int number = numberLimit();
  if (free_.empty()) {
    slots_.emplace_back();
  } else {
    number = free_.back();
    free_.pop_back();
  }
  by_id_.insert(place, number);
  insert(number, change.object);
}

void Objects::apply(const ReplaceObject& change) {
  const int number = require(change.object.id);
  removeFromLists(number);
  insert(number, change.object);
}

void Objects::apply(const RemoveObject& change) {
  const int number = require(change.id);
  removeFromLists(number);
  by_id_.erase(std::find(by_id_.begin(), by_id_.end(), number));
  slots_[number] = nullptr;
  free_.push_back(number);
}

int Objects::require(const std::string& id) const {
  const int number = find(id);
  if (number >= 0) return number;
  std::vector<std::string> known;
  for (const int other : by_id_) known.push_back(placed(other)->object.id);
  throw std::invalid_argument("there is no object " + unknownName(id, known));
}

/// Puts an object into the slot of its number, and adds it to the lists.
void Objects::insert(int number, const Object& object) {
  if (!object.geometry) refuseObject(object.id, "it has no geometry");
  auto placed = std::make_shared<PlacedObject>(std::visit(Placing(model_->robot, object), object.placement));
  placed->serial = next_serial_++;
  slots_[number] = std::move(placed);
  addToLists(number);
}

void Objects::addToLists(int number) {
  PROXIMITY_ASSERT(placed(number), "No object has this number: insert() puts it into its slot first.");
  const PlacedObject& object = *placed(number);
  if (isSearcher(number)) insertSorted(number, searchers_);
  if (object.kind == Kind::Moving) insertSorted(number, moving_);
  if (object.isUnbounded())
    insertSorted(number, unbounded_);
  else if (object.kind == Kind::Fixed)
    fixed_->add(number);
  pair_count_ += pairsOf(number);
  piece_count_ += static_cast<std::int64_t>(object.geometry->pieces().size());
}

/// Removes an object from the lists.
void Objects::removeFromLists(int number) {
  PROXIMITY_ASSERT(placed(number), "No object has this number: it was removed before.");
  const PlacedObject& object = *placed(number);
  pair_count_ -= pairsOf(number);
  piece_count_ -= static_cast<std::int64_t>(object.geometry->pieces().size());
  eraseSorted(number, searchers_);
  eraseSorted(number, moving_);
  eraseSorted(number, unbounded_);
  if (object.kind == Kind::Fixed && !object.isUnbounded()) fixed_->remove(number);
}

void Objects::findFrames() {
  std::set<std::string> frames;
  for (const int number : moving_) frames.insert(placed(number)->frame);
  frames_.assign(frames.begin(), frames.end());
  frame_of_.assign(slots_.size(), -1);
  for (const int number : moving_) {
    const auto place = std::lower_bound(frames_.begin(), frames_.end(), placed(number)->frame);
    frame_of_[number] = static_cast<int>(place - frames_.begin());
  }
}

// --- look-up

int Objects::find(const std::string& id) const {
  const auto found = std::lower_bound(by_id_.begin(), by_id_.end(), id, [&](int number, const std::string& wanted) {
    return placed(number)->object.id < wanted;
  });
  return found != by_id_.end() && placed(*found)->object.id == id ? *found : -1;
}

const PlacedObject* Objects::placed(int number) const {
  return number >= 0 && number < numberLimit() ? slots_[number].get() : nullptr;
}

const Object* Objects::object(int number) const {
  const PlacedObject* found = placed(number);
  return found ? &found->object : nullptr;
}

// --- pairs

bool Objects::isSearcher(int number) const {
  const Kind kind = placed(number)->kind;
  return kind == Kind::Attached || (kind == Kind::Moving && rules_->free_objects == ObjectRules::FreeObjects::Checked);
}

/// The number of checked pairs with an object. In a pair of two objects, one is a searcher.
std::int64_t Objects::pairsOf(int number) const {
  std::int64_t count = 0;
  for (int link = 0; link < static_cast<int>(model_->robot.links.size()); ++link)
    count += linkReason(link, number) == PairReason::Checked;
  for (const int other : isSearcher(number) ? by_id_ : searchers_)
    count += objectReason(number, other) == PairReason::Checked;
  return count;
}

namespace {

const PlacedObject& required(const PlacedObject* object, int number) {
  if (!object) throw std::invalid_argument("there is no object " + std::to_string(number));
  return *object;
}

}  // namespace

PairReason Objects::reason(const ShapeRef& a, const ShapeRef& b) const {
  if (a.isObject() && b.isObject()) return objectReason(a.object(), b.object());
  if (a.isObject()) return linkReason(b.link(), a.object());
  if (b.isObject()) return linkReason(a.link(), b.object());
  throw std::invalid_argument("neither of the two is an object");
}

bool Objects::isCheckedBy(const ShapeRef& searcher, int object) const {
  const bool other_looks = searcher.isObject() && object < searcher.object() &&
                           std::binary_search(searchers_.begin(), searchers_.end(), object);
  return !other_looks && isChecked(searcher, ShapeRef::ofObject(object));
}

PairReason Objects::linkReason(int link, int number) const {
  const RobotModel& robot = model_->robot;
  if (link < 0 || link >= static_cast<int>(robot.links.size()))
    throw std::invalid_argument("there is no link " + std::to_string(link));
  const PlacedObject& object = required(placed(number), number);
  const int body = robot.links[link].body;
  if (object.kind == Kind::Attached && object.body == body) return PairReason::SameBody;
  if (!robot.hasGeometry(link)) return PairReason::NoGeometry;
  const bool link_is_static = body == 0 && rules_->base == ObjectRules::Base::StandsStill;
  if (link_is_static && object.kind == Kind::Fixed) return PairReason::BothStatic;
  if (std::binary_search(object.touch_links.begin(), object.touch_links.end(), link)) return PairReason::TouchLink;
  const auto rule = rules_->allowed.of(robot.links[link].name, object.object.id);
  return rule == AllowedPairs::Rule::Allowed ? PairReason::Allowed : PairReason::Checked;
}

PairReason Objects::objectReason(int number_a, int number_b) const {
  const PlacedObject &a = required(placed(number_a), number_a), &b = required(placed(number_b), number_b);
  const auto isStatic = [&](const PlacedObject& object) {
    const bool on_base = object.kind == Kind::Attached && object.body == 0;
    return object.kind == Kind::Fixed || (on_base && rules_->base == ObjectRules::Base::StandsStill);
  };
  const auto both = [&](Kind kind) { return a.kind == kind && b.kind == kind; };
  const bool same_carrier = (both(Kind::Attached) && a.body == b.body) || (both(Kind::Moving) && a.frame == b.frame);
  if (number_a == number_b || same_carrier) return PairReason::SameBody;
  if (isStatic(a) && isStatic(b)) return PairReason::BothStatic;
  if (rules_->allowed.of(a.object.id, b.object.id) == AllowedPairs::Rule::Allowed) return PairReason::Allowed;
  const bool attached = a.kind == Kind::Attached || b.kind == Kind::Attached;
  if (!attached && rules_->free_objects == ObjectRules::FreeObjects::NotChecked) return PairReason::FreeObjects;
  return a.isUnbounded() && b.isUnbounded() ? PairReason::BothHalfSpaces : PairReason::Checked;
}

const std::string& nameOf(const ShapeRef& ref, const RobotModel& robot, const Objects* objects) {
  static const std::string none;
  if (ref.isLink()) return robot.links[ref.link()].name;
  const Object* object = objects ? objects->object(ref.object()) : nullptr;
  return object ? object->id : none;
}

}  // namespace proximity_server::scene
