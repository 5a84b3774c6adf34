#include "node/robot/load_config.h"

#include "node/robot/parameter_table.h"
#include "node/robot/parameter_value.h"
#include "proximity_server/scene/model/names.h"
#include "proximity_server/scene/pieces/convex_pieces.h"

#include <ros/console.h>
#include <ros/names.h>

#include <algorithm>
#include <cctype>
#include <stdexcept>
#include <utility>

namespace proximity_server::node {
namespace {

using XmlRpc::XmlRpcValue;

/// An example of a list of pairs for an error message. If the user's flat list begins with two names, the example has
/// these.
std::string exampleOfPairs(XmlRpcValue& flat) {
  const auto isText = [&](int i) { return i < flat.size() && flat[i].getType() == XmlRpcValue::TypeString; };
  if (!isText(0) || !isText(1)) return "[[a, b]]";
  return "[[" + static_cast<std::string>(flat[0]) + ", " + static_cast<std::string>(flat[1]) + "]]";
}

/// Returns whether `name` may be the name of a robot: letters, digits and underscores, as in names of ROS. It has no
/// slash, so that "left/elbow" is unique.
bool isRobotName(const std::string& name) {
  const auto is_allowed = [](unsigned char c) { return std::isalnum(c) || c == '_'; };
  return !name.empty() && std::isalpha(static_cast<unsigned char>(name.front())) &&
         std::all_of(name.begin(), name.end(), is_allowed);
}

bool isNumber(const XmlRpcValue& value) {
  return value.getType() == XmlRpcValue::TypeInt || value.getType() == XmlRpcValue::TypeDouble;
}

bool isTopic(const std::string& name) {
  std::string problem;
  return !name.empty() && name.front() != '~' && ros::names::validate(name, problem);
}

/// Reads the parameters of one namespace, and remembers their names, so that it can warn about all others.
class Parameters {
 public:
  Parameters(const XmlRpcValue& values, std::string name_space) : namespace_(std::move(name_space)) {
    if (values.getType() == XmlRpcValue::TypeStruct) values_ = values;
  }

  void read(const Parameter& parameter) {
    XmlRpcValue* value = find(parameter.name);
    if (value) std::visit([&](auto* field) { set(*field, *value, parameter); }, parameter.field);
  }

  void require(bool condition, const std::string& name, const std::string& demand) const {
    if (!condition) throw std::invalid_argument("parameter " + fullName(name) + " " + demand);
  }

  void requireTopics(const std::vector<std::string>& topics, const std::string& name) const {
    for (const std::string& topic : topics) require(isTopic(topic), name, "has no name of a topic: '" + topic + "'");
  }

  /// Accepts a parameter that another library reads in this namespace.
  void acceptUnread(const std::string& name) { known_.push_back(name); }

  /// Warns about a parameter that is gone, if it is given.
  void warnAboutRemoved(const std::string& name, const std::string& instead) {
    if (!values_.valid() || !values_.hasMember(name)) return;
    acceptUnread(name);
    ROS_WARN_STREAM("parameter " << fullName(name) << " has no effect any more: " << instead);
  }

  void warnAboutUnknown() {
    if (!values_.valid()) return;
    for (const auto& [name, value] : values_) {
      if (std::find(known_.begin(), known_.end(), name) != known_.end()) continue;
      ROS_WARN_STREAM("parameter " << fullName(name) << " is unknown and has no effect: did you mean '"
                                   << scene::nearestName(name, known_) << "'?");
    }
  }

 private:
  std::string fullName(const std::string& name) const { return namespace_ + "/" + name; }

