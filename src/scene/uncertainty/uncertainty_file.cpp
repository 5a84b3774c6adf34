#include "proximity_server/scene/files/file_value.h"
#include "proximity_server/scene/model/names.h"
#include "proximity_server/scene/uncertainty/uncertainty.h"
#include "scene/files/field.h"

#include <algorithm>
#include <stdexcept>

namespace proximity_server::scene {
namespace {

bool isNumber(const Field& field) { return !field.isMap(); }

bool isPose(const Field& field) {
  if (!field.isMap()) return true;
  const std::vector<std::string> names = field.members();
  return std::all_of(names.begin(), names.end(),
                     [](const std::string& name) { return name == "translation" || name == "angle"; });
}

/// A length, an angle, or a bound of what turns or does not.
double boundIn(const Field& field, bool turns) {
  const double bound = field.angle(turns);
  if (bound < 0.0) field.refuse("must not be negative");
  return bound;
}

double lengthIn(const Field& field) { return boundIn(field, false); }

double boundOf(const Joint& joint, const Field& field) { return boundIn(field, joint.type != Joint::Type::Prismatic); }

PoseUncertainty poseIn(const Field& field) {
  if (!field.isMap()) return {lengthIn(field), 0.0};
  field.requireMembers({"translation", "angle"});
  PoseUncertainty pose;
  if (const auto translation = field.find("translation")) pose.translation = lengthIn(*translation);
  if (const auto angle = field.find("angle")) pose.angle = boundIn(*angle, true);
  return pose;
}

/// Reads one value for all names, as `isOne(field)` tells, or a map with values of some. `set(name, value)` is called
/// with kOthers first.
template <typename IsOne, typename Set>
void readByName(const std::optional<Field>& field, const IsOne& isOne, const Set& set) {
  if (!field) return;
  if (isOne(*field)) return set(kOthers, *field);
  if (const auto others = field->find(kOthers)) set(kOthers, *others);
  for (const std::string& name : field->members())
    if (name != kOthers) set(name, field->member(name));
}

/// The place of a name in a list.
std::size_t placeOf(const std::string& name, const std::vector<std::string>& names, const std::string& kind,
                    const Field& field) {
  const auto place = std::find(names.begin(), names.end(), name);
  if (place == names.end()) field.refuse("there is no " + kind + " " + unknownName(name, names));
  return static_cast<std::size_t>(place - names.begin());
}

template <typename Value, typename IsOne, typename Read>
void readList(const std::optional<Field>& field, const IsOne& isOne, const std::vector<std::string>& names,
              const std::string& kind, const Read& read, std::vector<Value>& values) {
  readByName(field, isOne, [&](const std::string& name, const Field& value) {
    if (name == kOthers)
      std::fill(values.begin(), values.end(), read(value));
    else
      values[placeOf(name, names, kind, value)] = read(value);
  });
}

/// One bound for all joints, or a map with bounds of some.
std::vector<double> positionsIn(const Field& field, const RobotModel& robot) {
  std::vector<double> positions(robot.joints.size(), 0.0);
  const std::optional<Field> others = field.isMap() ? field.find(kOthers) : field;
  const std::vector<std::string> named = field.isMap() ? field.members() : std::vector<std::string>();
  for (std::size_t i = 0; i < positions.size(); ++i) {
    const Joint& joint = robot.joints[i];
    const bool is_named = std::find(named.begin(), named.end(), joint.name) != named.end();
    if (others && !is_named && hasOnePosition(joint)) positions[i] = boundOf(joint, *others);
  }
  for (const std::string& name : named) {
    if (name == kOthers) continue;
    const Field bound = field.member(name);
    const std::size_t i = placeOf(name, namesOf(robot.joints), "joint", bound);
    if (const auto& mimic = robot.joints[i].mimic)
      bound.refuse("the joint follows \"" + robot.joints[mimic->joint].name + "\", and so does its uncertainty");
    positions[i] = boundOf(robot.joints[i], bound);
  }
  return positions;
}

}  // namespace

Uncertainty uncertaintyOfJoints(const RobotModel& robot, double position) {
  Uncertainty uncertainty(robot);
  for (std::size_t i = 0; i < robot.joints.size(); ++i)
    if (hasOnePosition(robot.joints[i])) uncertainty.positions[i] = position;
  uncertainty.requireValidFor(robot);
  return uncertainty;
}

Uncertainty uncertaintyFrom(const std::string& yaml, const std::string& source, const RobotModel& robot) {
  return uncertaintyFrom(readYaml(yaml, source), source, robot);
}

Uncertainty uncertaintyFrom(const FileValue& value, const std::string& source, const RobotModel& robot) {
  const Field file(value, source);
  Uncertainty uncertainty(robot);
  if (!file.isMap()) {
    uncertainty.positions = positionsIn(file, robot);
    return uncertainty;
  }
  file.requireMembers(
      {"joint_uncertainty", "joint_frame_uncertainty", "base_uncertainty", "object_uncertainty", "link_uncertainty"});
  const std::vector<std::string> joints = namesOf(robot.joints);
  if (const auto positions = file.find("joint_uncertainty")) uncertainty.positions = positionsIn(*positions, robot);
  readList(file.find("joint_frame_uncertainty"), isPose, joints, "joint", poseIn, uncertainty.frames);
  readList(file.find("base_uncertainty"), isPose, namesOf(robot.robots), "robot", poseIn, uncertainty.bases);
  readList(file.find("link_uncertainty"), isNumber, namesOf(robot.links), "link", lengthIn, uncertainty.swellings);
  readByName(file.find("object_uncertainty"), isPose, [&](const std::string& name, const Field& pose) {
    (name == kOthers ? uncertainty.objects : uncertainty.own_objects[name]) = poseIn(pose);
  });
  try {
    uncertainty.requireValidFor(robot);
  } catch (const std::invalid_argument& error) {
    throw std::invalid_argument(source + ": " + error.what());
  }
  return uncertainty;
}

FrameSpeeds frameSpeedsFrom(const FileValue& value, const std::string& source) {
  FrameSpeeds speeds;
  const Field field(value, source);
  const bool is_empty = field.isMap() && field.members().empty();
  if (is_empty) return speeds;
  readByName(field, isPose, [&](const std::string& name, const Field& pose) { speeds[name] = poseIn(pose); });
  return speeds;
}

const PoseUncertainty* speedOf(const FrameSpeeds& speeds, const std::string& name) {
  auto found = speeds.find(name);
  if (found == speeds.end()) found = speeds.find(kOthers);
  return found == speeds.end() ? nullptr : &found->second;
}

}  // namespace proximity_server::scene
