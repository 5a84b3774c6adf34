#include "queries.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "conversions.h"
#include "requests.h"

namespace proximity_server {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

double finite(double value, const char* name) {
  if (!std::isfinite(value)) throw RequestError(QueryStatus::INVALID_ARGUMENT, std::string(name) + " is not finite");
  return value;
}

double notNegative(double value, const char* name) {
  if (finite(value, name) >= 0.0) return value;
  throw RequestError(QueryStatus::INVALID_ARGUMENT, std::string(name) + " must not be negative");
}

double thresholdOrNone(double threshold) { return finite(threshold, "threshold") > 0.0 ? threshold : kInfinity; }

/// A scene in the poses that a request needs.
struct PosedScene {
  PosedScene(const Robot& asked_robot, TfPoses& tf, const std::vector<SubjectPair>& pairs, const ros::Time& stamp)
      : robot(asked_robot.links()),
        snapshot(tf.await(asked_robot, bodiesOf(robot, pairs), stamp)),
        scene(asked_robot.takeScene()) {
    scene->update(snapshot.poses);
    header.stamp = snapshot.stamp;
    header.frame_id = asked_robot.referenceFrame();
  }

  Proximity message(const PairProximity& pair, const Question& question) const {
    return toMessage(robot, snapshot.poses, pair, question);
  }

  const RobotModel& robot;
  PoseSnapshot snapshot;
  ScenePool::Lease scene;
  std_msgs::Header header;
};

void requireAllPoses(const PosedScene& posed) {
  if (posed.snapshot.status.code != QueryStatus::OK) throw RequestError(posed.snapshot.status);
}

/// The closest of `pairs`, all of whose poses are known.
Proximity closestPair(const PosedScene& posed, const std::vector<SubjectPair>& pairs, const Question& question,
                      QueryStatus& status) {
  PairProximity only;
  const PairProximity* closest = nullptr;
  if (pairs.size() == 1) {
    only = posed.scene->proximity(pairs.front(), question);
    closest = &only;
  } else {
    closest = posed.scene->minimum(pairs, question);
  }
  if (!closest) return beyondThreshold(question.threshold);
  status.code = statusCode(closest->result);
  return posed.message(*closest, question);
}

Question questionOf(const Robot& robot) {
  Question question;
  question.tolerance = robot.config().tolerance;
  return question;
}

/// Runs `ask`, which fills the response; what it throws becomes the status of a response without numbers.
template <class Response, class Ask>
Response answered(const Response& empty, Ask ask) {
  Response response = empty;
  try {
    ask(response);
  } catch (const RequestError& error) {
    const std_msgs::Header header = response.header;
    response = empty;
    response.header = header;
    response.status = error.status();
  }
  response.success = response.status.code == QueryStatus::OK;
  return response;
}

geometry_msgs::Vector3 nowhere() {
  geometry_msgs::Vector3 vector;
  vector.x = vector.y = vector.z = kNaN;
  return vector;
}

MinimumDistanceResponse emptyMinimumDistance() {
  MinimumDistanceResponse response;
  response.pair = unknownProximity();
  return response;
}

SeparationAxisResponse emptySeparationAxis() {
  SeparationAxisResponse response;
  response.pair = unknownProximity();
  response.axis = nowhere();
  response.gap = response.plane_offset = kNaN;
  return response;
}

PenetrationDepthResponse emptyPenetrationDepth() {
  PenetrationDepthResponse response;
  response.pair = unknownProximity();
  response.direction = nowhere();
  response.depth = response.depth_lower_bound = response.depth_upper_bound = kNaN;
  return response;
}

QueryPairsResponse emptyQueryPairs() {
  QueryPairsResponse response;
  response.minimum = unknownProximity();
  return response;
}

double along(const geometry_msgs::Vector3& axis, const geometry_msgs::Point& point) {
  return axis.x * point.x + axis.y * point.y + axis.z * point.z;
}

/// The pairs that the request's mode asks for.
std::vector<PairProximity> askByMode(Scene& scene, const std::vector<SubjectPair>& pairs,
                                     const QueryPairsRequest& request, const Question& question) {
  const auto list = [](const PairProximity* pair) {
    return pair ? std::vector<PairProximity>{*pair} : std::vector<PairProximity>{};
  };
  switch (request.mode) {
    case QueryPairsRequest::MINIMUM:
      return list(scene.minimum(pairs, question));
    case QueryPairsRequest::FIRST:
      return list(scene.first(pairs, question));
    case QueryPairsRequest::K_CLOSEST: {
      const std::size_t k = std::min<std::size_t>(std::max<std::size_t>(request.k, 1), pairs.size());
      return scene.closest(pairs, static_cast<int>(k), question);
    }
    case QueryPairsRequest::PER_PAIR:
      return scene.all(pairs, question);
    case QueryPairsRequest::BELOW_THRESHOLD:
      return scene.below(pairs, question);
    default:
      throw RequestError(QueryStatus::INVALID_ARGUMENT, "mode " + std::to_string(request.mode) + " does not exist");
  }
}

Question questionOf(const Robot& robot, const QueryPairsRequest& request) {
  Question question = questionOf(robot);
  const bool literal = request.mode == QueryPairsRequest::FIRST || request.mode == QueryPairsRequest::BELOW_THRESHOLD;
  question.threshold = literal ? finite(request.threshold, "threshold") : thresholdOrNone(request.threshold);
  if (request.skip_penetration) question.depth = Question::Depth::NotWanted;
  return question;
}

bool isCloser(const Proximity& a, const Proximity& b) {
  if (a.state == Proximity::UNKNOWN || b.state == Proximity::UNKNOWN) return b.state == Proximity::UNKNOWN;
  return a.lower_bound < b.lower_bound;
}

void countPairs(QueryPairsResponse& response, const PairCounts& counts) {
  response.pairs_total = static_cast<std::uint32_t>(counts.total);
  response.pairs_unknown = static_cast<std::uint32_t>(counts.unknown);
  response.pairs_at_rest = static_cast<std::uint32_t>(counts.at_rest);
  response.pairs_by_motion = static_cast<std::uint32_t>(counts.by_motion);
  response.pairs_by_bounds = static_cast<std::uint32_t>(counts.by_bounds);
  response.pairs_computed = static_cast<std::uint32_t>(counts.computed);
}

}  // namespace

