#include "node/services/joint_requests.h"

#include "proximity_server/QueryConfigurationRequest.h"
#include "proximity_server/scene/model/kinematics.h"
#include "proximity_server/scene/model/names.h"
#include "proximity_server/scene/motion/limited_motion.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace proximity_server::node {
namespace {

constexpr double kWholeTurn = 2.0 * 3.14159265358979323846;

int jointNamed(const scene::RobotModel& robot, const std::string& name, const std::string& where) {
  const int index = scene::findNamed(robot.joints, name);
  if (index < 0) {
    if (std::count(robot.fixed_joints.begin(), robot.fixed_joints.end(), name) > 0) {
      refuse(where + ": " + "joint '" + name + "' is fixed");
    }
    refuse(where + ": " + "there is no joint '" + name + "'" + scene::didYouMean(name, scene::namesOf(robot.joints)));
  }
  if (!scene::hasOnePosition(robot.joints[index])) {
    refuse(where + ": " + "joint '" + name + "' is floating or planar, it has not one position");
  }
  return index;
}

}  // namespace

std::vector<int> jointsNamed(const scene::RobotModel& robot, const std::vector<std::string>& names,
                             const std::string& where) {
  std::vector<int> joints;
  for (const std::string& name : names) {
    const int joint = jointNamed(robot, name, where);
    if (std::count(joints.begin(), joints.end(), joint) > 0)
      refuse(where + ": " + "joint '" + name + "' is named twice");
    joints.push_back(joint);
  }
  return joints;
}

JointValues valuesOf(const scene::RobotModel& robot, const std::vector<int>& joints, const std::vector<double>& values,
                     const std::string& what, const std::string& where) {
  const auto nameOf = [&](std::size_t i) { return robot.joints[joints[i]].name; };
  if (values.size() < joints.size()) refuse(where + ": " + "joint '" + nameOf(values.size()) + "' has no " + what);
  if (values.size() > joints.size()) {
    refuse(where + ": " + "one " + what + " too many for " + std::to_string(joints.size()) + " joints" +
           (joints.empty() ? "" : ", after that of joint '" + nameOf(joints.size() - 1) + "'"));
  }
  JointValues result(robot.joints.size());
  for (std::size_t i = 0; i < joints.size(); ++i) {
    if (!std::isfinite(values[i])) refuse(where + ": " + "the " + what + " of joint '" + nameOf(i) + "' is not finite");
    result[joints[i]] = values[i];
  }
  return result;
}

MissingJoints missingJoints(std::uint8_t code) {
  switch (code) {
    case QueryConfigurationRequest::FROM_TF:
      return MissingJoints::FromTf;
    case QueryConfigurationRequest::ZERO:
      return MissingJoints::AtZero;
    default:
      refuse("missing_joints " + std::to_string(code) + " does not exist");
  }
}

JointValues completed(JointValues positions, MissingJoints missing) {
  if (missing == MissingJoints::FromTf) return positions;
  for (std::optional<double>& position : positions) position = position.value_or(0.0);
  return positions;
}

JointSnapshot missingFromTf(const Robot& robot, TfPoses& tf, const std::vector<int>& bodies,
                            const std::vector<JointValues>& states, const ros::Time& stamp,
                            const std::vector<int>& joints) {
  const int joint_count = static_cast<int>(robot.robotModel().joints.size());
  std::vector<int> missing = joints;
  for (const int edge : edgesTo(robot, bodies)) {
    const auto lacks_position = [&](const JointValues& state) { return !hasPosition(robot.robotModel(), edge, state); };
    if (edge >= joint_count || std::any_of(states.begin(), states.end(), lacks_position)) missing.push_back(edge);
  }
  std::sort(missing.begin(), missing.end());
  missing.erase(std::unique(missing.begin(), missing.end()), missing.end());
  if (!missing.empty()) return tf.awaitJoints(robot, missing, stamp);
  JointSnapshot nothing;
  nothing.joints.resize(robot.robotModel().joints.size());
  nothing.stated.resize(robot.robotModel().joints.size());
  nothing.roots.resize(robot.robotModel().robots.size());
  return nothing;
}

