#include "node/answers/conversions.h"
#include "node/answers/gradients.h"
#include "node/answers/statuses.h"
#include "node/services/answered.h"
#include "node/services/pair_questions.h"
#include "node/services/queries.h"
#include "node/services/requests.h"
#include "proximity_server/scene/derivative/derivatives.h"
#include "proximity_server/scene/points/point_search.h"
#include "proximity_server/scene/points/ray_search.h"

#include <algorithm>
#include <cstddef>
#include <stdexcept>
#include <string>
#include <vector>

namespace proximity_server::node {
namespace {

/// The state with the shapes of a request, and the pose of the frame in which the request gives points.
struct PosedShapes {
  /// Throws RequestError if a pose is missing.
  PosedShapes(const Robot& robot, TfPoses& tf, const RequestedPairs& requested, const std_msgs::Header& given)
      : model(robot.robotModel(), &requested.objects()), scenes(requested.borrowScenes()) {
    for (const scene::ShapeRefPair& pair : *requested.list()) shapes.push_back(pair.a);
    CarrierFrames frames = requested.frames();
    std::vector<int> bodies = requested.bodies();
    const bool is_other = !given.frame_id.empty() && given.frame_id != robot.referenceFrame();
    if (is_other) {
      frames.needed.push_back(static_cast<int>(frames.names.size()));
      frames.names.push_back(given.frame_id);
      for (const int body : bodiesOf(robot, frames)) bodies.push_back(body);
    }
    snapshot = tf.await(robot, bodies, given.stamp);
    require(snapshot.status);
    FrameSnapshot placed = tf.awaitFrames(robot, frames, snapshot, given.stamp);
    require(placed.status);
    if (is_other) {
      root_T_given = *placed.poses.back();
      placed.poses.pop_back();
    }
    scenes->state.set(snapshot.poses, placed.poses);
    header.stamp = snapshot.stamp;
    header.frame_id = robot.referenceFrame();
  }

  Eigen::Vector3d inRoot(const geometry_msgs::Point& point) const {
    return root_T_given * Eigen::Vector3d(point.x, point.y, point.z);
  }

  RobotAndObjects model;
  ScenePool::Lease scenes;
  std::vector<scene::ShapeRef> shapes;
  PoseSnapshot snapshot;
  Eigen::Isometry3d root_T_given = Eigen::Isometry3d::Identity();
  std_msgs::Header header;
};

/// Refuses what the library refuses.
template <class Ask>
auto asked(const Ask& ask) try {
  return ask();
} catch (const std::invalid_argument& error) {
  refuse(error.what());
}

}  // namespace

QueryPointsResponse answer(const Robot& robot, TfPoses& tf, const QueryPointsRequest& request) {
  return answered(QueryPointsResponse(), [&](QueryPointsResponse& response) {
    requireWithinBatch(robot, "points", request.points.size(), "points");
    scene::Question question = questionOf(robot);
    question.threshold = thresholdOrNone(request.threshold);
    const PosedShapes posed(robot, tf, shapesOf(robot, request.shapes, Unnamed::RobotWithHeld), request.header);
    response.header = posed.header;
    scene::Points points{{}, request.radii, posed.shapes};
    for (const geometry_msgs::Point& point : request.points) points.centres.push_back(posed.inRoot(point));
    const scene::State& state = posed.scenes->state;
    scene::PointSearch& search = posed.scenes->points();
    for (const scene::PairProximity& found : asked([&] { return search.closest(state, points, question); })) {
      if (request.only_near && found.result.lower_bound > question.threshold) continue;
      Proximity& message = response.points.emplace_back();
      assign(message, posed.model, posed.snapshot.poses, found, question);
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
    const PosedShapes posed(robot, tf, shapesOf(robot, request.shapes, Unnamed::Everything), request.header);
    response.header = posed.header;
    std::vector<scene::Ray> rays;
    for (std::size_t i = 0; i < count; ++i) {
      const geometry_msgs::Vector3& along = request.directions[i];
      scene::Ray& ray = rays.emplace_back();
      ray.origin = posed.inRoot(request.origins[i]);
      ray.direction = posed.root_T_given.linear() * Eigen::Vector3d(along.x, along.y, along.z);
      if (ranges > 0) ray.range = request.ranges[ranges == 1 ? 0 : i];
    }
    scene::RaySearch& search = posed.scenes->rays();
    const auto hits = asked([&] { return search.firstHits(posed.scenes->state, rays, posed.shapes, question); });
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
