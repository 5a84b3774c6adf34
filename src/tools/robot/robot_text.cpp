#include "tools/robot/robot_text.h"

#include "tools/text/csv.h"

#include <nlohmann/json.hpp>

#include <array>
#include <cstdio>

namespace proximity_server::tools {
namespace {

/// Floating and planar joints have no single position.
std::string unitOf(const scene::Joint& joint) {
  if (!scene::hasOnePosition(joint)) return "";
  return joint.type == scene::Joint::Type::Prismatic ? "m" : "rad";
}

}  // namespace

std::string jointList(const scene::RobotModel& robot) {
  std::string text = "joint,type,lower,upper,unit,mimic\n";
  for (const scene::Joint& joint : robot.joints) {
    const std::string leader = joint.mimic ? robot.joints[joint.mimic->joint].name : "";
    for (const std::string& field : {csvField(joint.name), std::string(toString(joint.type)), shortest(joint.lower),
                                     shortest(joint.upper), unitOf(joint)})
      text += field + ",";
    text += csvField(leader) + "\n";
  }
  return text;
}

nlohmann::ordered_json positionsJson(const scene::RobotModel& robot, const scene::Positions& positions) {
  nlohmann::ordered_json named = nlohmann::ordered_json::object();
  for (const scene::JointRange& range : scene::jointRanges(robot))
    named[robot.joints[range.joint].name] = positions[range.joint];
  return named;
}

std::string stateText(const scene::RobotModel& robot, const scene::ShapeRefPair& pair,
                      const scene::Positions& positions) {
  std::string text;
  for (const scene::JointRange& range :
       scene::rangesBetween(robot, scene::jointRanges(robot), pair.a.link(), pair.b.link())) {
    text += (text.empty() ? "" : " ") + robot.joints[range.joint].name + "=" + shortest(positions[range.joint]);
  }
  return text;
}

std::string lengthText(double length) {
  std::array<char, 32> text;
  std::snprintf(text.data(), text.size(), "%.3g m", length);
  return text.data();
}

}  // namespace proximity_server::tools
