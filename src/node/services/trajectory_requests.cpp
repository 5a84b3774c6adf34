#include "node/services/trajectory_requests.h"

#include "proximity_server/scene/model/names.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

namespace proximity_server::node {
namespace {

void requireInterpolation(const QueryTrajectoryRequest& request) {
  if (request.interpolation > QueryTrajectoryRequest::QUINTIC)
    refuse("interpolation " + std::to_string(request.interpolation) + " does not exist");
}

/// The values of the named joints, and 0 for all others.
scene::Positions orZero(const JointValues& values) {
  scene::Positions numbers;
  for (const std::optional<double>& value : values) numbers.push_back(value.value_or(0.0));
  return numbers;
}

scene::TrajectoryPoint pointOf(const scene::RobotModel& robot, const std::vector<int>& joints,
                               const trajectory_msgs::JointTrajectoryPoint& message, std::uint8_t interpolation,
                               const std::string& where) {
  const auto read = [&](const std::vector<double>& values, const std::string& what) {
    return orZero(valuesOf(robot, joints, values, what, where));
  };
  scene::TrajectoryPoint point{message.time_from_start.toSec(), read(message.positions, "position")};
  if (interpolation != QueryTrajectoryRequest::LINEAR && !message.velocities.empty())
    point.velocities = read(message.velocities, "velocity");
  if (interpolation == QueryTrajectoryRequest::QUINTIC && !message.accelerations.empty())
    point.accelerations = read(message.accelerations, "acceleration");
  return point;
}

/// The degree of the polynomial between two points, see scene::SplineSegment.
int degreeBetween(const scene::TrajectoryPoint& from, const scene::TrajectoryPoint& to) {
  if (from.velocities.empty() || to.velocities.empty()) return 1;
  return from.accelerations.empty() || to.accelerations.empty() ? 3 : 5;
}

}  // namespace

JointValues WayPoints::valuesAt(const scene::Positions& positions) const {
  JointValues values(positions.size());
  for (const int joint : joints) values[joint] = positions[joint];
  return completed(std::move(values), missing);
}

WayPoints wayPointsOf(const Robot& asked_robot, const trajectory_msgs::JointTrajectory& trajectory,
                      std::uint8_t interpolation) {
  const scene::RobotModel& robot = asked_robot.robotModel();
  WayPoints way;
  requireWithinBatch(asked_robot, "trajectory", trajectory.points.size(), "points");
  way.joints = jointsNamed(robot, trajectory.joint_names, "trajectory");
  for (const trajectory_msgs::JointTrajectoryPoint& message : trajectory.points) {
    const std::string where = "point " + std::to_string(way.points.size());
    if (!way.points.empty() && !(message.time_from_start.toSec() > way.points.back().time)) {
      refuse(where + ": its time_from_start is not later than that of the point before");
    }
    way.points.push_back(pointOf(robot, way.joints, message, interpolation, where));
  }
  return way;
}

WayPoints wayPointsOf(const Robot& robot, const QueryTrajectoryRequest& request) {
  const trajectory_msgs::JointTrajectory& trajectory = request.trajectory;
  const MissingJoints missing = missingJoints(request.missing_joints);
  requireInterpolation(request);
  if (trajectory.joint_names.empty()) refuse("the trajectory names no joints");
  if (trajectory.points.empty() && request.from_present_state) refuse("the trajectory has no points");
  if (trajectory.points.size() < 2 && !request.from_present_state) refuse("the trajectory has fewer than two points");
  WayPoints way = wayPointsOf(robot, trajectory, request.interpolation);
  way.missing = missing;
  if (!request.present_velocities.empty() && !request.from_present_state)
    refuse("present_velocities are given without from_present_state");
  return way;
}

WayPoints drivenFromPresent(const Robot& robot, const WayPoints& points, const JointSnapshot& from_tf,
                            const QueryTrajectoryRequest& request) {
  const scene::RobotModel& model = robot.robotModel();
  const auto first = std::find_if(points.points.begin(), points.points.end(),
                                  [](const scene::TrajectoryPoint& point) { return point.time > 0.0; });
  if (first == points.points.end()) refuse("no point of the trajectory is later than the present state, at time 0");
  scene::TrajectoryPoint start;
  start.positions.assign(model.joints.size(), 0.0);
  WayPoints driven = points;
  for (const int joint : points.joints) {
    start.positions[joint] = presentPosition(robot, joint, from_tf, first->positions[joint]);
    if (isTurnAssumed(robot, joint, from_tf, start.positions[joint])) driven.assumed.push_back(joint);
  }
  start.velocities.assign(model.joints.size(), 0.0);
  if (!request.present_velocities.empty())
    start.velocities =
        orZero(valuesOf(model, points.joints, request.present_velocities, "velocity", "present_velocities"));
  start.accelerations.assign(model.joints.size(), 0.0);
  driven.points = scene::drivenFrom(model, std::move(start), points.points);
  return driven;
}

std::vector<double> trackingErrorOf(const Robot& robot, const WayPoints& points,
                                    const QueryTrajectoryRequest& request) {
  const std::vector<double>& given = request.tracking_error;
  const std::vector<scene::Joint>& joints = robot.robotModel().joints;
  if (given.size() > 1 && given.size() != points.joints.size())
    refuse("tracking_error: there are " + std::to_string(given.size()) + " numbers for " +
           std::to_string(points.joints.size()) + " joints; give one for each of joint_names, or one for all");
  for (std::size_t i = 0; i < given.size(); ++i)
    if (!(std::isfinite(given[i]) && given[i] >= 0.0))
      refuse("tracking_error " + std::to_string(i) +
             (given.size() > 1 ? ", of joint '" + joints[points.joints[i]].name + "'," : std::string()) +
             " is not a number from 0 on");
  if (std::none_of(given.begin(), given.end(), [](double error) { return error > 0.0; })) return {};
  std::vector<double> errors(joints.size(), 0.0);
  for (std::size_t i = 0; i < points.joints.size(); ++i)
    errors[points.joints[i]] = given.size() == 1 ? given.front() : given[i];
  return errors;
}

std::string motionText(const Robot& robot, const WayPoints& points, const std::vector<double>& tracking_error,
                       const QueryTrajectoryRequest& request) {
  const int asked = 1 + 2 * request.interpolation;  // the degree
  int linear = 0, cubic = 0;
  for (std::size_t i = 0; i + 1 < points.points.size(); ++i) {
    const int degree = degreeBetween(points.points[i], points.points[i + 1]);
    linear += degree < asked && degree == 1;
    cubic += degree < asked && degree == 3;
  }
  std::string text =
      asked == 1 ? "the joints at constant velocity between the points"
                 : "the " + std::string(asked == 3 ? "cubic" : "quintic") + " splines of joint_trajectory_controller";
  const auto add = [&](int count, const std::string& degree, const std::string& lack) {
    if (count > 0)
      text += ", where " + std::to_string(count) + " of " + std::to_string(points.points.size() - 1) +
              " segments are " + degree + ", as a point has no " + lack;
  };
  add(linear, "linear", "velocities");
  add(cubic, "cubic", "accelerations");
  if (request.from_present_state) text += ", from the present state on";
  for (const int joint : points.assumed)
    text += ", where " + scene::quoted(robot.robotModel().joints[joint].name) + " is taken to be at " +
            scene::shortest(points.points.front().positions[joint]) +
            " rad, on the turn nearest to the first point: joint_states do not tell its turn";
  if (tracking_error.empty()) return text;
  text += ", and all motions about them with";
  for (std::size_t i = 0; i < points.joints.size(); ++i) {
    const scene::Joint& joint = robot.robotModel().joints[points.joints[i]];
    text += (i > 0 ? ", " : " ") + scene::quoted(joint.name) + " off by at most " +
            scene::shortest(tracking_error[points.joints[i]]) +
            (joint.type == scene::Joint::Type::Prismatic ? " m" : " rad");
  }
  return text;
}

}  // namespace proximity_server::node