  void set(std::string& target, XmlRpcValue& value, const Parameter& parameter) {
    target = text(value, parameter.name);
  }
  void set(std::vector<std::string>& target, XmlRpcValue& value, const Parameter& parameter) {
    target = texts(value, parameter.name);
  }
  void set(bool& target, XmlRpcValue& value, const Parameter& parameter) {
    require(value.getType() == XmlRpcValue::TypeBoolean, parameter.name, "must be true or false");
    target = static_cast<bool>(value);
  }
  void set(scene::ObjectRules::FreeObjects& target, XmlRpcValue& value, const Parameter& parameter) {
    bool is_checked = false;
    set(is_checked, value, parameter);
    using FreeObjects = scene::ObjectRules::FreeObjects;
    target = is_checked ? FreeObjects::Checked : FreeObjects::NotChecked;
  }
  void set(double& target, XmlRpcValue& value, const Parameter& parameter) {
    target = number(value, parameter.name, parameter.range);
  }
  void set(int& target, XmlRpcValue& value, const Parameter& parameter) {
    require(value.getType() == XmlRpcValue::TypeInt, parameter.name, "must be a whole number");
    target = static_cast<int>(number(value, parameter.name, parameter.range));
  }
  void set(std::map<std::string, double>& target, XmlRpcValue& value, const Parameter& parameter) {
    require(value.getType() == XmlRpcValue::TypeStruct, parameter.name, "must map names to numbers");
    for (auto& [key, entry] : value)
      target[key] = number(entry, std::string(parameter.name).append("/").append(key), parameter.range);
  }
  void set(JointLimits& target, XmlRpcValue& value, const Parameter& parameter) {
    if (value.getType() == XmlRpcValue::TypeStruct) {
      set(target.of_joint, value, parameter);
    } else {
      require(isNumber(value), parameter.name, "must be a number, or map names of joints to numbers");
      target.of_all = number(value, parameter.name, parameter.range);
    }
  }
  void set(std::vector<Parameter::Names>& target, XmlRpcValue& value, const Parameter& parameter) {
    for (XmlRpcValue* entry : entries(value, parameter.name)) {
      require(entry->getType() == XmlRpcValue::TypeArray, parameter.name,
              "must be a list of pairs, with brackets around each of them: " + exampleOfPairs(value));
      target.push_back(pairOfNames(*entry, parameter.name));
    }
  }
  void set(std::vector<std::pair<Parameter::Names, double>>& target, XmlRpcValue& value, const Parameter& parameter) {
    const std::string& name = parameter.name;
    const std::string key = name.substr(name.rfind('_') + 1);  // "padding" of pair_padding
    for (XmlRpcValue* entry : entries(value, name)) {
      require(entry->getType() == XmlRpcValue::TypeStruct && entry->hasMember("links") && entry->hasMember(key), name,
              "must list entries of the form {links: [a, b], " + key + ": 0.01}");
      target.emplace_back(pairOfNames((*entry)["links"], name), number((*entry)[key], name, parameter.range));
    }
  }
  void set(std::vector<RobotSource>& target, XmlRpcValue& value, const Parameter& parameter) {
    const std::string& name = parameter.name;
    require(value.getType() == XmlRpcValue::TypeStruct, name, "must map names of robots to {description: ...}");
    for (auto& [robot, entry] : value) {
      const std::string path = name + "/" + robot;
      require(isRobotName(robot), path, "names a robot: letters, digits and underscores, a letter first");
      require(entry.getType() == XmlRpcValue::TypeStruct, path,
              "must be of the form {description: ..., tf_prefix: ...}");
      target.push_back(Parameters(entry, fullName(path)).robotSource(robot));
    }
    for (const char* other : {"robot_description", "semantic_description", "tf_prefix"})
      require(target.empty() || !values_.hasMember(other), other,
              "has no effect beside robots, which describes each robot");
  }
  void set(scene::ObjectFile& target, XmlRpcValue& value, const Parameter& parameter) {
    target = scene::objectFileFrom(fileValueOf(value), "parameter " + fullName(parameter.name));
  }

  void set(scene::FileValue& target, XmlRpcValue& value, const Parameter& /*parameter*/) {
    target = fileValueOf(value);
  }
  void set(PoseLatency& target, XmlRpcValue& value, const Parameter& parameter) {
    // YAML 1.1 takes off for false.
    const bool is_off = value.getType() == XmlRpcValue::TypeBoolean && !static_cast<bool>(value);
    const std::string wanted = is_off ? "off" : text(value, parameter.name);
    for (const PoseLatency latency : {PoseLatency::Off, PoseLatency::Velocity, PoseLatency::Limit}) {
      target = latency;
      if (wanted == toString(latency)) return;
    }
    require(false, parameter.name, "is '" + wanted + "', but must be off, velocity or limit");
  }

  void readText(const std::string& name, std::string& target) {
    if (XmlRpcValue* value = find(name)) target = text(*value, name);
  }

