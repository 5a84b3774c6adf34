#include "tools/clearance/driven_motion.h"

#include "proximity_server/scene/files/file_value.h"
#include "proximity_server/scene/model/names.h"
#include "tools/robot/robot_files.h"
#include "tools/robot/robot_text.h"
#include "tools/states/csv_states.h"
#include "tools/states/state_options.h"
#include "tools/text/csv.h"
#include "tools/text/naming.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <string>
#include <string_view>
#include <variant>

namespace proximity_server::tools {
namespace {

using scene::FileValue;

constexpr char kOthers[] = "*";

/// A bound of every joint, or in degrees of those that turn.
using ErrorBound = system::PositionText;

/// nullopt if the text is neither a number nor an angle. Throws std::invalid_argument for one below 0.
std::optional<ErrorBound> boundIn(const std::string& text) {
  const std::optional<ErrorBound> bound = system::positionIn(text);
  const bool is_wrong = bound ? bound->value < 0.0 : numberIn<double>(text).has_value();  // not finite
  if (is_wrong) throw std::invalid_argument("'" + text + "' is not a number from 0 on");
  return bound;
}

[[noreturn]] void refuse(const FileValue& value, const std::string& what) {
  throw std::invalid_argument("line " + std::to_string(value.line) + ": " + what);
}

const FileValue* find(const FileValue& map, const std::string& name) {
  if (!std::holds_alternative<FileValue::Map>(map.content)) return nullptr;
  for (const FileValue::Member& member : std::get<FileValue::Map>(map.content))
    if (member.name == name) return &member.value;
  return nullptr;
}

// With a std::string& g++ 14 warns that the result may refer to a temporary text.
const FileValue::Map& mapIn(const FileValue& value, std::string_view what) {
  if (const auto* const map = std::get_if<FileValue::Map>(&value.content)) return *map;
  refuse(value, std::string(what) + " is not a map");
}

/// The constraints of a controller, in its namespace or not; nullptr if the file has none.
const FileValue* constraintsIn(const FileValue& file) {
  if (const FileValue* const constraints = find(file, "constraints")) return constraints;
  const FileValue::Map& members = mapIn(file, "the file");
  return members.size() == 1 ? find(members.front().value, "constraints") : nullptr;
}

ErrorBound boundOf(const FileValue& value, const std::string& joint) {
  std::optional<ErrorBound> bound;
  if (const auto* const number = std::get_if<double>(&value.content)) bound = ErrorBound{*number, false};
  if (const auto* const text = std::get_if<std::string>(&value.content)) bound = boundIn(*text);
  if (!bound || !(std::isfinite(bound->value) && bound->value >= 0.0))
    refuse(value, scene::quoted(joint) + ": not a number from 0 on, nor an angle like 0.5deg");
  return *bound;
}

/// `trajectory` of a joint in the constraints of a controller.
ErrorBound toleranceOf(const FileValue& constraint, const std::string& joint) {
  mapIn(constraint, scene::quoted(joint));
  const FileValue* const trajectory = find(constraint, "trajectory");
  const ErrorBound bound = trajectory ? boundOf(*trajectory, joint) : ErrorBound{0.0, false};
  if (!(bound.value > 0.0))
    refuse(constraint, scene::quoted(joint) + " has no `trajectory` above 0: the controller does not limit its error");
  return bound;
}

std::size_t leaderNamed(const scene::RobotModel& robot, const std::string& name, const FileValue& value) {
  const int joint = scene::findNamed(robot.joints, name);
  if (joint < 0) refuse(value, "there is no joint " + scene::unknownName(name, scene::namesOf(robot.joints)));
  if (robot.joints[joint].mimic)
    refuse(value, scene::quoted(name) + " follows " +
                      scene::quoted(robot.joints[robot.joints[joint].mimic->joint].name) + ", and so does its error");
  return static_cast<std::size_t>(joint);
}

std::vector<double> errorsIn(const FileValue& file, const scene::RobotModel& robot) {
  const FileValue* const constraints = constraintsIn(file);
  std::vector<double> errors(robot.joints.size(), 0.0);
  if (const FileValue* const others = constraints ? nullptr : find(file, kOthers))
    errors.assign(errors.size(), boundOf(*others, kOthers).value);
  for (const auto& [name, value] : mapIn(constraints ? *constraints : file, "constraints")) {
    const bool is_of_all = name == "goal_time" || name == "stopped_velocity_tolerance";
    if (constraints ? is_of_all : name == kOthers) continue;
    const std::size_t joint = leaderNamed(robot, name, value);
    const ErrorBound bound = constraints ? toleranceOf(value, name) : boundOf(value, name);
    if (bound.is_in_degrees && robot.joints[joint].type == scene::Joint::Type::Prismatic)
      refuse(value, scene::quoted(name) + " is prismatic: its error is in metres");
    errors[joint] = bound.value;
  }
  return errors;
}

/// Takes the prismatic joints to be exact, of which an angle says nothing. Returns a warning about each; `what` is
/// "error" or "uncertainty".
std::vector<std::string> makePrismaticExact(const scene::RobotModel& robot, const std::string& option,
                                            const std::string& what, std::vector<double>& of_joints) {
  std::vector<std::string> warnings;
  for (std::size_t i = 0; i < robot.joints.size(); ++i) {
    const scene::Joint& joint = robot.joints[i];
    if (joint.type != scene::Joint::Type::Prismatic || joint.mimic) continue;
    of_joints[i] = 0.0;
    warnings.push_back(option + ": joint " + scene::quoted(joint.name) +
                       " is prismatic and taken to be exact; a file states its " + what + " in metres.");
  }
  return warnings;
}

/// "a=1,b=-0.5" as a CSV with one row.
std::string csvOf(const std::string& state) {
  std::string names, numbers;
  std::istringstream entries(state);
  for (std::string entry; std::getline(entries, entry, ',');) {
    const std::size_t sign = entry.find('=');
    if (sign == std::string::npos || sign == 0) throw std::invalid_argument("'" + entry + "' is not JOINT=POSITION");
    names += (names.empty() ? "" : ",") + csvField(entry.substr(0, sign));
    numbers += (numbers.empty() ? "" : ",") + entry.substr(sign + 1);
  }
  return names + "\n" + numbers + "\n";
}

scene::TrajectoryPoint onlyStateOf(StateSource& states) {
  scene::TrajectoryPoint start, second;
  if (!states.next(start)) throw std::invalid_argument("there is no state");
  start.velocities.resize(start.positions.size());
  start.accelerations.assign(start.positions.size(), 0.0);
  if (states.next(second)) throw std::invalid_argument("there is more than one state");
  return start;
}

}  // namespace

TrackingError trackingErrorFrom(const std::string& text, const scene::RobotModel& robot) {
  const std::string option = "--tracking-error " + text;
  TrackingError error;
  if (const std::optional<ErrorBound> bound = naming(option, [&] { return boundIn(text); })) {
    error.of_joints.assign(robot.joints.size(), bound->value);
    if (bound->is_in_degrees) error.warnings = makePrismaticExact(robot, option, "error", error.of_joints);
  } else {
    const std::string yaml = naming("--tracking-error", [&] { return readTextFile(text); });
    error.of_joints = naming(text, [&] { return errorsIn(scene::readYaml(yaml, text), robot); });
  }
  const auto isSome = [](double most) { return most > 0.0; };
  if (std::none_of(error.of_joints.begin(), error.of_joints.end(), isSome)) error.of_joints.clear();
  return error;
}

JointUncertainty uncertaintyFrom(const std::string& text, const scene::RobotModel& robot) {
  const std::string option = "--joint-uncertainty " + text;
  const std::optional<ErrorBound> bound = system::positionIn(text);
  if (!bound)
    return {scene::uncertaintyFrom(naming("--joint-uncertainty", [&] { return readTextFile(text); }), text, robot)};
  JointUncertainty uncertainty{naming(option, [&] { return scene::uncertaintyOfJoints(robot, bound->value); })};
  if (bound->is_in_degrees)
    uncertainty.warnings = makePrismaticExact(robot, option, "uncertainty", uncertainty.of_robot.positions);
  return uncertainty;
}

scene::TrajectoryPoint startFrom(const std::string& text, const scene::RobotModel& robot) {
  return naming("--start " + text, [&] {
    if (text.find('=') != std::string::npos) {
      std::istringstream csv(csvOf(text));
      CsvStates states(csv, "the state", robot);
      return onlyStateOf(states);
    }
    StateOptions options;
    options.file = text;
    requireReadable(options);
    return onlyStateOf(*openStates(options, robot));
  });
}

}  // namespace proximity_server::tools
