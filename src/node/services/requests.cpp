#include "node/services/requests.h"
#include "proximity_server/scene/model/names.h"

#include <algorithm>
#include <cmath>

namespace proximity_server::node {
namespace {

bool hasGeometry(const scene::RobotModel& robot, int collision) { return !robot.collisions[collision].pieces.empty(); }

int linkWithGeometry(const scene::RobotModel& robot, const std::string& name) {
  const int index = linkNamed(robot, name);
  if (!robot.hasGeometry(index)) {
    throw RequestError(QueryStatus::NO_COLLISION_GEOMETRY, "link '" + name + "' has no collision geometry");
  }
  return index;
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
  throw RequestError(QueryStatus::INVALID_ARGUMENT, "link '" + link.name + "' has no <collision> '" + name +
                                                        "': did you mean '" +
                                                        scene::nearestName(name, scene::namesOf(collisions)) + "'?");
}

int shapeNumbered(const scene::Link& link, std::uint32_t number) {
  if (number <= link.collisions.size()) return static_cast<int>(number);
  throw RequestError(QueryStatus::INVALID_ARGUMENT,
                     "link '" + link.name + "' has " + std::to_string(link.collisions.size()) +
                         " <collision> elements, asked was number " + std::to_string(number));
}

scene::ShapeRef shapeRefOf(const scene::RobotModel& robot, const ShapeRef& ref) {
  const int index = linkWithGeometry(robot, ref.link);
  const scene::Link& link = robot.links[index];
  if (ref.index == 0 && ref.name.empty()) return {index, 0};
  const int number = ref.index > 0 ? shapeNumbered(link, ref.index) : shapeNamed(robot, link, ref.name);
  if (!hasGeometry(robot, link.collisions[number - 1])) {
    throw RequestError(QueryStatus::NO_COLLISION_GEOMETRY,
                       "<collision> " + std::to_string(number) + " of link '" + ref.link + "' has no geometry");
  }
  return {index, number};
}

bool isEmpty(const ShapeRef& ref) { return ref.link.empty() && ref.index == 0 && ref.name.empty(); }

bool isSame(const scene::ShapeRef& a, const scene::ShapeRef& b) {
  return a.link == b.link && (a.collision == b.collision || a.collision == 0 || b.collision == 0);
}

scene::ShapeRefPair onePair(const Robot& robot, const ShapeRef& a, const ShapeRef& b, Filter filter) {
  const scene::ShapeRefPair pair{shapeRefOf(robot.robotModel(), a), shapeRefOf(robot.robotModel(), b)};
  const auto names = [&] { return "'" + a.link + "' and '" + b.link + "'"; };
  if (isSame(pair.a, pair.b)) throw RequestError(QueryStatus::INVALID_ARGUMENT, names() + " are the same");
  if (filter == Filter::Ignored) return pair;

  const scene::PairTable& table = robot.sceneModel().pairs;
  const int row = table.find(pair.a.link, pair.b.link);
  const scene::PairReason reason = row < 0 ? scene::PairReason::SameBody : table.pairs[row].reason;
  if (reason != scene::PairReason::Checked) {
    throw RequestError(QueryStatus::PAIR_EXCLUDED,
                       names() + " are not checked: " + toString(reason) + "; ignore_filter asks anyway");
  }
  return pair;
}

RequestedPairs everyPair(const Robot& robot, Filter filter) {
  if (filter == Filter::Applies) return RequestedPairs::candidatesOf(robot);
  std::vector<scene::ShapeRefPair> pairs;
  for (const scene::LinkPair& pair : robot.sceneModel().pairs.pairs) pairs.push_back({{pair.link_a}, {pair.link_b}});
  return {robot, std::move(pairs)};
}

/// All pairs with `a`, in which `a` comes first.
RequestedPairs pairsWith(const Robot& robot, const ShapeRef& a, Filter filter) {
  const scene::ShapeRef subject = shapeRefOf(robot.robotModel(), a);
  std::vector<scene::ShapeRefPair> pairs;
  const RequestedPairs every = everyPair(robot, filter);
  for (const scene::ShapeRefPair& pair : every.list()) {
    if (pair.a.link == subject.link) pairs.push_back({subject, pair.b});
    if (pair.b.link == subject.link) pairs.push_back({subject, pair.a});
  }
  return {robot, std::move(pairs)};
}

RequestedPairs groupOrEveryPair(const Robot& robot, const std::string& group, Filter filter) {
  if (group.empty()) return everyPair(robot, filter);
  if (filter == Filter::Ignored) {
    throw RequestError(QueryStatus::INVALID_ARGUMENT, "group and ignore_filter exclude each other");
  }
  try {
    return {robot, robot.pairsOfGroup(group)};
  } catch (const std::invalid_argument& error) {
    throw RequestError(QueryStatus::INVALID_ARGUMENT, error.what());
  }
}

bool isWithinBatch(const Robot& robot, std::size_t count) {
  return count <= static_cast<std::size_t>(robot.config().max_batch);
}

/// Throws RequestError OVER_BUDGET. `what` is a count with its noun: "12 entries".
[[noreturn]] void refuseBatch(const Robot& robot, const std::string& field, const std::string& what) {
  throw RequestError(QueryStatus::OVER_BUDGET,
                     field + ": " + what + ", max_batch is " + std::to_string(robot.config().max_batch));
}

/// The pairs of the lists a and b. A single entry may stand for many pairs, so the limit is checked after each entry.
RequestedPairs listedPairs(const Robot& robot, const QueryPairsRequest& request) {
  if (!request.group.empty()) throw RequestError(QueryStatus::INVALID_ARGUMENT, "group goes with empty a and b only");
  if (!request.b.empty() && request.b.size() != request.a.size()) {
    throw RequestError(QueryStatus::INVALID_ARGUMENT, "a and b must have the same length, or b none");
  }
  const std::size_t entries = request.a.size();
  if (!isWithinBatch(robot, entries)) refuseBatch(robot, "a", std::to_string(entries) + " entries");
  const ShapeRef any;
  std::vector<scene::ShapeRefPair> pairs;
  for (std::size_t i = 0; i < entries; ++i) {
    const ShapeRef& b = request.b.empty() ? any : request.b[i];
    const RequestedPairs more = pairsOf(robot, request.a[i], b, filterOf(request.ignore_filter));
    pairs.insert(pairs.end(), more.list().begin(), more.list().end());
    if (isWithinBatch(robot, pairs.size())) continue;
    refuseBatch(robot, "a", std::to_string(pairs.size()) + " pairs in its first " + std::to_string(i + 1) + " entries");
  }
  return {robot, std::move(pairs)};
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

void requirePairs(const RequestedPairs& pairs) {
  if (pairs.size() == 0) throw RequestError(QueryStatus::INVALID_ARGUMENT, "the filter leaves no pair to check");
}

}  // namespace

QueryStatus RequestError::status() const {
  QueryStatus status;
  status.code = code_;
  status.message = what();
  return status;
}

int linkNamed(const scene::RobotModel& robot, const std::string& name) {
  const int index = robot.findLink(name);
  if (index >= 0) return index;
  throw RequestError(QueryStatus::UNKNOWN_LINK, "there is no link '" + name + "': did you mean '" +
                                                    scene::nearestName(name, scene::namesOf(robot.links)) + "'?");
}

double finite(double value, const std::string& name) {
  if (!std::isfinite(value)) throw RequestError(QueryStatus::INVALID_ARGUMENT, name + " is not finite");
  return value;
}

double notNegative(double value, const std::string& name) {
  if (finite(value, name) >= 0.0) return value;
  throw RequestError(QueryStatus::INVALID_ARGUMENT, name + " must not be negative");
}

double positive(double value, const std::string& name) {
  if (finite(value, name) > 0.0) return value;
  throw RequestError(QueryStatus::INVALID_ARGUMENT, name + " must be positive");
}

RequestedPairs pairsOf(const Robot& robot, const ShapeRef& a, const ShapeRef& b, Filter filter) {
  if (!isEmpty(a) && !isEmpty(b)) return {robot, {onePair(robot, a, b, filter)}};
  if (!isEmpty(b)) throw RequestError(QueryStatus::INVALID_ARGUMENT, "b without a: name a, or neither of them");
  RequestedPairs pairs = isEmpty(a) ? everyPair(robot, filter) : pairsWith(robot, a, filter);
  requirePairs(pairs);
  return pairs;
}

RequestedPairs pairsOf(const Robot& robot, const QueryPairsRequest& request) {
  const bool lists = !request.a.empty() || !request.b.empty();
  RequestedPairs pairs =
      lists ? listedPairs(robot, request) : groupOrEveryPair(robot, request.group, filterOf(request.ignore_filter));
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
