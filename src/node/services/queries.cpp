#include "node/services/queries.h"

#include "node/answers/conversions.h"
#include "node/answers/gradients.h"
#include "node/answers/statuses.h"
#include "node/services/answered.h"
#include "node/services/pair_questions.h"
#include "node/services/requests.h"
#include "proximity_server/scene/derivative/derivatives.h"
#include "proximity_server/scene/points/point_search.h"
#include "proximity_server/scene/points/ray_search.h"

#include <algorithm>
#include <cstddef>
#include <limits>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace proximity_server::node {
namespace {

/// The state that a request is about with its scenes, borrowed when its poses are known, and the header of the answer.
struct AwaitedState {
  /// `frame`: any frame of tf in which the request gives points; "": the reference frame.
  AwaitedState(const Robot& asked_robot, TfPoses& tf, const RequestedPairs& pairs, const ros::Time& stamp,
               const std::string& frame = "")
      : model(asked_robot.robotModel(), &pairs.objects()) {
    CarrierFrames needed = pairs.frames();
    std::vector<int> bodies = pairs.bodies();
    const bool is_other = !frame.empty() && frame != asked_robot.referenceFrame();
    if (is_other) {
      needed.needed.push_back(static_cast<int>(needed.names.size()));
      needed.names.push_back(frame);
      for (const int body : bodiesOf(asked_robot, needed)) bodies.push_back(body);
    }
    snapshot = tf.await(asked_robot, bodies, stamp);
    frames = tf.awaitFrames(asked_robot, needed, snapshot, stamp);
    scenes = pairs.borrowScenes();
    if (snapshot.status.code == QueryStatus::OK) snapshot.status = frames.status;
    if (is_other) {
      root_T_frame = frames.poses.back().value_or(root_T_frame);
      frames.poses.pop_back();
    }
    scenes->state.set(snapshot.poses, frames.poses);
    header.stamp = snapshot.stamp;
    header.frame_id = asked_robot.referenceFrame();
  }

  Proximity message(const scene::PairProximity& pair, const scene::Question& question) const {
    return toMessage(model, snapshot.poses, pair, question);
  }

  Eigen::Vector3d inRoot(const geometry_msgs::Point& point) const {
    return root_T_frame * Eigen::Vector3d(point.x, point.y, point.z);
  }