MinimumDistanceResponse answer(const Robot& robot, TfPoses& tf, const MinimumDistanceRequest& request) {
  return answered(emptyMinimumDistance(), [&](MinimumDistanceResponse& response) {
    Question question = questionOf(robot);
    question.threshold = thresholdOrNone(request.threshold);
    const auto pairs = pairsOf(robot, request.a, request.b, filterOf(request.ignore_filter));
    const PosedScene posed(robot, tf, pairs, request.stamp);
    response.header = posed.header;
    requireAllPoses(posed);
    response.pair = closestPair(posed, pairs, question, response.status);
  });
}

SeparationAxisResponse answer(const Robot& robot, TfPoses& tf, const SeparationAxisRequest& request) {
  return answered(emptySeparationAxis(), [&](SeparationAxisResponse& response) {
    const double margin = notNegative(request.margin, "margin");
    Question question = questionOf(robot);
    question.depth = Question::Depth::NotWanted;
    const auto pairs = pairsOf(robot, request.a, request.b, filterOf(request.ignore_filter));
    const PosedScene posed(robot, tf, pairs, request.stamp);
    response.header = posed.header;
    requireAllPoses(posed);
    response.pair = closestPair(posed, pairs, question, response.status);
    response.separated = response.pair.lower_bound > margin;
    if (response.pair.state != Proximity::SEPARATED) return;
    response.gap = response.pair.lower_bound;
    response.axis = response.pair.normal;
    response.plane_offset =
        0.5 * (along(response.axis, response.pair.point_a) + along(response.axis, response.pair.point_b));
  });
}

PenetrationDepthResponse answer(const Robot& robot, TfPoses& tf, const PenetrationDepthRequest& request) {
  return answered(emptyPenetrationDepth(), [&](PenetrationDepthResponse& response) {
    Question question = questionOf(robot);
    question.threshold = -notNegative(request.threshold, "threshold");
    const auto pairs = pairsOf(robot, request.a, request.b, filterOf(request.ignore_filter));
    const PosedScene posed(robot, tf, pairs, request.stamp);
    response.header = posed.header;
    requireAllPoses(posed);
    response.pair = closestPair(posed, pairs, question, response.status);
    response.penetrating = response.pair.state == Proximity::PENETRATING;
    response.depth_lower_bound = std::max(0.0, -response.pair.upper_bound);
    response.depth_upper_bound = response.pair.depth_is_lower_bound ? std::numeric_limits<double>::infinity()
                                                                    : std::max(0.0, -response.pair.lower_bound);
    const bool settled = response.penetrating || response.depth_upper_bound == 0.0;
    response.depth = settled ? std::max(0.0, -response.pair.distance) : kNaN;
    if (response.penetrating) response.direction = response.pair.normal;
  });
}

QueryPairsResponse answer(const Robot& robot, TfPoses& tf, const QueryPairsRequest& request) {
  return answered(emptyQueryPairs(), [&](QueryPairsResponse& response) {
    const Question question = questionOf(robot, request);
    const auto pairs = pairsOf(robot, request);
    const PosedScene posed(robot, tf, pairs, request.stamp);
    response.header = posed.header;
    const std::vector<PairProximity> found = askByMode(*posed.scene, pairs, request, question);
    countPairs(response, posed.scene->counts());

    for (const PairProximity& pair : found) {
      response.pairs.push_back(posed.message(pair, question));
      if (pair.result.status != Status::Unknown)
        response.status.code = std::min(response.status.code, statusCode(pair.result));
    }
    const bool decided = request.mode == QueryPairsRequest::FIRST && !found.empty();
    if (response.pairs_unknown > 0 && !decided) {
      response.status = posed.snapshot.status;
      return;
    }
    const auto closest = std::min_element(response.pairs.begin(), response.pairs.end(), isCloser);
    if (closest != response.pairs.end()) response.minimum = *closest;
  });
}

}  // namespace proximity_server
