#include "node/answers/conversions.h"
#include "node/answers/motions.h"
#include "node/answers/statuses.h"
#include "node/services/answered.h"
#include "node/services/motion_requests.h"
#include "node/services/queries.h"
#include "node/services/trajectory_requests.h"
#include "system/durations.h"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

namespace proximity_server::node {
namespace {

QueryTrajectoryResponse emptyQueryTrajectory() {
  QueryTrajectoryResponse response;
  response.t_free = response.t_contact = kNaN;
  response.segment = -1;
  response.pair = unknownProximity();
  return response;
}

/// The trajectory of a request, with the poses that tf adds to its points, and the frames of objects.
struct Trajectory {
  const Robot& robot;
  const RobotAndObjects model;
  const WayPoints& way;
  const JointSnapshot& from_tf;
  const CarrierFrames& frames;
  const scene::FramePoses& poses_of_frames;

  scene::BodyPoses posesAt(const scene::Positions& positions) const {
    return inReference(robot, posesInRoot(robot, way.valuesAt(positions), from_tf), from_tf.roots);
  }
  sensor_msgs::JointState stateAt(const scene::Positions& positions) const {
    sensor_msgs::JointState state;
    for (const int joint : way.joints) {
      state.name.push_back(robot.robotModel().joints[joint].name);
      state.position.push_back(positions[joint]);
    }
    return state;
  }
};

/// The motions between successive points; times count as in the trajectory.
std::vector<scene::Motion> motionsBetween(const Trajectory& trajectory, const std::vector<double>& tracking_error) {
  const std::vector<scene::TrajectoryPoint>& points = trajectory.way.points;
  std::vector<scene::Motion> motions;
  try {
    for (std::size_t i = 0; i + 1 < points.size(); ++i) {
      const scene::BodyPoses poses = trajectory.posesAt(points[i].positions);
      motions.emplace_back(trajectory.robot.robotModel(), inRoot(trajectory.robot, poses), points[i], points[i + 1],
                           tracking_error);
      motions.back().carryObjects(
          objectFramesInRoot(trajectory.robot, poses, trajectory.frames, trajectory.poses_of_frames));
    }
  } catch (const std::invalid_argument& error) {
    refuse(error.what());
  }
  return motions;
}

/// Searches segment by segment until a contact is found, or until the search of a segment is not complete.
void findContact(const std::vector<scene::Motion>& motions, const Trajectory& trajectory, const RequestedPairs& pairs,
                 scene::MotionSearch& search, const scene::MotionQuestion& question,
                 QueryTrajectoryResponse& response) {
  for (std::size_t i = 0; i < motions.size(); ++i) {
    const scene::Motion& motion = motions[i];
    const scene::RobotTimeOfContact found = search.timeOfContact(pairs.asked(), motion, question);
    require(completeness(found.counts));
    response.t_free = motion.timeAt(found.t_free);
    response.status = statusOfContact(found, response.t_free, question);
    response.contact = found.contact;
    response.may_touch = !found.contact && response.status.code != QueryStatus::OK;
    if (found.pair.result.status != narrowphase::Status::Unknown)
      response.pair =
          toMessage(trajectory.model, motion, found.contact ? found.t_contact : found.t_free, found.state, found.pair);
    if (found.contact) {
      response.t_contact = motion.timeAt(found.t_contact);
      response.segment = static_cast<std::int32_t>(i);
      response.state = trajectory.stateAt(found.state);
    }
    if (found.contact || response.status.code != QueryStatus::OK) return;
  }
}

void findMinima(const std::vector<scene::Motion>& motions, const Trajectory& trajectory, const RequestedPairs& pairs,
                scene::MotionSearch& search, const scene::MotionQuestion& question, QueryTrajectoryResponse& response) {
  response.segments.assign(motions.size(), unknownMinimum());
  for (std::size_t i = 0; i < motions.size(); ++i) {
    const scene::RobotMinimum found = search.minimum(pairs.asked(), motions[i], question);
    response.segments[i] = toMessage(trajectory.model, motions[i], found);
    const QueryStatus status = statusOf(found.status, question);
    if (status.code != QueryStatus::OK) {
      response.status = status;
      return;
    }
    response.segments_finished = static_cast<std::uint32_t>(i + 1);
  }
}

/// A warning that a joint is at a position beyond a limit.
std::string beyondText(const std::string& where, const scene::Joint& joint, double position, double limit) {
  std::ostringstream text;
  text << where << " joint '" << joint.name << "' is at " << position << ", its "
       << (position < limit ? "lower" : "upper") << " limit is " << limit;
  return text.str();
}

/// A warning about the first point of a trajectory at which a joint is beyond its limit, or which breaks an inequality;
/// "" if there is none. Between two points that break no inequality, none is broken.
std::string pointBeyondLimits(const Trajectory& trajectory) {
  const std::vector<scene::TrajectoryPoint>& points = trajectory.way.points;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const std::string where = "point " + std::to_string(i) + " is the first beyond a limit:";
    const std::string broken =
        brokenText(trajectory.robot, trajectory.way.valuesAt(points[i].positions), trajectory.from_tf);
    if (!broken.empty()) return where + " " + broken;
    for (const int index : trajectory.way.joints) {
      const scene::Joint& joint = trajectory.robot.robotModel().joints[index];
      const double position = points[i].positions[index];
      const double limit = position < joint.lower - kWritingError ? joint.lower : joint.upper;
      if (!joint.mimic && (position < joint.lower - kWritingError || position > joint.upper + kWritingError))
        return beyondText(where, joint, position, limit);
    }
  }
  return {};
}

/// The positions of the joints that a trajectory does not name; empty if no inequality needs them.
JointValues restingPositions(const Trajectory& trajectory) {
  if (trajectory.robot.robotModel().inequalities.empty()) return {};
  const JointValues unnamed(trajectory.robot.robotModel().joints.size());
  const scene::Positions positions =
      positionsOf(trajectory.robot, completed(unnamed, trajectory.way.missing), trajectory.from_tf);
  JointValues resting(positions.begin(), positions.end());
  for (const int joint : trajectory.way.joints) resting[joint].reset();
  return resting;
}

/// A warning about the first segment in which a joint of the trajectory is beyond its limit, or which breaks an
/// inequality; "" if there is none.
std::string segmentBeyondLimits(const Trajectory& trajectory) {
  const scene::RobotModel& robot = trajectory.robot.robotModel();
  const std::vector<int>& named = trajectory.way.joints;
  const JointValues resting = restingPositions(trajectory);
  const std::vector<scene::TrajectoryPoint>& points = trajectory.way.points;
  for (std::size_t i = 0; i + 1 < points.size(); ++i) {
    const scene::SplineSegment spline(robot, points[i], points[i + 1]);
    const std::string where = "segment " + std::to_string(i) + " is the first beyond a limit: at ";
    const auto broken = spline.brokenInequalities(robot, resting);
    if (!broken.empty())
      return where + system::secondsText(spline.timeAt(broken.front().time)) + " " +
             broken.front().inequality->brokenText(broken.front().excess);
    for (const scene::SplineSegment::Excess& excess : spline.beyondLimits(robot)) {
      const bool is_named = std::find(named.begin(), named.end(), excess.joint) != named.end();
      if (!is_named || !(std::abs(excess.position - excess.limit) > kWritingError)) continue;
      std::ostringstream time;
      time << spline.timeAt(excess.time) << " s";
      return beyondText(where + time.str(), robot.joints[excess.joint], excess.position, excess.limit);
    }
  }
  return {};
}

/// The transforms that the points leave to tf. Those of the joints of the points are looked up for the present state.
JointSnapshot awaitTf(const Robot& robot, TfPoses& tf, const RequestedPairs& pairs, const WayPoints& way,
                      const QueryTrajectoryRequest& request) {
  const std::vector<JointValues> given{way.valuesAt(way.points.front().positions)};  // the same joints in all points
  std::vector<int> joints = coupledJoints(robot.robotModel(), given);
  if (request.from_present_state) joints.insert(joints.end(), way.joints.begin(), way.joints.end());
  return missingFromTf(robot, tf, pairs.bodies(), given, request.stamp, joints);
}

}  // namespace