  RobotAndObjects model;
  PoseSnapshot snapshot;
  FrameSnapshot frames;
  ScenePool::Lease scenes;
  Eigen::Isometry3d root_T_frame = Eigen::Isometry3d::Identity();
  std_msgs::Header header;
};

/// Fills the header, the status and the pair of a response about the closest of the requested pairs, and returns this
/// pair; nullopt if all are beyond the threshold.
template <class Response, class Request>
std::optional<scene::PairProximity> answerClosest(const Robot& robot, TfPoses& tf, const Request& request,
                                                  const scene::Question& question, Response& response) {
  const auto pairs = pairsOf(robot, request.a, request.b, filterOf(request.ignore_filter));
  const scene::Uncertainty uncertainty = uncertaintyOf(robot, request.uncertainty);
  const AwaitedState posed(robot, tf, pairs, request.stamp);
  const scene::State& state = posed.scenes->state;
  scene::Scene& scene = posed.scenes->scene;
  response.header = posed.header;
  require(posed.snapshot.status);
  std::optional<scene::PairProximity> closest;
  if (pairs.list() && pairs.size() == 1)
    closest = scene.proximity(state, pairs.list()->front(), question);
  else if (const scene::PairProximity* found = scene.minimum(state, pairs.asked(), question))
    closest = *found;
  if (scene.counts().unknown > 0) throw RequestError(incompleteness(robot, scene.counts(), question));
  response.pair = closest ? posed.message(*closest, question) : beyondThreshold(question.threshold);
  if (closest) response.status.code = statusCode(closest->result);
  scene::GuaranteedDistances* const guaranteed = guaranteedWithin(uncertainty, *posed.scenes, question);
  if (!guaranteed) return closest;
  response.pair.guaranteed = closest ? guaranteed->of(state, *closest) : kNaN;
  if (response.status.code == QueryStatus::OK) response.status = statusOf(robot, *guaranteed);
  return closest;
}

geometry_msgs::Vector3 unknownVector() {
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
  response.axis = unknownVector();
  response.gap = response.plane_offset = kNaN;
  return response;
}

PenetrationDepthResponse emptyPenetrationDepth() {
  PenetrationDepthResponse response;
  response.pair = unknownProximity();
  response.direction = unknownVector();
  response.depth = response.depth_lower_bound = response.depth_upper_bound = kNaN;
  return response;
}

QueryPairsResponse emptyQueryPairs() {
  QueryPairsResponse response;
  response.minimum = unknownProximity();
  return response;
}

/// The first shapes of a list of pairs.
std::vector<scene::ShapeRef> firstOf(const RequestedPairs& pairs) {
  std::vector<scene::ShapeRef> shapes;
  for (const scene::ShapeRefPair& pair : *pairs.list()) shapes.push_back(pair.a);
  return shapes;
}

/// Refuses what the library refuses.
template <class Ask>
auto asked(const Ask& ask) try {
  return ask();
} catch (const std::invalid_argument& error) {
  refuse(error.what());
}

/// [m] The offset of the plane halfway between the two points of a pair, along the normal.
double planeOffset(const narrowphase::SignedDistance& pair) {
  // Not dot(), which adds in another order: the last digits stay as in 1.0.0.
  const auto along = [&](const Eigen::Vector3d& point) {
    return pair.normal.x() * point.x() + pair.normal.y() * point.y() + pair.normal.z() * point.z();
  };
  return 0.5 * (along(pair.point_a) + along(pair.point_b));
}

}  // namespace

MinimumDistanceResponse answer(const Robot& robot, TfPoses& tf, const MinimumDistanceRequest& request) {
  return answered(emptyMinimumDistance(), [&](MinimumDistanceResponse& response) {
    scene::Question question = questionOf(robot);
    question.threshold = thresholdOrNone(request.threshold);
    answerClosest(robot, tf, request, question, response);
  });
}

SeparationAxisResponse answer(const Robot& robot, TfPoses& tf, const SeparationAxisRequest& request) {
  return answered(emptySeparationAxis(), [&](SeparationAxisResponse& response) {
    const double margin = notNegative(request.margin, "margin");
    scene::Question question = questionOf(robot);
    question.depth = scene::Question::Depth::NotWanted;
    const std::optional<scene::PairProximity> closest = answerClosest(robot, tf, request, question, response);
    response.separated = response.pair.lower_bound > margin;
    if (response.pair.state != Proximity::SEPARATED) return;
    response.gap = response.pair.lower_bound;
    response.axis = response.pair.normal;
    if (closest) response.plane_offset = planeOffset(closest->result);
  });
}

PenetrationDepthResponse answer(const Robot& robot, TfPoses& tf, const PenetrationDepthRequest& request) {
  return answered(emptyPenetrationDepth(), [&](PenetrationDepthResponse& response) {
    scene::Question question = questionOf(robot);
    question.threshold = -notNegative(request.threshold, "threshold");
    answerClosest(robot, tf, request, question, response);
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
    const scene::Question question = questionOf(robot, request);
    const auto pairs = pairsOf(robot, request);
    requireAnswersWithinBatch(robot, request, pairs.size());
    const AwaitedState posed(robot, tf, pairs, request.stamp);
    response.header = posed.header;
    PosedScenes& scenes = *posed.scenes;
    scene::GuaranteedDistances* const guaranteed =
        guaranteedWithin(uncertaintyOf(robot, request.uncertainty), scenes, question);
    StateProximity found =
        askPairs(robot, scenes, {posed.snapshot.poses, posed.snapshot.status}, pairs, request, question, guaranteed);
    if (request.want_gradient) assignColumns(response.joint_names, scenes.state.degreesOfFreedom());
    response.status = std::move(found.status);
    response.pairs = std::move(found.pairs);
    response.minimum = std::move(found.minimum);
    assignCounts(response, scenes.scene.counts());
  });
}

