#include "tools/states/joint_columns.h"

#include "proximity_server/scene/model/names.h"
#include "tools/text/csv.h"
#include "tools/text/naming.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace proximity_server::tools {
namespace {

std::string suggestion(const scene::RobotModel& robot, const std::string& name) {
  const std::string nearest = scene::nearestName(name, scene::namesOf(robot.joints));
  return nearest.empty() ? "" : " (did you mean " + scene::quoted(nearest) + "?)";
}

bool isFixed(const scene::RobotModel& robot, const std::string& name) {
  return std::count(robot.fixed_joints.begin(), robot.fixed_joints.end(), name) > 0;
}

JointColumn columnOf(const std::string& name, const scene::RobotModel& robot) {
  using Quantity = JointColumn::Quantity;
  const bool is_joint = scene::findNamed(robot.joints, name) >= 0 || isFixed(robot, name);
  if (name == "time" && !is_joint) return {name, -1, Quantity::Time};
  const auto jointOf = [&](const std::string& joint) {
    return naming("column " + scene::quoted(name), [&] { return jointWithPosition(joint, robot); });
  };
  for (const Quantity quantity : {Quantity::Velocity, Quantity::Acceleration}) {
    const std::string suffix = suffixOf(quantity);
    if (is_joint || name.size() <= suffix.size()) continue;
    const std::size_t length = name.size() - suffix.size();
    if (name.compare(length, suffix.size(), suffix) == 0) return {name, jointOf(name.substr(0, length)), quantity};
  }
  return {name, jointOf(name)};
}

constexpr double kPi = 3.14159265358979323846;

std::string placeText(std::uint64_t state, long line) {
  return "state " + std::to_string(state) + (line > 0 ? ", line " + std::to_string(line) : "");
}

bool isBeyond(const scene::Joint& joint, double position) {
  return position < joint.lower - kLimitRounding || position > joint.upper + kLimitRounding;
}

}  // namespace

const char* suffixOf(JointColumn::Quantity quantity) {
  switch (quantity) {
    case JointColumn::Quantity::Velocity:
      return ".velocity";
    case JointColumn::Quantity::Acceleration:
      return ".acceleration";
    case JointColumn::Quantity::Position:
    case JointColumn::Quantity::Time:
      break;
  }
  return "";
}

int jointWithPosition(const std::string& name, const scene::RobotModel& robot) {
  const int joint = scene::findNamed(robot.joints, name);
  if (joint < 0 && isFixed(robot, name)) throw std::invalid_argument("a fixed joint has no position");
  if (joint < 0) throw std::invalid_argument("no such joint" + suggestion(robot, name));
  if (!scene::hasOnePosition(robot.joints[joint]))
    throw std::invalid_argument("a floating or planar joint has more than one position");
  return joint;
}

std::string whyNotUsed(const scene::RobotModel& robot, int joint) {
  const auto& mimic = robot.joints[joint].mimic;
  return mimic ? "the joint follows " + scene::quoted(robot.joints[mimic->joint].name) : "";
}

std::vector<JointColumn> jointColumns(const std::vector<std::string>& names, const scene::RobotModel& robot) {
  std::vector<JointColumn> columns;
  for (const std::string& name : names) {
    const auto hasName = [&](const JointColumn& column) { return column.name == name; };
    if (std::any_of(columns.begin(), columns.end(), hasName))
      throw std::invalid_argument("two columns are named " + scene::quoted(name));
    columns.push_back(columnOf(name, robot));
  }
  return columns;
}

void LimitCheck::beginState(std::uint64_t state, long line) {
  ++states_;
  state_ = state;
  line_ = line;
  is_beyond_ = false;
}

void LimitCheck::add(int joint, double position) {
  const scene::Joint& limits = robot_.joints[joint];
  if (limits.mimic || !isBeyond(limits, position)) return;
  if (!is_beyond_) ++states_beyond_;
  is_beyond_ = true;
  joints_.insert(joint);
  if (!first_) first_ = Violation{state_, line_, joint, position};
  if (limits.type != scene::Joint::Type::Revolute) return;
  largest_angle_ = std::max(largest_angle_, std::abs(position));
  would_be_within_as_degrees_ = would_be_within_as_degrees_ && !isBeyond(limits, position * kPi / 180.0);
}

void LimitCheck::endState(const std::vector<double>& positions) {
  const scene::JointInequality* const broken = scene::mostBroken(robot_.inequalities, positions);
  if (!broken || states_breaking_++ > 0) return;
  first_break_ = placeText(state_, line_) + ": " + broken->brokenText(broken->excess(positions)) + ".";
}

/// Positions look like degrees only if one exceeds a full turn, which hardly any joint makes.
bool LimitCheck::looksLikeDegrees() const { return largest_angle_ > 2.0 * kPi && would_be_within_as_degrees_; }

std::string LimitCheck::warning(const std::string& source) const {
  const std::string limits = limitsText(source), inequalities = inequalitiesText(source);
  return limits + (limits.empty() || inequalities.empty() ? "" : " ") + inequalities;
}

std::string LimitCheck::inequalitiesText(const std::string& source) const {
  if (states_breaking_ == 0) return "";
  return source + ": " + std::to_string(states_breaking_) + " of " + std::to_string(states_) +
         " states break a joint inequality. The first is " + first_break_;
}

std::string LimitCheck::limitsText(const std::string& source) const {
  if (!first_) return "";
  const scene::Joint& joint = robot_.joints[first_->joint];
  const std::string unit = joint.type == scene::Joint::Type::Prismatic ? " m" : " rad";
  std::string text = source + ": " + std::to_string(states_beyond_) + " of " + std::to_string(states_) +
                     " states are beyond the limits of a joint. The first is " +
                     placeText(first_->state, first_->line) + ": \"" + joint.name + "\" is at " +
                     shortest(first_->position) + unit + ", its limits are " + shortest(joint.lower) + " and " +
                     shortest(joint.upper) + unit + ".";
  if (joints_.size() > 1) {
    text += " All joints that are:";
    for (const int each : joints_)
      text += (each == *joints_.begin() ? " " : ", ") + scene::quoted(robot_.joints[each].name);
    text += ".";
  }
  if (looksLikeDegrees()) {
    text +=
        " These look like degrees, which are the usual cause: as such, all angles would be within their limits. "
        "Positions are in radians.";
  }
  return text;
}

}  // namespace proximity_server::tools
