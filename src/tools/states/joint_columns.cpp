#include "tools/states/joint_columns.h"

#include <algorithm>
#include <stdexcept>

#include "proximity_server/scene/model/names.h"

namespace proximity_server::tools {
namespace {

std::string suggestion(const scene::RobotModel& robot, const std::string& name) {
  std::vector<std::string> known;
  for (const scene::Joint& joint : robot.joints) known.push_back(joint.name);
  const std::string nearest = scene::nearestName(name, known);
  return nearest.empty() ? "" : " (did you mean " + inQuotes(nearest) + "?)";
}

bool isFixed(const scene::RobotModel& robot, const std::string& name) {
  return std::count(robot.fixed_joints.begin(), robot.fixed_joints.end(), name) > 0;
}

/// Index of a joint, or -1.
int findJoint(const scene::RobotModel& robot, const std::string& name) {
  const auto hit = std::find_if(robot.joints.begin(), robot.joints.end(),
                                [&](const scene::Joint& joint) { return joint.name == name; });
  return hit == robot.joints.end() ? -1 : static_cast<int>(hit - robot.joints.begin());
}

/// The joint of a column, or kTime.
int jointOf(const std::string& name, const scene::RobotModel& robot) {
  if (name == "time" && findJoint(robot, name) < 0 && !isFixed(robot, name)) return JointColumn::kTime;
  try {
    return jointWithPosition(name, robot);
  } catch (const std::invalid_argument& error) {
    throw std::invalid_argument("column " + inQuotes(name) + ": " + error.what());
  }
}

}  // namespace

std::string inQuotes(const std::string& name) { return '"' + name + '"'; }

int jointWithPosition(const std::string& name, const scene::RobotModel& robot) {
  const int joint = findJoint(robot, name);
  if (joint < 0 && isFixed(robot, name)) throw std::invalid_argument("a fixed joint has no position");
  if (joint < 0) throw std::invalid_argument("no such joint" + suggestion(robot, name));
  if (!scene::hasOnePosition(robot.joints[joint]))
    throw std::invalid_argument("a floating or planar joint has more than one position");
  return joint;
}

std::string whyNotUsed(const scene::RobotModel& robot, int joint) {
  const auto& mimic = robot.joints[joint].mimic;
  return mimic ? "the joint follows " + inQuotes(robot.joints[mimic->joint].name) : "";
}

std::vector<JointColumn> jointColumns(const std::vector<std::string>& names, const scene::RobotModel& robot) {
  std::vector<JointColumn> columns;
  for (const std::string& name : names) {
    const auto hasName = [&](const JointColumn& column) { return column.name == name; };
    if (std::any_of(columns.begin(), columns.end(), hasName))
      throw std::invalid_argument("two columns are named " + inQuotes(name));
    columns.push_back({name, jointOf(name, robot)});
  }
  return columns;
}

bool hasTime(const std::vector<JointColumn>& columns) {
  return std::any_of(columns.begin(), columns.end(),
                     [](const JointColumn& column) { return column.joint == JointColumn::kTime; });
}

std::vector<std::string> unusedColumns(const std::vector<JointColumn>& columns, const scene::RobotModel& robot) {
  std::vector<std::string> sentences;
  for (const JointColumn& column : columns) {
    const std::string reason = column.joint == JointColumn::kTime ? "" : whyNotUsed(robot, column.joint);
    if (!reason.empty()) sentences.push_back("column " + inQuotes(column.name) + " is not used: " + reason + ".");
  }
  return sentences;
}

std::string notFinite(const std::string& column, const std::string& number) {
  return "column " + inQuotes(column) + ": " + inQuotes(number) + " is no finite number";
}

}  // namespace proximity_server::tools
