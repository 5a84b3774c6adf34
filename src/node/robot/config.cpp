#include "node/robot/config.h"
#include "node/robot/parameter_value.h"
#include "proximity_server/scene/model/names.h"
#include "proximity_server/scene/pieces/convex_pieces.h"

#include <ros/console.h>
#include <ros/names.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <stdexcept>
#include <utility>

namespace proximity_server::node {
namespace {

using XmlRpc::XmlRpcValue;

struct Range {
  double lowest, highest;
};

/// The shortest text that reads back as this number: "0.1", "1e-14".
std::string shortest(double value) {
  char text[32];
  return {text, std::to_chars(text, text + sizeof text, value).ptr};
}

/// An example of a list of pairs for an error message; it has the names of the user's flat list if that begins with
/// two.
std::string rightForm(XmlRpcValue& flat) {
  const auto isText = [&](int i) { return i < flat.size() && flat[i].getType() == XmlRpcValue::TypeString; };
  if (!isText(0) || !isText(1)) return "[[a, b]]";
  return "[[" + static_cast<std::string>(flat[0]) + ", " + static_cast<std::string>(flat[1]) + "]]";
}

/// Whether it is the name of a robot: letters, digits and underscores, as in names of ROS, so that "left/elbow" is unique.
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

/// The parameters of one namespace. It remembers the names that were read, so that it can warn about all others.
class Parameters {
 public:
  Parameters(const XmlRpcValue& values, std::string name_space) : namespace_(std::move(name_space)) {
    if (values.getType() == XmlRpcValue::TypeStruct) values_ = values;
  }

  void read(const std::string& name, std::string& target) {
    if (XmlRpcValue* value = find(name)) target = text(*value, name);
  }
  void read(const std::string& name, bool& target) {
    XmlRpcValue* value = find(name);
    if (!value) return;
    require(value->getType() == XmlRpcValue::TypeBoolean, name, "must be true or false");
    target = static_cast<bool>(*value);
  }
  void read(const std::string& name, double& target, const Range& range) {
    if (XmlRpcValue* value = find(name)) target = number(*value, name, range);
  }
  void read(const std::string& name, int& target, const Range& range) {
    XmlRpcValue* value = find(name);
    if (!value) return;
    require(value->getType() == XmlRpcValue::TypeInt, name, "must be a whole number");
    target = static_cast<int>(number(*value, name, range));
  }
  void read(const std::string& name, std::vector<std::string>& target) {
    if (XmlRpcValue* value = find(name)) target = texts(*value, name);
  }
  void read(const std::string& name, std::map<std::string, double>& target, const Range& range) {
    XmlRpcValue* value = find(name);
    if (!value) return;
    require(value->getType() == XmlRpcValue::TypeStruct, name, "must map names to numbers");
    for (auto& [key, entry] : *value) target[key] = number(entry, std::string(name).append("/").append(key), range);
  }
  void read(const std::string& name, MaxDeceleration& target, const Range& range) {
    XmlRpcValue* value = find(name);
    if (!value) return;
    if (value->getType() == XmlRpcValue::TypeStruct) {
      read(name, target.of_joint, range);
    } else {
      require(isNumber(*value), name, "must be a number, or map names of joints to numbers");
      target.of_all = number(*value, name, range);
    }
  }
  void read(const std::string& name, std::vector<scene::PairFilterOptions::Names>& target) {
    for (XmlRpcValue* entry : entries(name)) {
      require(entry->getType() == XmlRpcValue::TypeArray, name,
              "must be a list of pairs, with brackets around each of them: " + rightForm(values_[name]));
      target.push_back(pairOfNames(*entry, name));
    }
  }
  void read(const std::string& name, std::vector<std::pair<scene::PairFilterOptions::Names, double>>& target,
            const Range& range) {
    for (XmlRpcValue* entry : entries(name)) {
      require(entry->getType() == XmlRpcValue::TypeStruct && entry->hasMember("links") && entry->hasMember("padding"),
              name, "must list entries of the form {links: [a, b], padding: 0.01}");
      target.emplace_back(pairOfNames((*entry)["links"], name), number((*entry)["padding"], name, range));
    }
  }