QueryTrajectoryResponse answer(const Robot& robot, TfPoses& tf, const QueryTrajectoryRequest& request) {
  return answered(emptyQueryTrajectory(), [&](QueryTrajectoryResponse& response) {
    scene::LevelThresholds thresholds;  // known with the objects
    scene::MotionQuestion question = motionQuestion(request.contact_distance, request.tolerance, thresholds.stop);
    const double budget = timeBudget(robot, request.time_budget);
    const auto pairs = pairsOf(robot, request.a, request.b, filterOf(request.ignore_filter));
    thresholds = robot.thresholdsWith(pairs.objects());
    WayPoints way = wayPointsOf(robot, request);
    const std::vector<double> tracking_error = trackingErrorOf(robot, way, request);
    const JointSnapshot from_tf = awaitTf(robot, tf, pairs, way, request);
    response.header.stamp = from_tf.stamp;
    response.header.frame_id = robot.referenceFrame();
    require(from_tf.status);
    if (request.from_present_state) way = drivenFromPresent(robot, way, from_tf, request);
    const CarrierFrames frames = pairs.frames();
    const FrameSnapshot objects = framesFromTf(robot, tf, frames, from_tf, request.stamp);
    require(objects.status);
    const Trajectory trajectory{robot, {robot.robotModel(), &pairs.objects()}, way, from_tf, frames, objects.poses};
    const std::vector<scene::Motion> motions = motionsBetween(trajectory, tracking_error);
    const ScenePool::Lease scenes = pairs.borrowScenes();
    question.deadline = system::deadlineIn(budget);
    findContact(motions, trajectory, pairs, scenes->motions(), question, response);
    if (!request.skip_minimum) findMinima(motions, trajectory, pairs, scenes->motions(), question, response);
    const bool are_straight = request.interpolation == QueryTrajectoryRequest::LINEAR && tracking_error.empty();
    if (response.status.code == QueryStatus::OK)
      response.status.message = are_straight ? pointBeyondLimits(trajectory) : segmentBeyondLimits(trajectory);
    response.certified = motionText(robot, way, tracking_error, request);
  });
}

}  // namespace proximity_server::node
