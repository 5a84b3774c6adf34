#include "node/services/requests.h"

#include "node/answers/conversions.h"
#include "node/objects/object_needs.h"
#include "proximity_server/scene/model/names.h"

#include <algorithm>
#include <cmath>

namespace proximity_server::node {
namespace {

bool hasGeometry(const scene::RobotModel& robot, int collision) { return !robot.collisions[collision].pieces.empty(); }

/// The robot and the objects that a request is about; the objects are those at its beginning.
struct RequestContext {
  const Robot& robot;
  RobotObjects objects;

  const scene::RobotModel& model() const { return robot.robotModel(); }
  const scene::Objects& sceneObjects() const { return *objects.all; }
};

int linkWithGeometry(const scene::RobotModel& robot, int link) {
  if (robot.hasGeometry(link)) return link;
  throw RequestError(QueryStatus::NO_COLLISION_GEOMETRY,
                     "link '" + robot.links[link].name + "' has no collision geometry");
}

[[noreturn]] void refuseName(const RequestContext& context, const std::string& name) {
  std::vector<std::string> known = scene::namesOf(context.model().links);
  for (const int number : context.sceneObjects().numbers()) known.push_back(context.sceneObjects().object(number)->id);
  throw RequestError(QueryStatus::UNKNOWN_LINK,
                     "there is no link or object '" + name + "'" + scene::didYouMean(name, known));
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
  refuse("link '" + link.name + "' has no <collision> '" + name + "'" +
         scene::didYouMean(name, scene::namesOf(collisions)));
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

/// An object is asked as a whole, also if an answer tells which of its shapes it was.
scene::ShapeRef objectRefOf(const RequestContext& context, int number, const ShapeRef& ref) {
  const std::size_t shapes = scene::shapesOf(*context.sceneObjects().object(number)).size();
  if (ref.index > shapes)
    refuse("object '" + ref.link + "' has shapes up to number " + std::to_string(shapes) + ", asked was number " +
           std::to_string(ref.index));
  return scene::ShapeRef::ofObject(number);
}

scene::ShapeRef namedRefOf(const RequestContext& context, const ShapeRef& ref) {
  const int link = context.model().findLink(ref.link);
  if (link >= 0) return linkRefOf(context.model(), link, ref);
  const int number = context.sceneObjects().find(ref.link);
  if (number < 0)
    context.sceneObjects().empty() ? static_cast<void>(linkNamed(context.model(), ref.link))
                                   : refuseName(context, ref.link);
  return objectRefOf(context, number, ref);
}

/// The shape that `ref` names. A robot, name or kind that is given must agree with it; "" and LINK count as not given.
scene::ShapeRef shapeRefOf(const RequestContext& context, const ShapeRef& ref) {
  const scene::ShapeRef found = namedRefOf(context, ref);
  ShapeRef answer;
  assign(answer, {context.model(), &context.sceneObjects()}, found);
  const auto require = [&](const char* field, const std::string& given, const std::string& known) {
    if (!given.empty() && given != known)
      refuse(std::string(field) + " is '" + given + "', but that of '" + ref.link + "' is '" + known + "'");
  };
  require("name", ref.name, answer.name);
  require("robot", ref.robot, answer.robot);
  if (ref.kind != ShapeRef::LINK && ref.kind != answer.kind)
    refuse("kind is " + std::to_string(ref.kind) + ", but '" + ref.link + "' is " +
           (found.isLink() ? "a link: 0" : "an object: 1"));
  return found;
}

bool isEmpty(const ShapeRef& ref) {
  return ref.link.empty() && ref.index == 0 && ref.name.empty() && ref.robot.empty() && ref.kind == ShapeRef::LINK;
}

bool overlap(const scene::ShapeRef& a, const scene::ShapeRef& b) {
  const bool is_part = a.isLink() && a.link() == b.link() && (a.collision() == 0 || b.collision() == 0);
  return a == b || is_part;
}

/// Two half-spaces have no distance, because they always intersect each other.
bool areHalfSpaces(const scene::Objects& objects, const scene::ShapeRef& a, const scene::ShapeRef& b) {
  const auto is_half_space = [&](const scene::ShapeRef& ref) {
    return std::binary_search(objects.unbounded().begin(), objects.unbounded().end(), ref.object());
  };
  return is_half_space(a) && is_half_space(b);
}

scene::PairReason reasonOf(const RequestContext& context, const scene::ShapeRef& a, const scene::ShapeRef& b) {
  if (a.isObject() || b.isObject()) return context.sceneObjects().reason(a, b);
  const scene::PairTable& table = context.robot.sceneModel().pairs;
  const int row = table.find(a.link(), b.link());
  return row < 0 ? scene::PairReason::SameBody : table.pairs[row].reason;
}

scene::ShapeRefPair onePair(const RequestContext& context, const ShapeRef& a, const ShapeRef& b, Filter filter) {
  const scene::ShapeRefPair pair{shapeRefOf(context, a), shapeRefOf(context, b)};
  const auto names = [&] { return "'" + a.link + "' and '" + b.link + "'"; };
  if (overlap(pair.a, pair.b)) refuse(names() + " are the same");
  if (areHalfSpaces(context.sceneObjects(), pair.a, pair.b))
    refuse(names() + " have a half-space each, and these always meet");
  if (filter == Filter::Ignored) return pair;

  const scene::PairReason reason = reasonOf(context, pair.a, pair.b);
  if (reason != scene::PairReason::Checked) {
    throw RequestError(QueryStatus::PAIR_EXCLUDED,
                       names() + " are not checked: " + toString(reason) + "; ignore_filter asks anyway");
  }
  return pair;
}

bool isWithinBatch(const Robot& robot, std::size_t count) {
  return count <= static_cast<std::size_t>(robot.config().max_batch);
}

/// Throws RequestError OVER_BUDGET. `what` is a count with its noun: "12 entries".
[[noreturn]] void refuseBatch(const Robot& robot, const std::string& field, const std::string& what) {
  throw RequestError(QueryStatus::OVER_BUDGET,
                     field + ": " + what + ", max_batch is " + std::to_string(robot.config().max_batch));
}

/// Adds the pairs of `subject` and an object; `subject` is the first of each pair. Pairs of two half-spaces are not
/// added.
void addObjectPairs(const RequestContext& context, const scene::ShapeRef& subject, Filter filter,
                    std::vector<scene::ShapeRefPair>& pairs) {
  for (const int number : context.sceneObjects().numbers()) {
    const scene::ShapeRef other = scene::ShapeRef::ofObject(number);
    if (overlap(subject, other) || areHalfSpaces(context.sceneObjects(), subject, other)) continue;
    if (filter == Filter::Ignored || reasonOf(context, subject, other) == scene::PairReason::Checked)
      pairs.push_back({subject, other});
  }
}

/// Adds the checked pairs of two objects, each once.
void addPairsOfObjects(const RequestContext& context, std::vector<scene::ShapeRefPair>& pairs) {
  for (const int number : context.sceneObjects().searchers()) {
    const scene::ShapeRef searcher = scene::ShapeRef::ofObject(number);
    for (const int other : context.sceneObjects().numbers())
      if (context.sceneObjects().isCheckedBy(searcher, other))
        pairs.push_back({searcher, scene::ShapeRef::ofObject(other)});
  }
}

/// Returns every pair of links, every pair of a link and an object, and the checked pairs of two objects.
RequestedPairs unfilteredPairs(const RequestContext& context) {
  std::vector<scene::ShapeRefPair> pairs;
  for (const scene::LinkPair& pair : context.robot.sceneModel().pairs.pairs)
    pairs.push_back({{pair.link_a}, {pair.link_b}});
  const std::size_t objects = context.sceneObjects().numbers().size();
  if (objects > 0 && !isWithinBatch(context.robot, pairs.size() + objects * context.model().links.size()))
    refuseBatch(context.robot, "ignore_filter", "all pairs with " + std::to_string(objects) + " objects");
  for (std::size_t link = 0; link < context.model().links.size(); ++link) {
    const int index = static_cast<int>(link);
    if (context.model().hasGeometry(index)) addObjectPairs(context, {index, 0}, Filter::Ignored, pairs);
  }
  addPairsOfObjects(context, pairs);
  return {context.robot, context.objects, std::move(pairs)};
}

RequestedPairs everyPair(const RequestContext& context, Filter filter) {
  if (filter == Filter::Applies) return {context.robot, context.objects};
  return unfilteredPairs(context);
}

/// Returns all pairs with `subject`, a link or one of its <collision> elements, as the first of the two.
RequestedPairs pairsWithLink(const RequestContext& context, const scene::ShapeRef& subject, Filter filter) {
  std::vector<scene::ShapeRefPair> pairs;
  for (const scene::LinkPair& pair : context.robot.sceneModel().pairs.pairs) {
    if (filter == Filter::Applies && pair.reason != scene::PairReason::Checked) continue;
    if (pair.link_a == subject.link()) pairs.push_back({subject, {pair.link_b}});
    if (pair.link_b == subject.link()) pairs.push_back({subject, {pair.link_a}});
  }
  addObjectPairs(context, subject, filter, pairs);
  return {context.robot, context.objects, std::move(pairs)};
}

RequestedPairs pairsWithObject(const RequestContext& context, const scene::ShapeRef& subject, Filter filter) {
  std::vector<scene::ShapeRefPair> pairs;
  for (std::size_t link = 0; link < context.model().links.size(); ++link) {
    const scene::ShapeRef other{static_cast<int>(link), 0};
    if (!context.model().hasGeometry(other.link())) continue;
    if (filter == Filter::Ignored || reasonOf(context, subject, other) == scene::PairReason::Checked)
      pairs.push_back({subject, other});
  }
  addObjectPairs(context, subject, filter, pairs);
  return {context.robot, context.objects, std::move(pairs)};
}

RequestedPairs pairsWith(const RequestContext& context, const ShapeRef& a, Filter filter) {
  const scene::ShapeRef subject = shapeRefOf(context, a);
  return subject.isObject() ? pairsWithObject(context, subject, filter) : pairsWithLink(context, subject, filter);
}

/// Returns the pairs of links in which the group moves; if no group is named, every pair.
RequestedPairs groupOrEveryPair(const RequestContext& context, const std::string& group, Filter filter) {
  if (group.empty()) return everyPair(context, filter);
  if (filter == Filter::Ignored) {
    refuse("group and ignore_filter exclude each other");
  }
  try {
    return {context.robot, context.objects, context.robot.pairsOfGroup(group)};
  } catch (const std::invalid_argument& error) {
    refuse(error.what());
  }
}

void requirePairs(const RequestedPairs& pairs) {
  if (pairs.size() == 0) refuse("the filter leaves no pair to check");
}

RequestedPairs pairsOf(const RequestContext& context, const ShapeRef& a, const ShapeRef& b, Filter filter) {
  if (!isEmpty(a) && !isEmpty(b)) return {context.robot, context.objects, {onePair(context, a, b, filter)}};
  if (!isEmpty(b)) refuse("b without a: name a, or neither of them");
  RequestedPairs pairs = isEmpty(a) ? everyPair(context, filter) : pairsWith(context, a, filter);
  requirePairs(pairs);
  return pairs;
}

/// Adds all pairs of `more`.
void append(const RequestContext& context, const RequestedPairs& more, std::vector<scene::ShapeRefPair>& pairs) {
  if (more.list()) {
    pairs.insert(pairs.end(), more.list()->begin(), more.list()->end());
    return;
  }
  pairs.insert(pairs.end(), context.robot.candidates().begin(), context.robot.candidates().end());
  for (std::size_t link = 0; link < context.model().links.size(); ++link)
    addObjectPairs(context, {static_cast<int>(link), 0}, Filter::Applies, pairs);
  addPairsOfObjects(context, pairs);
}

/// Returns the pairs of the lists a and b. A single entry may stand for many pairs, so the limit is checked after each
/// entry.
RequestedPairs listedPairs(const RequestContext& context, const QueryPairsRequest& request) {
  const Robot& robot = context.robot;
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
    append(context, pairsOf(context, request.a[i], b, filterOf(request.ignore_filter)), pairs);
    if (isWithinBatch(robot, pairs.size())) continue;
    refuseBatch(robot, "a", std::to_string(pairs.size()) + " pairs in its first " + std::to_string(i + 1) + " entries");
  }
  return {robot, context.objects, std::move(pairs)};
}

}  // namespace

std::size_t maxReturned(const QueryPairsRequest& request, std::size_t checked) {
  switch (request.mode) {
    case QueryPairsRequest::MINIMUM:
    case QueryPairsRequest::FIRST:
      return 1;
    case QueryPairsRequest::K_CLOSEST:
      return std::min<std::size_t>(std::max<std::size_t>(request.k, 1), checked);
    default:
      return checked;
  }
}

void refuse(const std::string& what) { throw RequestError(QueryStatus::INVALID_ARGUMENT, what); }

void require(const QueryStatus& status) {
  if (status.code != QueryStatus::OK) throw RequestError(status);
}

int linkNamed(const scene::RobotModel& robot, const std::string& name) {
  const int index = robot.findLink(name);
  if (index >= 0) return index;
  throw RequestError(QueryStatus::UNKNOWN_LINK,
                     "there is no link '" + name + "'" + scene::didYouMean(name, scene::namesOf(robot.links)));
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

CarrierFrames RequestedPairs::frames() const { return own_ ? framesOf(objects(), *own_) : framesOf(objects()); }

ScenePool::Lease RequestedPairs::borrowScenes() const {
  ScenePool::Lease scenes = robot_->borrowScenes();
  if (scenes->state.objects() != objects_.all) scenes->state.set(objects_.all, carriersOf(*robot_, *objects_.all));
  return scenes;
}

RequestedPairs pairsOf(const Robot& robot, const ShapeRef& a, const ShapeRef& b, Filter filter) {
  return pairsOf(RequestContext{robot, robot.objects().get()}, a, b, filter);
}

RequestedPairs pairsOf(const Robot& robot, const QueryPairsRequest& request) {
  const RequestContext context{robot, robot.objects().get()};
  const bool lists = !request.a.empty() || !request.b.empty();
  RequestedPairs pairs =
      lists ? listedPairs(context, request) : groupOrEveryPair(context, request.group, filterOf(request.ignore_filter));
  requirePairs(pairs);
  return pairs;
}

RequestedPairs shapesOf(const Robot& robot, const std::vector<ShapeRef>& shapes, Unnamed unnamed) {
  const RequestContext context{robot, robot.objects().get()};
  const auto all = [&] {
    return unnamed == Unnamed::Everything ? scene::allShapes(context.model(), context.sceneObjects())
                                          : scene::shapesOfRobot(context.model(), context.sceneObjects());
  };
  std::vector<scene::ShapeRefPair> pairs;
  for (const ShapeRef& shape : shapes) pairs.push_back({shapeRefOf(context, shape), {}});
  if (shapes.empty())
    for (const scene::ShapeRef& shape : all()) pairs.push_back({shape, {}});
  for (scene::ShapeRefPair& pair : pairs) pair.b = pair.a;
  return {robot, context.objects, std::move(pairs)};
}

void requireAnswersWithinBatch(const Robot& robot, const QueryPairsRequest& request, std::size_t pairs,
                               std::size_t states) {
  const std::size_t each = maxReturned(request, pairs);
  if (isWithinBatch(robot, each * states)) return;
  if (states == 1) refuseBatch(robot, "a and b", std::to_string(each) + " returned pairs");
  refuseBatch(robot, "states",
              std::to_string(each * states) + " returned pairs (up to " + std::to_string(each) + " in each of " +
                  std::to_string(states) + " states)");
}

void requireWithinBatch(const Robot& robot, const std::string& field, std::size_t count, const std::string& noun) {
  if (!isWithinBatch(robot, count)) refuseBatch(robot, field, std::to_string(count) + " " + noun);
}

}  // namespace proximity_server::node
