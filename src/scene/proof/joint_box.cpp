#include "proximity_server/scene/proof/joint_box.h"

#include "proximity_server/scene/files/file_value.h"
#include "proximity_server/scene/model/names.h"
#include "scene/files/field.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <stdexcept>

namespace proximity_server::scene {
namespace {

JointRange& intervalIn(JointBox& box, int joint) {
  const auto found =
      std::find_if(box.begin(), box.end(), [&](const JointRange& interval) { return interval.joint == joint; });
  return found != box.end() ? *found : box.emplace_back(JointRange{joint, 0.0, 0.0});
}

/// The joint of a member; refuses one that has no interval of its own.
int jointNamed(const std::string& name, const Field& field, const RobotModel& robot) {
  const int joint = findNamed(robot.joints, name);
  if (joint < 0) field.refuse("there is no movable joint " + unknownName(name, namesOf(robot.joints)));
  const Joint& found = robot.joints[joint];
  if (!hasOnePosition(found)) field.refuse(std::string("the joint is ") + toString(found.type));
  if (found.mimic) field.refuse("the joint follows " + quoted(robot.joints[found.mimic->joint].name));
  return joint;
}

}  // namespace

JointBox knownRanges(const RobotModel& robot) {
  std::set<int> unknown;
  for (int joint = 0; joint < static_cast<int>(robot.joints.size()); ++joint)
    if (!hasKnownRange(robot, joint)) unknown.insert(robot.leaderOf(joint).joint);
  JointBox box = jointRanges(robot);
  box.erase(std::remove_if(box.begin(), box.end(),
                           [&](const JointRange& interval) { return unknown.count(interval.joint) > 0; }),
            box.end());
  return box;
}

JointBox boxAbout(const RobotModel& robot, const Positions& state, const std::vector<double>& radii) {
  if (state.size() != robot.joints.size() || radii.size() != robot.joints.size())
    throw std::invalid_argument("the robot has " + std::to_string(robot.joints.size()) +
                                " movable joints, but there are " + std::to_string(state.size()) + " positions and " +
                                std::to_string(radii.size()) + " radii");
  JointBox about;
  for (const JointRange& range : jointRanges(robot)) {
    const Joint& joint = robot.joints[range.joint];
    const double position = state[range.joint], radius = radii[range.joint];
    if (!(radius >= 0.0) || !std::isfinite(radius))
      throw std::invalid_argument("joint " + quoted(joint.name) + ": its radius is " + shortest(radius) +
                                  ", but must be finite and not negative");
    const JointRange cut{range.joint, std::max(joint.lower, position - radius),
                         std::min(joint.upper, position + radius)};
    if (!std::isfinite(position) || cut.lower > cut.upper)
      throw std::invalid_argument("joint " + quoted(joint.name) + " is at " + shortest(position) +
                                  ", and its limits are " + shortest(joint.lower) + " and " + shortest(joint.upper));
    about.push_back(cut);
  }
  return about;
}

JointBox jointBoxFrom(const std::string& yaml, const std::string& source, const RobotModel& robot, JointBox box) {
  const FileValue value = readYaml(yaml, source);
  const Field file(value, source);
  for (const std::string& name : file.members()) {
    const Field member = file.member(name);
    JointRange& interval = intervalIn(box, jointNamed(name, member, robot));
    const bool turns = robot.joints[interval.joint].type != Joint::Type::Prismatic;
    const std::vector<Field> ends = member.isList() ? member.entries() : std::vector<Field>{member};
    if (member.isList() && ends.size() != 2) member.refuse("is neither a position nor [lower, upper]");
    interval.lower = ends.front().angle(turns);
    interval.upper = ends.back().angle(turns);
    if (interval.lower > interval.upper) member.refuse("is neither a position nor [lower, upper]");
  }
  return box;
}

}  // namespace proximity_server::scene