QueryPointsResponse answer(const Robot& robot, TfPoses& tf, const QueryPointsRequest& request) {
  return answered(QueryPointsResponse(), [&](QueryPointsResponse& response) {
    requireWithinBatch(robot, "points", request.points.size(), "points");
    scene::Question question = questionOf(robot);
    question.threshold = thresholdOrNone(request.threshold);
    const RequestedPairs shapes = shapesOf(robot, request.shapes, Unnamed::RobotWithHeld);
    const AwaitedState posed(robot, tf, shapes, request.header.stamp, request.header.frame_id);
    require(posed.snapshot.status);
    response.header = posed.header;
    scene::Points points{{}, request.radii, firstOf(shapes)};
    for (const geometry_msgs::Point& point : request.points) points.centres.push_back(posed.inRoot(point));
    const scene::State& state = posed.scenes->state;
    scene::PointSearch& search = posed.scenes->points();
    for (const scene::PairProximity& found : asked([&] { return search.closest(state, points, question); })) {
      if (request.only_near && found.result.lower_bound > question.threshold) continue;
      Proximity& message = response.points.emplace_back(posed.message(found, question));
      if (request.want_gradient && found.result.has_points) scene::gradient(state, found, message.gradient);
      if (found.result.status != narrowphase::Status::Unknown)
        response.status.code = std::min(response.status.code, statusCode(found.result));
    }
    if (request.want_gradient) assignColumns(response.joint_names, state.degreesOfFreedom());
    if (search.counts().unknown > 0) response.status = incompleteness(robot, search.counts(), question, "points");
  });
}

QueryRaysResponse answer(const Robot& robot, TfPoses& tf, const QueryRaysRequest& request) {
  return answered(QueryRaysResponse(), [&](QueryRaysResponse& response) {
    const std::size_t count = request.origins.size(), ranges = request.ranges.size();
    requireWithinBatch(robot, "origins", count, "rays");
    if (request.directions.size() != count) refuse("origins and directions must have the same length");
    if (ranges > 1 && ranges != count) refuse("ranges must be one for all, one for each of origins, or none");
    const scene::Question question = questionOf(robot);
    const RequestedPairs shapes = shapesOf(robot, request.shapes, Unnamed::Everything);
    const AwaitedState posed(robot, tf, shapes, request.header.stamp, request.header.frame_id);
    require(posed.snapshot.status);
    response.header = posed.header;
    std::vector<scene::Ray> rays;
    for (std::size_t i = 0; i < count; ++i) {
      const geometry_msgs::Vector3& along = request.directions[i];
      scene::Ray& ray = rays.emplace_back();
      ray.origin = posed.inRoot(request.origins[i]);
      ray.direction = posed.root_T_frame.linear() * Eigen::Vector3d(along.x, along.y, along.z);
      if (ranges > 0) ray.range = request.ranges[ranges == 1 ? 0 : i];
    }
    scene::RaySearch& search = posed.scenes->rays();
    const auto hits = asked([&] { return search.firstHits(posed.scenes->state, rays, firstOf(shapes), question); });
    scene::PairCounts counts;
    for (std::size_t i = 0; i < count; ++i) {
      response.hits.push_back(toMessage(posed.model, rays[i], hits[i]));
      counts.unknown += response.hits.back().state == RayHit::UNKNOWN;
    }
    counts.total = static_cast<int>(count);
    if (counts.unknown > 0) response.status = incompleteness(robot, counts, question, "rays");
  });
}

}  // namespace proximity_server::node