FrameSnapshot framesFromTf(const Robot& robot, TfPoses& tf, CarrierFrames frames, const JointSnapshot& joints,
                           const ros::Time& stamp) {
  const auto is_link = [&](int index) { return robot.linkOfFrame(frames.names[index]) >= 0; };
  frames.needed.erase(std::remove_if(frames.needed.begin(), frames.needed.end(), is_link), frames.needed.end());
  PoseSnapshot robot_poses;
  robot_poses.stamp = joints.stamp.isZero() ? ros::Time::now() : joints.stamp;
  return tf.awaitFrames(robot, frames, robot_poses, stamp);
}

double onTurnNearestTo(double next, double position, const scene::Joint& joint) {
  if (joint.type != scene::Joint::Type::Revolute) return position;
  const double nearest = next + std::remainder(position - next, kWholeTurn);
  const auto excess = [&](double candidate) {
    const double beyond = std::max(joint.lower - candidate, candidate - joint.upper);
    return beyond <= scene::kBeyondLimit ? 0.0 : beyond;
  };
  double best = nearest;
  for (const double candidate : {nearest - kWholeTurn, nearest + kWholeTurn})
    if (excess(candidate) < excess(best)) best = candidate;
  return best;
}

double presentPosition(const Robot& robot, int index, const JointSnapshot& from_tf, double next) {
  if (from_tf.stated[index]) return *from_tf.stated[index];
  const double position = positionAt(robot.robotModel(), index, from_tf.joints[index].value());
  return onTurnNearestTo(next, position, robot.robotModel().joints[index]);
}

bool isTurnAssumed(const Robot& robot, int index, const JointSnapshot& from_tf, double position) {
  const scene::Joint& joint = robot.robotModel().joints[index];
  if (joint.type != scene::Joint::Type::Revolute || from_tf.stated[index]) return false;
  return position - kWholeTurn >= joint.lower - scene::kBeyondLimit ||
         position + kWholeTurn <= joint.upper + scene::kBeyondLimit;
}

std::vector<int> coupledJoints(const scene::RobotModel& robot, const std::vector<JointValues>& states) {
  std::vector<int> joints;
  for (const JointValues& state : states)
    for (const scene::JointInequality& inequality : robot.inequalities) {
      const auto is_given = [&](const scene::JointInequality::Term& term) { return state[term.joint].has_value(); };
      if (std::none_of(inequality.terms.begin(), inequality.terms.end(), is_given)) continue;
      for (const scene::JointInequality::Term& term : inequality.terms)
        if (!is_given(term)) joints.push_back(term.joint);
    }
  return joints;
}

scene::Positions positionsOf(const Robot& robot, const JointValues& given, const JointSnapshot& from_tf) {
  scene::Positions positions;
  for (std::size_t i = 0; i < given.size(); ++i) {
    const bool is_in_tf = scene::hasOnePosition(robot.robotModel().joints[i]) && from_tf.joints[i];
    positions.push_back(given[i]   ? *given[i]
                        : is_in_tf ? presentPosition(robot, static_cast<int>(i), from_tf, 0.0)
                                   : std::numeric_limits<double>::quiet_NaN());
  }
  return positions;
}

std::string brokenText(const Robot& robot, const JointValues& given, const JointSnapshot& from_tf) {
  if (robot.robotModel().inequalities.empty()) return {};
  const scene::Positions positions = positionsOf(robot, given, from_tf);
  const scene::JointInequality* const broken = mostBroken(robot.robotModel().inequalities, positions);
  return broken ? broken->brokenText(broken->excess(positions)) : "";
}

scene::BodyPoses posesInRoot(const Robot& robot, const JointValues& positions, const JointSnapshot& from_tf) {
  return posesInRoot(robot.robotModel(), framesAt(robot.robotModel(), positions, from_tf.joints));
}

}  // namespace proximity_server::node