  RobotSource robotSource(const std::string& name) {
    RobotSource robot;
    robot.name = name;
    readText("description", robot.description);
    require(!robot.description.empty(), "description", "is missing: the name of the parameter with the robot's URDF");
    robot.semantic = robot.description + "_semantic";
    robot.needs_semantic = values_.hasMember("semantic");
    readText("semantic", robot.semantic);
    readText("tf_prefix", robot.tf_prefix);
    readText("joint_states", robot.joint_states);
    require(isTopic(robot.joint_states), "joint_states", "is no name of a topic: '" + robot.joint_states + "'");
    if (XmlRpcValue* value = find("trajectories")) robot.trajectories = texts(*value, "trajectories");
    requireTopics(robot.trajectories, "trajectories");
    for (const auto& [field, value] : values_) {
      require(std::find(known_.begin(), known_.end(), field) != known_.end(), field,
              "is unknown: did you mean '" + scene::nearestName(field, known_) + "'?");
    }
    return robot;
  }

  XmlRpcValue* find(const std::string& name) {
    known_.push_back(name);
    return values_.valid() && values_.hasMember(name) ? &values_[name] : nullptr;
  }

  std::vector<XmlRpcValue*> entries(XmlRpcValue& value, const std::string& name) const {
    require(value.getType() == XmlRpcValue::TypeArray, name, "must be a list");
    std::vector<XmlRpcValue*> result;
    result.reserve(value.size());
    for (int i = 0; i < value.size(); ++i) result.push_back(&value[i]);
    return result;
  }

  double number(XmlRpcValue& value, const std::string& name, const Range& range) const {
    require(isNumber(value), name, "must be a number");
    const bool is_int = value.getType() == XmlRpcValue::TypeInt;
    const double result = is_int ? static_cast<int>(value) : static_cast<double>(value);
    // Written with >= and <= so that NaN is outside of every range.
    require(result >= range.lowest && result <= range.highest, name,
            "is " + scene::shortest(result) + ", outside of " + range.text());
    return result;
  }

  std::string text(XmlRpcValue& value, const std::string& name) const {
    require(value.getType() == XmlRpcValue::TypeString, name, "must be a text");
    return static_cast<std::string>(value);
  }

  std::vector<std::string> texts(XmlRpcValue& value, const std::string& name) const {
    require(value.getType() == XmlRpcValue::TypeArray, name, "must be a list of texts");
    std::vector<std::string> result;
    result.reserve(value.size());
    for (int i = 0; i < value.size(); ++i) result.push_back(text(value[i], name));
    return result;
  }

  scene::PairFilterOptions::Names pairOfNames(XmlRpcValue& value, const std::string& name) const {
    const std::vector<std::string> names = texts(value, name);
    require(names.size() == 2, name, "must name two links per pair");
    return {names[0], names[1]};
  }

