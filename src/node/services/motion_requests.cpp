#include "node/services/motion_requests.h"

#include "node/services/joint_requests.h"
#include "proximity_server/scene/model/kinematics.h"
#include "system/durations.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>

namespace proximity_server::node {
namespace {

using Twist = scene::RobotMotion::Twist;

Eigen::Vector3d toEigen(const geometry_msgs::Vector3& vector) { return {vector.x, vector.y, vector.z}; }

/// Converts the twist of a link into the twist of its body. The two differ in the point whose linear velocity they
/// have.
Twist twistOfBody(const scene::Link& link, const Eigen::Isometry3d& body_pose, const geometry_msgs::Twist& twist) {
  const Eigen::Vector3d angular = toEigen(twist.angular);
  const Eigen::Vector3d link_to_body = -(body_pose.linear() * link.body_T_link.translation());
  return {toEigen(twist.linear) + angular.cross(link_to_body), angular};
}

bool isRest(const Twist& twist) { return twist.linear.isZero(0.0) && twist.angular.isZero(0.0); }

/// Returns whether two twists of one body may move a point within one metre of its origin, during `horizon` [s], to
/// places that are more than `tolerance` [m] apart.
bool disagree(const Twist& a, const Twist& b, double horizon, double tolerance) {
  return ((a.linear - b.linear).norm() + (a.angular - b.angular).norm()) * horizon > tolerance;
}

int bodyOfReference(const Robot& robot) {
  return robot.referenceLink() < 0 ? -1 : robot.robotModel().links[robot.referenceLink()].body;
}

/// The twists [m/s, rad/s] of all bodies, as a request describes them.
class BodyTwists {
 public:
  BodyTwists(const Robot& robot, const scene::BodyPoses& poses, const FirstContactRequest& request)
      : robot_(robot), poses_(poses), request_(request), named_by_(poses.size()), twists_(poses.size()) {
    for (std::size_t i = 0; i < request.links.size(); ++i) add(request.links[i], request.twists[i]);
  }

  const std::vector<Twist>& all() const { return twists_; }

 private:
  void add(const std::string& name, const geometry_msgs::Twist& message) {
    const scene::Link& link = robot_.robotModel().links[linkNamed(robot_.robotModel(), name)];
    if (!toEigen(message.linear).allFinite() || !toEigen(message.angular).allFinite()) {
      refuse("the twist of link '" + name + "' is not finite");
    }
    const auto body = static_cast<std::size_t>(link.body);
    if (!poses_[body]) return;  // no requested pair needs this body
    const Twist twist = twistOfBody(link, *poses_[body], message);
    if (link.body == bodyOfReference(robot_) && !isRest(twist)) {
      refuse("link '" + name + "' carries the frame '" + robot_.referenceFrame() +
             "' to which twists are relative: it rests");
    }
    const double tolerance = request_.tolerance > 0.0 ? request_.tolerance : scene::MotionQuestion().tolerance;
    if (!named_by_[body].empty() && disagree(twists_[body], twist, request_.horizon, tolerance)) {
      refuse("the twists of '" + named_by_[body] + "' and '" + name + "' disagree: fixed joints join the two");
    }
    named_by_[body] = name;
    twists_[body] = twist;
  }

