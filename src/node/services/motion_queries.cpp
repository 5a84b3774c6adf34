#include "node/answers/conversions.h"
#include "node/answers/statuses.h"
#include "node/services/answered.h"
#include "node/services/joint_requests.h"
#include "node/services/motion_requests.h"
#include "node/services/queries.h"
#include "proximity_server/scene/model/kinematics.h"
#include "system/durations.h"

#include <limits>
#include <sstream>
#include <string>

namespace proximity_server::node {
namespace {

FirstContactResponse emptyFirstContact() {
  FirstContactResponse response;
  response.t_free = response.t_contact = kNaN;
  response.pair = unknownProximity();
  response.minimum = unknownMinimum();
  return response;
}

QueryTrajectoryResponse emptyQueryTrajectory() {
  QueryTrajectoryResponse response;
  response.t_free = response.t_contact = kNaN;
  response.segment = -1;
  response.pair = unknownProximity();
  return response;
}

/// Writes the time of contact into a response, with times in seconds.
template <class Response>
void fillContact(Response& response, const RobotAndObjects& model, const TimedMotion& motion,
                 const scene::RobotTimeOfContact& found) {
  response.t_free = motion.timeAt(found.t_free);
  response.contact = found.contact;
  if (!found.contact) return;
  response.t_contact = motion.timeAt(found.t_contact);
  response.pair = toMessage(model, motion, found.t_contact, found.pair);
}

/// The motions between successive way points, with the objects that they carry.
std::vector<TimedMotion> segmentsOf(const Robot& robot, const WayPoints& points, const JointSnapshot& from_tf,
                                    const CarrierFrames& frames, const scene::FramePoses& poses_of_frames) {
  std::vector<TimedMotion> segments;
  for (std::size_t i = 0; i + 1 < points.times.size(); ++i) {
    const scene::BodyPoses start = inReference(robot, posesInRoot(robot, points.positions[i], from_tf), from_tf.roots);
    segments.push_back(motionOfJoints(robot, start, travelBetween(points.positions[i], points.positions[i + 1]),
                                      points.times[i], points.times[i + 1] - points.times[i]));
    carryObjects(robot, frames, poses_of_frames, segments.back());
  }
  return segments;
}

/// The positions of the named joints at a parameter in [0, 1] of the segment between two way points.
sensor_msgs::JointState stateBetween(const scene::RobotModel& robot, const WayPoints& points, std::size_t segment,
                                     double parameter) {
  const JointValues& from = points.positions[segment];
  const JointValues& to = points.positions[segment + 1];
  sensor_msgs::JointState state;
  for (const int index : points.joints) {
    const auto joint = static_cast<std::size_t>(index);
    state.name.push_back(robot.joints[joint].name);
    state.position.push_back(*from[joint] + parameter * (*to[joint] - *from[joint]));
  }
  return state;
}

/// A trajectory and the question about it.
struct TrajectorySearch {
  const RobotAndObjects model;
  const scene::Pairs pairs;
  const WayPoints& points;
  const std::vector<TimedMotion>& segments;
  const scene::MotionQuestion& question;
  scene::MovingScene& scene;
};

/// A warning about the first point of the trajectory at which a joint is beyond its limit; "" if there is none.
std::string beyondLimits(const scene::RobotModel& robot, const WayPoints& points) {
  constexpr double kRounding = 1e-6;  // [rad] or [m], because positions may be written with six decimals
  std::ostringstream text;
  for (std::size_t i = 0; i < points.positions.size(); ++i) {
    for (const int index : points.joints) {
      const scene::Joint& joint = robot.joints[index];
      const double position = *points.positions[i][index];
      const bool is_below = position < joint.lower - kRounding;
      if (joint.mimic || (!is_below && !(position > joint.upper + kRounding))) continue;
      text << "point " << i << " is the first beyond a limit: joint '" << joint.name << "' is at " << position
           << ", its " << (is_below ? "lower" : "upper") << " limit is " << (is_below ? joint.lower : joint.upper);
      return text.str();
    }
  }
  return {};
}

/// Searches segment by segment until a contact is found, or until the search of a segment is not complete.
void findContact(const TrajectorySearch& search, QueryTrajectoryResponse& response) {
  for (std::size_t i = 0; i < search.segments.size(); ++i) {
    const TimedMotion& motion = search.segments[i];
    const scene::RobotTimeOfContact found = search.scene.timeOfContact(search.pairs, motion.motion, search.question);
    require(completeness(found.counts));
    response.status = statusOf(found.status, search.question);
    fillContact(response, search.model, motion, found);
    if (found.contact) {
      response.segment = static_cast<std::int32_t>(i);
      response.state = stateBetween(search.model.robot, search.points, i, found.t_contact);
    }
    if (found.contact || response.status.code != QueryStatus::OK) return;
  }
}

void findMinima(const TrajectorySearch& search, QueryTrajectoryResponse& response) {
  response.segments.assign(search.segments.size(), unknownMinimum());
  for (std::size_t i = 0; i < search.segments.size(); ++i) {
    const TimedMotion& motion = search.segments[i];
    const scene::RobotMinimum found = search.scene.minimum(search.pairs, motion.motion, search.question);
    response.segments[i] = toMessage(search.model, motion, found);
    const QueryStatus status = statusOf(found.status, search.question);
    if (status.code != QueryStatus::OK) {
      response.status = status;
      return;
    }
    response.segments_finished = static_cast<std::uint32_t>(i + 1);
  }
}

}  // namespace

FirstContactResponse answer(const Robot& robot, TfPoses& tf, const FirstContactRequest& request) {
  return answered(emptyFirstContact(), [&](FirstContactResponse& response) {
    const auto thresholds = robot.thresholds();
    scene::MotionQuestion question = motionQuestion(request.contact_distance, request.tolerance, thresholds->stop);
    const double budget = timeBudget(robot, request.time_budget);
    positive(request.horizon, "horizon");
    const auto pairs = pairsOf(robot, request.a, request.b, filterOf(request.ignore_filter));
    const PoseSnapshot start = tf.await(robot, pairs.bodies(), request.stamp);
    response.header.stamp = start.stamp;
    response.header.frame_id = robot.referenceFrame();
    require(start.status);
    const CarrierFrames asked_frames = pairs.frames();
    const FrameSnapshot frames = tf.awaitFrames(robot, asked_frames, start, request.stamp);
    require(frames.status);
    TimedMotion motion = motionOf(robot, start.poses, request);
    carryObjects(robot, asked_frames, frames.poses, motion);
    assignStops(response, robot, motion);

    const RobotAndObjects model(robot.robotModel(), &pairs.objects());
    const MovingScenePool::Lease scene = pairs.borrowMovingScene();
    question.deadline = system::deadlineIn(budget);
    const scene::RobotTimeOfContact found = scene->timeOfContact(pairs.asked(), motion.motion, question);
    require(completeness(found.counts));
    response.status = statusOf(found.status, question);
    fillContact(response, model, motion, found);
    if (found.contact || request.skip_minimum || response.status.code != QueryStatus::OK) return;
    const scene::RobotMinimum minimum = scene->minimum(pairs.asked(), motion.motion, question);
    response.minimum = toMessage(model, motion, minimum);
    response.status = statusOf(minimum.status, question);
  });
}

QueryTrajectoryResponse answer(const Robot& robot, TfPoses& tf, const QueryTrajectoryRequest& request) {
  return answered(emptyQueryTrajectory(), [&](QueryTrajectoryResponse& response) {
    const auto thresholds = robot.thresholds();
    scene::MotionQuestion question = motionQuestion(request.contact_distance, request.tolerance, thresholds->stop);
    const double budget = timeBudget(robot, request.time_budget);
    const auto pairs = pairsOf(robot, request.a, request.b, filterOf(request.ignore_filter));
    const WayPoints points = wayPointsOf(robot, request);
    const JointSnapshot from_tf = missingFromTf(robot, tf, pairs.bodies(), points.positions, request.stamp);
    response.header.stamp = from_tf.stamp;
    response.header.frame_id = robot.referenceFrame();
    require(from_tf.status);
    const CarrierFrames asked_frames = pairs.frames();
    const FrameSnapshot frames = framesFromTf(robot, tf, asked_frames, from_tf, request.stamp);
    require(frames.status);
    const std::vector<TimedMotion> segments = segmentsOf(robot, points, from_tf, asked_frames, frames.poses);
    const MovingScenePool::Lease scene = pairs.borrowMovingScene();
    question.deadline = system::deadlineIn(budget);
    const TrajectorySearch search{
        {robot.robotModel(), &pairs.objects()}, pairs.asked(), points, segments, question, *scene};
    findContact(search, response);
    if (!request.skip_minimum) findMinima(search, response);
    if (response.status.code == QueryStatus::OK) response.status.message = beyondLimits(robot.robotModel(), points);
  });
}

}  // namespace proximity_server::node
