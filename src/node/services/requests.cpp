#include "node/services/requests.h"

#include "node/objects/object_needs.h"
#include "proximity_server/scene/model/names.h"

#include <algorithm>
#include <cmath>

namespace proximity_server::node {
namespace {

bool hasGeometry(const scene::RobotModel& robot, int collision) { return !robot.collisions[collision].pieces.empty(); }

/// A robot with the objects of the moment of a request.
struct Asked {
  const Robot& robot;
  RobotObjects objects;

  const scene::RobotModel& model() const { return robot.robotModel(); }
  const scene::Objects& all() const { return *objects.all; }
};

int linkWithGeometry(const scene::RobotModel& robot, int link) {
  if (robot.hasGeometry(link)) return link;
  throw RequestError(QueryStatus::NO_COLLISION_GEOMETRY,
                     "link '" + robot.links[link].name + "' has no collision geometry");
}

[[noreturn]] void refuseName(const Asked& asked, const std::string& name) {
  std::vector<std::string> known = scene::namesOf(asked.model().links);
  for (const int number : asked.all().numbers()) known.push_back(asked.all().object(number)->id);
  throw RequestError(QueryStatus::UNKNOWN_LINK, "there is no link or object '" + name + "': did you mean '" +
                                                    scene::nearestName(name, known) + "'?");
}

std::vector<scene::Collision> collisionsOf(const scene::RobotModel& robot, const scene::Link& link) {
  std::vector<scene::Collision> collisions;
  for (const int index : link.collisions) collisions.push_back(robot.collisions[index]);
  return collisions;
}

int shapeNamed(const scene::RobotModel& robot, const scene::Link& link, const std::string& name) {
  const std::vector<scene::Collision> collisions = collisionsOf(robot, link);
  for (const scene::Collision& collision : collisions) {
    if (collision.name == name) return collision.number;
  }
  refuse("link '" + link.name + "' has no <collision> '" + name + "': did you mean '" +
         scene::nearestName(name, scene::namesOf(collisions)) + "'?");
}

int shapeNumbered(const scene::Link& link, std::uint32_t number) {
  if (number <= link.collisions.size()) return static_cast<int>(number);
  refuse("link '" + link.name + "' has " + std::to_string(link.collisions.size()) +
         " <collision> elements, asked was number " + std::to_string(number));
}

scene::ShapeRef linkRefOf(const scene::RobotModel& robot, int index, const ShapeRef& ref) {
  linkWithGeometry(robot, index);
  const scene::Link& link = robot.links[index];
  if (ref.index == 0 && ref.name.empty()) return {index, 0};
  const int number = ref.index > 0 ? shapeNumbered(link, ref.index) : shapeNamed(robot, link, ref.name);
  if (!hasGeometry(robot, link.collisions[number - 1])) {
    throw RequestError(QueryStatus::NO_COLLISION_GEOMETRY,
                       "<collision> " + std::to_string(number) + " of link '" + ref.link + "' has no geometry");
  }
  return {index, number};
}

scene::ShapeRef shapeRefOf(const Asked& asked, const ShapeRef& ref) {
  const int link = asked.model().findLink(ref.link);
  if (link >= 0) return linkRefOf(asked.model(), link, ref);
  const int number = asked.all().find(ref.link);
  if (number < 0)
    asked.all().empty() ? static_cast<void>(linkNamed(asked.model(), ref.link)) : refuseName(asked, ref.link);
  if (ref.index == 0 && ref.name.empty()) return scene::ShapeRef::ofObject(number);
  refuse("object '" + ref.link + "' is asked as a whole only: index must be 0, and name empty");
}

bool isEmpty(const ShapeRef& ref) { return ref.link.empty() && ref.index == 0 && ref.name.empty(); }

bool isSame(const scene::ShapeRef& a, const scene::ShapeRef& b) {
  const bool is_part = a.isLink() && a.link() == b.link() && (a.collision() == 0 || b.collision() == 0);
  return a == b || is_part;
}

/// Two half-spaces always meet, so a scene has no distance of them.
bool areHalfSpaces(const scene::Objects& objects, const scene::ShapeRef& a, const scene::ShapeRef& b) {
  const auto is_half_space = [&](const scene::ShapeRef& ref) {
    return std::binary_search(objects.unbounded().begin(), objects.unbounded().end(), ref.object());
  };
  return is_half_space(a) && is_half_space(b);
}

scene::PairReason reasonOf(const Asked& asked, const scene::ShapeRef& a, const scene::ShapeRef& b) {
  if (a.isObject() || b.isObject()) return asked.all().reason(a, b);
  const scene::PairTable& table = asked.robot.sceneModel().pairs;
  const int row = table.find(a.link(), b.link());
  return row < 0 ? scene::PairReason::SameBody : table.pairs[row].reason;
}

scene::ShapeRefPair onePair(const Asked& asked, const ShapeRef& a, const ShapeRef& b, Filter filter) {
  const scene::ShapeRefPair pair{shapeRefOf(asked, a), shapeRefOf(asked, b)};
  const auto names = [&] { return "'" + a.link + "' and '" + b.link + "'"; };
  if (isSame(pair.a, pair.b)) refuse(names() + " are the same");
  if (areHalfSpaces(asked.all(), pair.a, pair.b)) refuse(names() + " have a half-space each, and these always meet");
  if (filter == Filter::Ignored) return pair;

  const scene::PairReason reason = reasonOf(asked, pair.a, pair.b);
  if (reason != scene::PairReason::Checked) {
    throw RequestError(QueryStatus::PAIR_EXCLUDED,
                       names() + " are not checked: " + toString(reason) + "; ignore_filter asks anyway");
  }
  return pair;
}

/// A scene that was borrowed, with the objects of a request.
template <class Lease>
Lease withObjects(Lease scene, const RobotObjects& objects) {
  if (scene->objects() != objects.all.get()) scene->use(objects.all);
  return scene;
}

bool isWithinBatch(const Robot& robot, std::size_t count) {
  return count <= static_cast<std::size_t>(robot.config().max_batch);
}

/// Throws RequestError OVER_BUDGET. `what` is a count with its noun: "12 entries".
[[noreturn]] void refuseBatch(const Robot& robot, const std::string& field, const std::string& what) {
  throw RequestError(QueryStatus::OVER_BUDGET,
                     field + ": " + what + ", max_batch is " + std::to_string(robot.config().max_batch));
}

/// Adds the pairs of `subject` with objects, in this order; never a pair of two half-spaces.
void addObjectPairs(const Asked& asked, const scene::ShapeRef& subject, Filter filter,
                    std::vector<scene::ShapeRefPair>& pairs) {
  for (const int number : asked.all().numbers()) {
    const scene::ShapeRef other = scene::ShapeRef::ofObject(number);
    if (isSame(subject, other) || areHalfSpaces(asked.all(), subject, other)) continue;
    if (filter == Filter::Ignored || reasonOf(asked, subject, other) == scene::PairReason::Checked)
      pairs.push_back({subject, other});
  }
}

/// Adds the checked pairs of two objects, each once.
void addPairsOfObjects(const Asked& asked, std::vector<scene::ShapeRefPair>& pairs) {
  for (const int number : asked.all().walkers()) {
    const scene::ShapeRef walker = scene::ShapeRef::ofObject(number);
    for (const int other : asked.all().numbers())
      if (asked.all().isCheckedBy(walker, other)) pairs.push_back({walker, scene::ShapeRef::ofObject(other)});
  }
}

/// Every pair of links, every pair of a link and an object, and the checked pairs of two objects.
RequestedPairs unfilteredPairs(const Asked& asked) {
  std::vector<scene::ShapeRefPair> pairs;
  for (const scene::LinkPair& pair : asked.robot.sceneModel().pairs.pairs)
    pairs.push_back({{pair.link_a}, {pair.link_b}});
  const std::size_t objects = asked.all().numbers().size();
  if (objects > 0 && !isWithinBatch(asked.robot, pairs.size() + objects * asked.model().links.size()))
    refuseBatch(asked.robot, "ignore_filter", "all pairs with " + std::to_string(objects) + " objects");
  for (std::size_t link = 0; link < asked.model().links.size(); ++link) {
    const int index = static_cast<int>(link);
    if (asked.model().hasGeometry(index)) addObjectPairs(asked, {index, 0}, Filter::Ignored, pairs);
  }
  addPairsOfObjects(asked, pairs);
  return {asked.robot, asked.objects, std::move(pairs)};
}

RequestedPairs everyPair(const Asked& asked, Filter filter) {
  if (filter == Filter::Applies) return {asked.robot, asked.objects};
  return unfilteredPairs(asked);
}

/// All pairs with the link `subject` or its <collision>, in which it comes first.
RequestedPairs pairsWithLink(const Asked& asked, const scene::ShapeRef& subject, Filter filter) {
  std::vector<scene::ShapeRefPair> pairs;
  for (const scene::LinkPair& pair : asked.robot.sceneModel().pairs.pairs) {
    if (filter == Filter::Applies && pair.reason != scene::PairReason::Checked) continue;
    if (pair.link_a == subject.link()) pairs.push_back({subject, {pair.link_b}});
    if (pair.link_b == subject.link()) pairs.push_back({subject, {pair.link_a}});
  }
  addObjectPairs(asked, subject, filter, pairs);
  return {asked.robot, asked.objects, std::move(pairs)};
}

RequestedPairs pairsWithObject(const Asked& asked, const scene::ShapeRef& subject, Filter filter) {
  std::vector<scene::ShapeRefPair> pairs;
  for (std::size_t link = 0; link < asked.model().links.size(); ++link) {
    const scene::ShapeRef other{static_cast<int>(link), 0};
    if (!asked.model().hasGeometry(other.link())) continue;
    if (filter == Filter::Ignored || reasonOf(asked, subject, other) == scene::PairReason::Checked)
      pairs.push_back({subject, other});
  }
  addObjectPairs(asked, subject, filter, pairs);
  return {asked.robot, asked.objects, std::move(pairs)};
}

RequestedPairs pairsWith(const Asked& asked, const ShapeRef& a, Filter filter) {
  const scene::ShapeRef subject = shapeRefOf(asked, a);
  return subject.isObject() ? pairsWithObject(asked, subject, filter) : pairsWithLink(asked, subject, filter);
}

/// Pairs of links alone if a group is named.
RequestedPairs groupOrEveryPair(const Asked& asked, const std::string& group, Filter filter) {
  if (group.empty()) return everyPair(asked, filter);
  if (filter == Filter::Ignored) {
    refuse("group and ignore_filter exclude each other");
  }
  try {
    return {asked.robot, asked.objects, asked.robot.pairsOfGroup(group)};
  } catch (const std::invalid_argument& error) {
    refuse(error.what());
  }
}

void requirePairs(const RequestedPairs& pairs) {
  if (pairs.size() == 0) refuse("the filter leaves no pair to check");
}

RequestedPairs pairsOf(const Asked& asked, const ShapeRef& a, const ShapeRef& b, Filter filter) {
  if (!isEmpty(a) && !isEmpty(b)) return {asked.robot, asked.objects, {onePair(asked, a, b, filter)}};
  if (!isEmpty(b)) refuse("b without a: name a, or neither of them");
  RequestedPairs pairs = isEmpty(a) ? everyPair(asked, filter) : pairsWith(asked, a, filter);
  requirePairs(pairs);
  return pairs;
}

/// Adds all pairs of `more`.
void append(const Asked& asked, const RequestedPairs& more, std::vector<scene::ShapeRefPair>& pairs) {
  if (more.list()) {
    pairs.insert(pairs.end(), more.list()->begin(), more.list()->end());
    return;
  }
  pairs.insert(pairs.end(), asked.robot.candidates().begin(), asked.robot.candidates().end());
  for (std::size_t link = 0; link < asked.model().links.size(); ++link)
    addObjectPairs(asked, {static_cast<int>(link), 0}, Filter::Applies, pairs);
  addPairsOfObjects(asked, pairs);
}

/// The pairs of the lists a and b. A single entry may stand for many pairs, so the limit is checked after each entry.
RequestedPairs listedPairs(const Asked& asked, const QueryPairsRequest& request) {
  const Robot& robot = asked.robot;
  if (!request.group.empty()) refuse("group goes with empty a and b only");
  if (!request.b.empty() && request.b.size() != request.a.size()) {
    refuse("a and b must have the same length, or b none");
  }
  const std::size_t entries = request.a.size();
  if (!isWithinBatch(robot, entries)) refuseBatch(robot, "a", std::to_string(entries) + " entries");
  const ShapeRef any;
  std::vector<scene::ShapeRefPair> pairs;
  for (std::size_t i = 0; i < entries; ++i) {
    const ShapeRef& b = request.b.empty() ? any : request.b[i];
    append(asked, pairsOf(asked, request.a[i], b, filterOf(request.ignore_filter)), pairs);
    if (isWithinBatch(robot, pairs.size())) continue;
    refuseBatch(robot, "a", std::to_string(pairs.size()) + " pairs in its first " + std::to_string(i + 1) + " entries");
  }
  return {robot, asked.objects, std::move(pairs)};
}

/// The largest number of pairs that the mode returns for one state, of `asked` pairs.
std::size_t maxReturned(const QueryPairsRequest& request, std::size_t asked) {
  switch (request.mode) {
    case QueryPairsRequest::MINIMUM:
    case QueryPairsRequest::FIRST:
      return 1;
    case QueryPairsRequest::K_CLOSEST:
      return std::min<std::size_t>(std::max<std::size_t>(request.k, 1), asked);
    default:
      return asked;
  }
}

}  // namespace

void refuse(const std::string& what) { throw RequestError(QueryStatus::INVALID_ARGUMENT, what); }

void require(const QueryStatus& status) {
  if (status.code != QueryStatus::OK) throw RequestError(status);
}

int linkNamed(const scene::RobotModel& robot, const std::string& name) {
  const int index = robot.findLink(name);
  if (index >= 0) return index;
  throw RequestError(QueryStatus::UNKNOWN_LINK, "there is no link '" + name + "': did you mean '" +
                                                    scene::nearestName(name, scene::namesOf(robot.links)) + "'?");
}

double finite(double value, const std::string& name) {
  if (!std::isfinite(value)) refuse(name + " is not finite");
  return value;
}

double notNegative(double value, const std::string& name) {
  if (finite(value, name) >= 0.0) return value;
  refuse(name + " must not be negative");
}

double positive(double value, const std::string& name) {
  if (finite(value, name) > 0.0) return value;
  refuse(name + " must be positive");
}

std::size_t RequestedPairs::size() const {
  if (own_) return own_->size();
  return robot_->candidates().size() + static_cast<std::size_t>(objects().pairCount());
}

std::vector<int> RequestedPairs::bodies() const {
  return own_ ? bodiesOf(*robot_, objects(), *own_) : bodiesOfCheckedPairs(*robot_, objects());
}

AskedFrames RequestedPairs::frames() const { return own_ ? framesOf(objects(), *own_) : framesOf(objects()); }

ScenePool::Lease RequestedPairs::borrowScene() const { return withObjects(robot_->borrowScene(), objects_); }

MovingScenePool::Lease RequestedPairs::borrowMovingScene() const {
  return withObjects(robot_->borrowMovingScene(), objects_);
}

RequestedPairs pairsOf(const Robot& robot, const ShapeRef& a, const ShapeRef& b, Filter filter) {
  return pairsOf(Asked{robot, robot.objects().get()}, a, b, filter);
}

RequestedPairs pairsOf(const Robot& robot, const QueryPairsRequest& request) {
  const Asked asked{robot, robot.objects().get()};
  const bool lists = !request.a.empty() || !request.b.empty();
  RequestedPairs pairs =
      lists ? listedPairs(asked, request) : groupOrEveryPair(asked, request.group, filterOf(request.ignore_filter));
  requirePairs(pairs);
  return pairs;
}

void requireAnswersWithinBatch(const Robot& robot, const QueryPairsRequest& request, std::size_t asked,
                               std::size_t states) {
  const std::size_t each = maxReturned(request, asked);
  if (isWithinBatch(robot, each * states)) return;
  if (states == 1) refuseBatch(robot, "a and b", std::to_string(each) + " returned pairs");
  refuseBatch(robot, "states",
              std::to_string(each * states) + " returned pairs (up to " + std::to_string(each) + " in each of " +
                  std::to_string(states) + " states)");
}

void requirePointsWithinBatch(const Robot& robot, std::size_t points) {
  if (!isWithinBatch(robot, points)) refuseBatch(robot, "trajectory", std::to_string(points) + " points");
}

}  // namespace proximity_server::node