  const Robot& robot_;
  const scene::BodyPoses& poses_;
  const FirstContactRequest& request_;
  std::vector<std::string> named_by_;
  std::vector<Twist> twists_;
};

scene::Motion motionOfTwists(const Robot& robot, const scene::BodyPoses& poses, const FirstContactRequest& request) {
  std::vector<Twist> twists = BodyTwists(robot, poses, request).all();
  for (Twist& twist : twists) {
    twist = {twist.linear * request.horizon, twist.angular * request.horizon};
    if (!(twist.linear + twist.angular).allFinite()) refuse("twists: a velocity times the horizon is not finite");
  }
  scene::Motion motion = scene::RobotMotion::ofTwists(poses, twists);
  motion.setTime(0.0, request.horizon);
  return motion;
}

/// The positions [rad] or [m] in the request, or else those that joint_states tell. NaN in the request means that a
/// position is not known.
JointValues statedPositions(const scene::RobotModel& robot, const std::vector<int>& joints,
                            const std::vector<double>& positions, JointValues stated) {
  if (positions.empty()) return stated;
  if (positions.size() != joints.size()) {
    refuse("joints: " + std::to_string(positions.size()) + " positions for " + std::to_string(joints.size()) +
           " names; there may be none");
  }
  stated.resize(robot.joints.size());
  for (std::size_t i = 0; i < joints.size(); ++i) {
    if (std::isinf(positions[i]))
      refuse("joints: the position of joint '" + robot.joints[joints[i]].name + "' is not finite");
    if (!std::isnan(positions[i])) stated[joints[i]] = positions[i];
  }
  return stated;
}

RequestedMotion motionOfJoints(const Robot& robot, const PoseSnapshot& start, const FirstContactRequest& request) {
  const std::vector<int> joints = jointsNamed(robot.robotModel(), request.joints.name, "joints");
  const JointValues stated = statedPositions(robot.robotModel(), joints, request.joints.position, start.stated);
  const JointValues velocities = valuesOf(robot.robotModel(), joints, request.joints.velocity, "velocity", "joints");
  std::vector<double> travel;
  for (const std::optional<double>& velocity : velocities) {
    travel.push_back(finite(velocity.value_or(0.0) * request.horizon, "joints: a velocity times the horizon"));
  }
  try {
    scene::LimitedMotion limited = motionWithinLimits(robot, start.poses, travel, stated, request.horizon);
    std::string text = limitsText(robot.robotModel(), start.poses, stated, limited, request.horizon);
    return {std::move(limited), std::move(text)};
  } catch (const std::invalid_argument& error) {  // a stated position is too far beyond the limits of its joint
    refuse(std::string("joints: ") + error.what());
  }
}

}  // namespace

scene::MotionQuestion motionQuestion(double contact_distance, double tolerance, const scene::PairDistances& stop) {
  scene::MotionQuestion question;
  if (std::isnan(contact_distance))
    question.thresholds = &stop;
  else
    question.contact_distance = notNegative(contact_distance, "contact_distance");
  if (notNegative(tolerance, "tolerance") > 0.0) question.tolerance = tolerance;
  return question;
}

double timeBudget(const Robot& robot, const ros::Duration& asked) {
  const double budget = notNegative(asked.toSec(), "time_budget");
  const double longest = robot.config().max_request_time;
  if (budget > longest) {
    throw RequestError(QueryStatus::OVER_BUDGET, "time_budget is " + system::secondsText(budget) +
                                                     ", max_request_time is " + system::secondsText(longest));
  }
  return budget > 0.0 ? budget : std::min(robot.config().motion_time_budget, longest);
}

RequestedMotion motionOf(const Robot& robot, const PoseSnapshot& start, const CarrierFrames& frames,
                         const scene::FramePoses& poses_of_frames, const FirstContactRequest& request) {
  if (request.links.size() != request.twists.size()) refuse("links and twists must have the same length");
  const bool are_joints = !request.joints.name.empty();
  if (request.links.empty() && !are_joints) refuse("nothing moves: name links with twists, or joints");
  if (!request.links.empty() && are_joints) refuse("name links with twists, or joints, not both");
  RequestedMotion motion = are_joints ? motionOfJoints(robot, start, request)
                                      : RequestedMotion{{{}, motionOfTwists(robot, start.poses, request)}, {}};
  motion.limited.motion.carryObjects(
      are_joints ? objectFramesInRoot(robot, start.poses, frames, poses_of_frames)
                 : scene::RobotMotion::ObjectFrames{{-1, true, {}}, framesOfObjects(robot, frames, poses_of_frames)});
  return motion;
}

}  // namespace proximity_server::node