  void read(const std::string& name, std::vector<RobotSource>& target) {
    XmlRpcValue* value = find(name);
    if (!value) return;
    require(value->getType() == XmlRpcValue::TypeStruct, name, "must map names of robots to {description: ...}");
    for (auto& [robot, entry] : *value) {
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
  void readAbsolutePath(const std::string& name, std::string& target) {
    read(name, target);
    require(target.empty() || target.front() == '/', name, "is '" + target + "', no absolute path");
  }
  void read(const std::string& name, scene::ObjectFile& target) {
    if (XmlRpcValue* value = find(name))
      target = scene::objectFileFrom(fileValueOf(*value), "parameter " + fullName(name));
  }

  /// The names of all parameters that were read or tolerated.
  const std::vector<std::string>& names() const { return known_; }

  /// Accepts a parameter of another library in this namespace.
  void tolerate(const std::string& name) { known_.push_back(name); }

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

  RobotSource robotSource(const std::string& name) {
    RobotSource robot;
    robot.name = name;
    read("description", robot.description);
    require(!robot.description.empty(), "description", "is missing: the name of the parameter with the robot's URDF");
    robot.semantic = robot.description + "_semantic";
    robot.needs_semantic = values_.hasMember("semantic");
    read("semantic", robot.semantic);
    read("tf_prefix", robot.tf_prefix);
    read("joint_states", robot.joint_states);
    require(isTopic(robot.joint_states), "joint_states", "is no name of a topic: '" + robot.joint_states + "'");
    for (const auto& [field, value] : values_) {
      require(std::find(known_.begin(), known_.end(), field) != known_.end(), field,
              "is unknown: did you mean '" + scene::nearestName(field, known_) + "'?");
    }
    return robot;
  }

  void require(bool condition, const std::string& name, const std::string& demand) const {
    if (!condition) throw std::invalid_argument("parameter " + fullName(name) + " " + demand);
  }

  XmlRpcValue* find(const std::string& name) {
    known_.push_back(name);
    return values_.valid() && values_.hasMember(name) ? &values_[name] : nullptr;
  }

  std::vector<XmlRpcValue*> entries(const std::string& name) {
    std::vector<XmlRpcValue*> result;
    XmlRpcValue* value = find(name);
    if (!value) return result;
    require(value->getType() == XmlRpcValue::TypeArray, name, "must be a list");
    result.reserve(static_cast<std::size_t>(value->size()));
    for (int i = 0; i < value->size(); ++i) result.push_back(&(*value)[i]);
    return result;
  }

  double number(XmlRpcValue& value, const std::string& name, const Range& range) const {
    require(isNumber(value), name, "must be a number");
    const bool is_int = value.getType() == XmlRpcValue::TypeInt;
    const double result = is_int ? static_cast<int>(value) : static_cast<double>(value);
    // Written with >= and <= so that NaN is outside of every range.
    require(
        result >= range.lowest && result <= range.highest, name,
        "is " + shortest(result) + ", outside of [" + shortest(range.lowest) + ", " + shortest(range.highest) + "]");
    return result;
  }

  std::string text(XmlRpcValue& value, const std::string& name) const {
    require(value.getType() == XmlRpcValue::TypeString, name, "must be a text");
    return static_cast<std::string>(value);
  }

  std::vector<std::string> texts(XmlRpcValue& value, const std::string& name) const {
    require(value.getType() == XmlRpcValue::TypeArray, name, "must be a list of texts");
    std::vector<std::string> result;
    result.reserve(static_cast<std::size_t>(value.size()));
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

void readMonitorSettings(Parameters& parameters, MonitorSettings& settings) {
  // The same ranges as in config/Proximity.cfg.
  parameters.read("rate", settings.rate, {0.0, 1000.0});
  parameters.read("threshold", settings.threshold, {0.0, 100.0});
  parameters.read("warn_distance", settings.warn_distance, {0.0, 100.0});
  parameters.read("stop_distance", settings.stop_distance, {0.0, 100.0});
  parameters.read("object_warn_distance", settings.object_warn_distance, {0.0, 100.0});
  parameters.read("object_stop_distance", settings.object_stop_distance, {0.0, 100.0});
  parameters.read("hysteresis", settings.hysteresis, {0.0, 1.0});
  parameters.read("max_reported_pairs", settings.max_reported_pairs, {0, 10000});
  parameters.read("markers", settings.markers);
  parameters.read("lookahead", settings.lookahead, {0.0, 60.0});
  parameters.read("gradients", settings.gradients);
  parameters.read("influence_distance", settings.influence_distance, {0.0, 100.0});
  parameters.read("damping_gain", settings.damping_gain, {1e-3, 1000.0});
  parameters.read("max_constraints", settings.max_constraints, {1, 1000});
  parameters.read("stop_latency", settings.stop_latency, {0.0, 60.0});
}

/// Whether these parameters describe several robots.
bool hasRobots(const XmlRpcValue& values) {
  if (values.getType() != XmlRpcValue::TypeStruct || !values.hasMember("robots")) return false;
  XmlRpcValue robots = XmlRpcValue(values)["robots"];
  return robots.getType() == XmlRpcValue::TypeStruct && robots.size() > 0;
}

/// Reads every parameter and checks its range.
Config readConfig(Parameters& parameters) {
  Config config;
  parameters.read("robots", config.robots);
  parameters.read("robot_description", config.robot_description);
  parameters.read("semantic_description", config.semantic_description);
  parameters.read("reference_frame", config.reference_frame);
  parameters.read("tf_prefix", config.tf_prefix);
  parameters.read("mesh_roots", config.mesh_roots);
  parameters.read("allowed_mesh_roots", config.allowed_mesh_roots);
  parameters.read("allow_missing_meshes", config.model.allow_missing_meshes);
  parameters.read("default_padding", config.model.default_padding, {0.0, 10.0});
  parameters.read("link_padding", config.model.link_padding, {0.0, 10.0});
  parameters.read("mesh_tolerance", config.model.mesh_tolerance, {0.0, 1.0});
  parameters.read("link_mesh_tolerance", config.model.link_mesh_tolerance, {0.0, 1.0});
  parameters.read("mesh_time_budget", config.model.mesh_time_budget, {1e-3, 3600.0});
  config.model.mesh_cache = "user";
  parameters.read("mesh_cache", config.model.mesh_cache);
  if (config.model.mesh_cache == "user") config.model.mesh_cache = scene::userMeshCache();
  parameters.read("pair_padding", config.filter.pair_padding, {0.0, 10.0});
  parameters.read("exclude_pairs", config.filter.exclude_pairs);
  parameters.read("only_pairs", config.filter.only_pairs);
  parameters.read("group", config.filter.group);
  parameters.read("tolerance", config.tolerance, {1e-14, 0.1});
  parameters.read("max_tf_age", config.max_tf_age, {1e-3, 1e6});
  parameters.read("max_tf_skew", config.max_tf_skew, {0.0, 1e6});
  parameters.read("tf_timeout", config.tf_timeout, {0.0, 10.0});
  parameters.read("max_batch", config.max_batch, {1, 1e9});
  parameters.read("max_request_time", config.max_request_time, {1e-6, 3600.0});
  parameters.read("motion_time_budget", config.motion_time_budget, {1e-4, 3600.0});
  parameters.read("realtime_priority", config.realtime_priority, {0, 99});
  bool check_free_objects = false;
  parameters.read("check_free_objects", check_free_objects);
  using FreeObjects = scene::ObjectRules::FreeObjects;
  config.free_objects = check_free_objects ? FreeObjects::Checked : FreeObjects::NotChecked;
  parameters.read("objects", config.objects);
  parameters.readAbsolutePath("objects_file", config.objects_file);
  parameters.read("max_deceleration", config.max_deceleration, {1e-3, 1e6});
  readMonitorSettings(parameters, config.monitor);
  return config;
}

}  // namespace

std::vector<RobotSource> robotSources(const Config& config) {
  if (!config.robots.empty()) return config.robots;
  RobotSource robot;
  robot.description = config.robot_description;
  robot.semantic = config.semantic_description;
  robot.needs_semantic = config.semantic_description != Config().semantic_description;
  robot.tf_prefix = config.tf_prefix;
  return {robot};
}

std::string problemOf(const MonitorSettings& settings) {
  const std::pair<const char*, double> numbers[] = {
      {"rate", settings.rate},
      {"threshold", settings.threshold},
      {"warn_distance", settings.warn_distance},
      {"stop_distance", settings.stop_distance},
      {"object_warn_distance", settings.object_warn_distance},
      {"object_stop_distance", settings.object_stop_distance},
      {"hysteresis", settings.hysteresis},
      {"lookahead", settings.lookahead},
      {"influence_distance", settings.influence_distance},
      {"damping_gain", settings.damping_gain},
      {"stop_latency", settings.stop_latency},
  };
  for (const auto& [name, value] : numbers) {
    if (!std::isfinite(value)) return std::string(name) + " is " + shortest(value) + ", not a finite number";
  }
  const auto contradiction = [](const std::string& kind, double stop, double warn) {
    if (stop <= warn) return std::string();
    return kind + "stop_distance is " + shortest(stop) + ", above " + kind + "warn_distance, which is " +
           shortest(warn) + ": the level WARN comes before STOP";
  };
  const std::string of_links = contradiction("", settings.stop_distance, settings.warn_distance);
  if (!of_links.empty()) return of_links;
  return contradiction("object_", settings.object_stop_distance, settings.object_warn_distance);
}

std::string problemOfDamper(const MonitorSettings& settings) {
  const std::pair<const char*, double> stop_distances[] = {{"stop_distance", settings.stop_distance},
                                                           {"object_stop_distance", settings.object_stop_distance}};
  for (const auto& [name, stop] : stop_distances) {
    if (settings.influence_distance > stop) continue;
    return "influence_distance is " + shortest(settings.influence_distance) + ", not above " + name + ", which is " +
           shortest(stop);
  }
  return {};
}

Config configFrom(const XmlRpcValue& values, const std::string& name_space) {
  Parameters parameters(values, name_space);
  Config config = readConfig(parameters);
  parameters.tolerate("diagnostic_period");  // of diagnostic_updater
  parameters.warnAboutUnknown();
  const std::string problem = problemOf(config.monitor);
  if (!problem.empty()) throw std::invalid_argument("parameter " + name_space + "/" + problem);
  return config;
}

std::vector<std::string> parameterNames() {
  Parameters parameters({}, "");
  readConfig(parameters);
  return parameters.names();
}

Config loadConfig(const ros::NodeHandle& private_nh) {
  XmlRpcValue values;
  private_nh.getParam(private_nh.getNamespace(), values);
  std::string found;
  const bool may_have_members = !values.valid() || values.getType() == XmlRpcValue::TypeStruct;
  const bool is_found = private_nh.searchParam("tf_prefix", found) && found != private_nh.resolveName("tf_prefix");
  // Several robots have a prefix each.
  if (may_have_members && is_found && !hasRobots(values)) private_nh.getParam(found, values["tf_prefix"]);
  return configFrom(values, private_nh.getNamespace());
}

}  // namespace proximity_server::node