  std::string namespace_;
  XmlRpcValue values_;
  std::vector<std::string> known_;
};

/// Returns whether these parameters describe robots by the parameter `robots`.
bool hasRobots(const XmlRpcValue& values) {
  if (values.getType() != XmlRpcValue::TypeStruct || !values.hasMember("robots")) return false;
  XmlRpcValue robots = XmlRpcValue(values)["robots"];
  return robots.getType() == XmlRpcValue::TypeStruct && robots.size() > 0;
}

/// Returns why these settings contradict each other ("stop_distance is ..."), or "" if they do not.
std::string contradictionIn(const MonitorSettings& settings) {
  const auto contradiction = [](const std::string& kind, double stop, double warn) {
    if (stop <= warn) return std::string();
    return kind + "stop_distance is " + scene::shortest(stop) + ", above " + kind + "warn_distance, which is " +
           scene::shortest(warn) + ": the level WARN comes before STOP";
  };
  const std::string of_links = contradiction("", settings.stop_distance, settings.warn_distance);
  if (!of_links.empty()) return of_links;
  return contradiction("object_", settings.object_stop_distance, settings.object_warn_distance);
}

}  // namespace

const char* toString(PoseLatency latency) {
  switch (latency) {
    case PoseLatency::Off:
      return "off";
    case PoseLatency::Velocity:
      return "velocity";
    case PoseLatency::Limit:
      return "limit";
  }
  return "unknown";
}

std::vector<RobotSource> robotSources(const Config& config) {
  if (!config.robots.empty()) return config.robots;
  RobotSource robot;
  robot.description = config.robot_description;
  robot.semantic = config.semantic_description;
  robot.needs_semantic = config.semantic_description != Config().semantic_description;
  robot.tf_prefix = config.tf_prefix;
  robot.trajectories = config.trajectories;
  return {robot};
}

std::string problemOfInfluenceDistance(const MonitorSettings& settings) {
  const std::pair<const char*, double> stop_distances[] = {{"stop_distance", settings.stop_distance},
                                                           {"object_stop_distance", settings.object_stop_distance}};
  for (const auto& [name, stop] : stop_distances) {
    if (settings.influence_distance > stop) continue;
    return "influence_distance is " + scene::shortest(settings.influence_distance) + ", not above " + name +
           ", which is " + scene::shortest(stop);
  }
  return {};
}

std::string differences(const MonitorSettings& in_force, const MonitorSettings& others) {
  Config here, there;
  here.monitor = in_force;
  there.monitor = others;
  const std::vector<Parameter> row_here = parameterTable(here), row_there = parameterTable(there);
  const auto text = [](const Parameter& parameter) -> std::string {
    if (const auto* const* number = std::get_if<double*>(&parameter.field)) return scene::shortest(**number);
    if (const auto* const* count = std::get_if<int*>(&parameter.field)) return std::to_string(**count);
    if (const auto* const* flag = std::get_if<bool*>(&parameter.field)) return **flag ? "true" : "false";
    return {};  // no live parameter is of another type
  };
  std::string result;
  for (std::size_t i = 0; i < row_here.size(); ++i) {
    if (row_here[i].change != Parameter::Change::Live || text(row_here[i]) == text(row_there[i])) continue;
    result += (result.empty() ? "" : ", ") + row_here[i].name + " is " + text(row_here[i]) + ", there it is " +
              text(row_there[i]);
  }
  return result;
}

Config configFrom(const XmlRpcValue& values, const std::string& name_space) {
  Config config;
  Parameters parameters(values, name_space);
  for (const Parameter& parameter : parameterTable(config)) parameters.read(parameter);
  parameters.acceptUnread("diagnostic_period");  // diagnostic_updater reads it
  parameters.warnAboutRemoved(
      "conditional_pairs", "its file is not read, and its pairs are measured as all others are, with the same answers");
  parameters.warnAboutUnknown();
  config.model.mesh_cache = config.mesh_cache == "user" ? scene::userMeshCache() : config.mesh_cache;
  const std::pair<const char*, const std::string&> paths[] = {{"objects_file", config.objects_file},
                                                              {"record_directory", config.record_directory}};
  for (const auto& [parameter, path] : paths)
    parameters.require(path.empty() || path.front() == '/', parameter, "is '" + path + "', no absolute path");
  parameters.requireTopics(config.trajectories, "trajectories");
  for (const std::string& event : config.record_on)
    parameters.require(event == "stop" || event == "collision" || event == "invalid", "record_on",
                       "has '" + event + "', which is neither stop, collision nor invalid");
  if (values.valid()) config.parameters = values.toXml();
  const std::string problem = contradictionIn(config.monitor);
  if (!problem.empty()) throw std::invalid_argument("parameter " + name_space + "/" + problem);
  return config;
}

MonitorSettings monitorSettingsFrom(const dynamic_reconfigure::Config& values, const std::string& name_space) {
  XmlRpcValue parameters;
  for (const auto& entry : values.doubles) parameters[entry.name] = XmlRpcValue(entry.value);
  for (const auto& entry : values.ints) parameters[entry.name] = XmlRpcValue(entry.value);
  for (const auto& entry : values.bools) parameters[entry.name] = XmlRpcValue(entry.value != 0);
  return configFrom(parameters, name_space).monitor;
}

Config loadConfig(const ros::NodeHandle& private_nh) {
  XmlRpcValue values;
  private_nh.getParam(private_nh.getNamespace(), values);
  std::string found;
  const bool may_have_members = !values.valid() || values.getType() == XmlRpcValue::TypeStruct;
  const bool is_found = private_nh.searchParam("tf_prefix", found) && found != private_nh.resolveName("tf_prefix");
  // Each of several robots has a prefix of its own, so a common one is not searched then.
  if (may_have_members && is_found && !hasRobots(values)) private_nh.getParam(found, values["tf_prefix"]);
  return configFrom(values, private_nh.getNamespace());
}

}  // namespace proximity_server::node
