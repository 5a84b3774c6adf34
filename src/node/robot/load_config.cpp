#include "node/robot/load_config.h"

#include "node/robot/parameter_table.h"
#include "node/robot/parameter_value.h"
#include "proximity_server/scene/model/names.h"

#include <ros/console.h>
#include <ros/names.h>

#include <algorithm>
#include <cctype>
#include <stdexcept>
#include <utility>

namespace proximity_server::node {
namespace {

using scene::FileValue;
using scene::Parameter;
using scene::ParameterReader;
using XmlRpc::XmlRpcValue;

/// Returns whether `name` may be the name of a robot: letters, digits and underscores, as in names of ROS. It has no
/// slash, so that "left/elbow" is unique.
bool isRobotName(const std::string& name) {
  const auto is_allowed = [](unsigned char c) { return std::isalnum(c) || c == '_'; };
  return !name.empty() && std::isalpha(static_cast<unsigned char>(name.front())) &&
         std::all_of(name.begin(), name.end(), is_allowed);
}

bool isTopic(const std::string& name) {
  std::string problem;
  return !name.empty() && name.front() != '~' && ros::names::validate(name, problem);
}

void requireTopics(const std::vector<std::string>& topics, const std::string& name, const ParameterReader& reader) {
  for (const std::string& topic : topics)
    reader.require(isTopic(topic), name, "has no name of a topic: '" + topic + "'");
}

void requireKnown(const ParameterReader& reader) {
  for (const std::string& field : reader.unknown())
    reader.require(false, field, "is unknown" + scene::didYouMean(field, reader.known()));
}

RobotSource robotSource(const std::string& name, const FileValue& value, const std::string& name_space) {
  ParameterReader reader(value, name_space);
  RobotSource robot;
  robot.name = name;
  reader.read("description", robot.description);
  reader.require(!robot.description.empty(), "description",
                 "is missing: the name of the parameter with the robot's URDF");
  robot.semantic = robot.description + "_semantic";
  robot.needs_semantic = reader.isSet("semantic");
  reader.read("semantic", robot.semantic);
  reader.read("tf_prefix", robot.tf_prefix);
  reader.read("joint_states", robot.joint_states);
  reader.require(isTopic(robot.joint_states), "joint_states", "is no name of a topic: '" + robot.joint_states + "'");
  if (const FileValue* const topics = reader.find("trajectories"))
    robot.trajectories = reader.texts(*topics, "trajectories");
  requireTopics(robot.trajectories, "trajectories", reader);
  requireKnown(reader);
  return robot;
}

std::vector<RobotSource> sourcesFrom(const FileValue& value, const ParameterReader& reader,
                                     const std::string& name_space) {
  const auto* const robots = std::get_if<FileValue::Map>(&value.content);
  reader.require(robots, "robots", "must map names of robots to {description: ...}");
  std::vector<RobotSource> sources;
  for (const FileValue::Member& robot : *robots) {
    const std::string path = "robots/" + robot.name;
    reader.require(isRobotName(robot.name), path, "names a robot: letters, digits and underscores, a letter first");
    reader.require(std::holds_alternative<FileValue::Map>(robot.value.content), path,
                   "must be of the form {description: ..., tf_prefix: ...}");
    sources.push_back(robotSource(robot.name, robot.value, name_space + "/" + path));
  }
  for (const char* other : {"robot_description", "semantic_description", "tf_prefix"})
    reader.require(sources.empty() || !reader.isSet(other), other,
                   "has no effect beside robots, which describes each robot");
  return sources;
}

/// The topic and the name of an entry of the parameters `tracked` and `sensed`.
TrackedSource namedSource(ParameterReader& reader) {
  TrackedSource source;
  reader.read("topic", source.topic);
  reader.require(isTopic(source.topic), "topic", "is no name of a topic: '" + source.topic + "'");
  source.name = source.topic.substr(source.topic.front() == '/' ? 1 : 0);
  reader.read("name", source.name);
  reader.require(!source.name.empty() && source.name != "*", "name", "is '" + source.name + "', no name of an object");
  scene::requireUtf8(source.name);
  return source;
}

/// Reads an entry of the parameter `tracked`; `name_space` ends with its index.
TrackedSource trackedSource(const FileValue& value, const std::string& name_space) {
  ParameterReader reader(value, name_space);
  TrackedSource source = namedSource(reader);
  std::string type;
  reader.read("type", type);
  reader.require(type == "PoseArray" || type == "PointCloud2", "type",
                 "is '" + type + "', but must be PoseArray or PointCloud2");
  source.type = type == "PoseArray" ? TrackedSource::Type::PoseArray : TrackedSource::Type::PointCloud2;
  reader.require(reader.isSet("radius"), "radius", "is missing: that of the ball around each point [m]");
  scene::ParameterRows numbers;
  const auto add = [&](const char* name, double* field, const scene::Range& range) {
    numbers(name, field, range, "", Parameter::Change::Reload, "");
  };
  add("radius", &source.radius, {1e-3, 10});
  add("max_age", &source.max_age, {1e-3, 10});
  add("speed", &source.speed, {0, 100});
  add("near_speed", &source.near_speed, {0, 100});
  add("intrusion", &source.intrusion, {0, 10});
  add("uncertainty", &source.uncertainty, {0, 10});
  for (const Parameter& number : numbers.rows) reader.read(number);
  if (!reader.isSet("near_speed")) source.near_speed = 1.25 * source.speed;
  reader.require(source.near_speed >= source.speed, "near_speed", "must not be below speed");
  requireKnown(reader);
  return source;
}

/// Reads an entry of the parameter `sensed`; `name_space` ends with its index.
TrackedSource sensedSource(const FileValue& value, const std::string& name_space) {
  ParameterReader reader(value, name_space);
  TrackedSource source = namedSource(reader);
  std::string type = "PointCloud2";
  reader.read("type", type);
  reader.require(type == "PointCloud2" || type == "Octomap", "type",
                 "is '" + type + "', but must be PointCloud2 or Octomap");
  source.type = type == "Octomap" ? TrackedSource::Type::Octomap : TrackedSource::Type::PointCloud2;
  Sensing& sensing = source.sensing.emplace();
  scene::ParameterRows numbers;
  const auto add = [&](const char* name, const Parameter::Field& field, const scene::Range& range) {
    numbers(name, field, range, "", Parameter::Change::Reload, "");
  };
  if (source.isMap()) {
    requireKnown(reader);
    return source;
  }
  add("resolution", &sensing.resolution, {1e-3, 1});
  add("self_padding", &sensing.self_padding, {0, 10});
  add("link_self_padding", &sensing.link_padding, {0, 10});
  add("range", &sensing.range, {1e-2, 1000});
  add("persistence", &sensing.persistence, {0, 3600});
  add("clearing", &sensing.clearing, {});
  add("max_points", &sensing.max_points, {1, 1e8});
  add("object_padding", &sensing.object_padding, {0, 10});
  add("max_age", &source.max_age, {1e-3, 10});
  for (const Parameter& number : numbers.rows) reader.read(number);
  requireKnown(reader);
  return source;
}

/// Appends the sources of the parameter `name`, whose entries `read` reads. `fields` and `example` are of an entry.
template <class Read>
void addSources(const std::string& name, const FileValue& value, const std::string& fields, const std::string& example,
                const Read& read, const ParameterReader& reader, const std::string& name_space,
                std::vector<TrackedSource>& sources) {
  const auto* const entries = std::get_if<FileValue::List>(&value.content);
  reader.require(entries, name, "must be a list of " + fields);
  std::size_t number = 0;
  for (const FileValue& entry : *entries) {
    const std::string place = name + "[" + std::to_string(number++) + "]";
    reader.require(std::holds_alternative<FileValue::Map>(entry.content), place, "must be of the form " + example);
    TrackedSource source = read(entry, name_space + "/" + place);
    reader.require(scene::findNamed(sources, source.name) < 0, place + "/name",
                   "is '" + source.name + "', as that of an entry before it");
    sources.push_back(std::move(source));
  }
}

PoseLatency poseLatency(const FileValue& value, const ParameterReader& reader) {
  // YAML 1.1 takes off for false.
  const auto* const text = std::get_if<std::string>(&value.content);
  const auto* const truth = std::get_if<bool>(&value.content);
  const std::string wanted = truth && !*truth ? "off" : text ? *text : "";
  reader.require(text || !wanted.empty(), "pose_latency", "must be a text");
  for (const PoseLatency latency : {PoseLatency::Off, PoseLatency::Velocity, PoseLatency::Limit})
    if (wanted == toString(latency)) return latency;
  reader.require(false, "pose_latency", "is '" + wanted + "', but must be off, velocity or limit");
  return PoseLatency::Off;
}

/// Returns whether these parameters describe robots by the parameter `robots`.
bool hasRobots(const XmlRpcValue& values) {
  if (values.getType() != XmlRpcValue::TypeStruct || !values.hasMember("robots")) return false;
  XmlRpcValue robots = XmlRpcValue(values)["robots"];
  return robots.getType() == XmlRpcValue::TypeStruct && robots.size() > 0;
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

const TrackedSource* Config::findTracked(const std::string& source) const {
  const int found = scene::findNamed(tracked, source);
  return found < 0 ? nullptr : &tracked[found];
}

bool Config::isTracking() const {
  return std::any_of(tracked.begin(), tracked.end(), [](const TrackedSource& source) { return !source.sensing; });
}

bool Config::isSensing() const {
  return std::any_of(tracked.begin(), tracked.end(), [](const TrackedSource& source) { return source.sensing; });
}

std::string problemOfInfluenceDistance(const MonitorSettings& settings, const Config& config) {
  const std::pair<const char*, double> stop_distances[] = {
      {"stop_distance", settings.stop_distance},
      {"object_stop_distance", settings.object_stop_distance},
      {"tracked_stop_distance", config.isTracking() ? settings.tracked_stop_distance : 0.0},
      {"sensed_stop_distance", config.isSensing() ? settings.sensed_stop_distance : 0.0}};
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
  XmlRpcValue copy = values;
  const FileValue given = fileValueOf(copy);
  ParameterReader reader(given, name_space);
  for (const Parameter& parameter : parameterTable(config)) reader.read(parameter);
  reader.find("diagnostic_period");  // diagnostic_updater reads it
  if (reader.find("conditional_pairs"))
    ROS_WARN_STREAM(
        "parameter " << name_space
                     << "/conditional_pairs has no effect any more: its file is not read, and its pairs are "
                        "measured as all others are, with the same answers");
  for (const std::string& name : reader.unknown())
    ROS_WARN_STREAM(reader.place() << name << " is unknown and has no effect"
                                   << scene::didYouMean(name, reader.known()));
  config.robots = sourcesFrom(config.robots_value, reader, name_space);
  addSources("tracked", config.tracked_value, "{topic: ..., type: ..., radius: ...}",
             "{topic: /people, type: PoseArray, radius: 0.3}", trackedSource, reader, name_space, config.tracked);
  addSources("sensed", config.sensed_value, "{topic: ..., resolution: ...}",
             "{topic: /camera/points, resolution: 0.02}", sensedSource, reader, name_space, config.tracked);
  config.pose_latency = poseLatency(config.pose_latency_value, reader);
  config.useMeshCache();
  const std::pair<const char*, const std::string&> paths[] = {{"objects_file", config.objects_file},
                                                              {"record_directory", config.record_directory}};
  for (const auto& [parameter, path] : paths)
    reader.require(path.empty() || path.front() == '/', parameter, "is '" + path + "', no absolute path");
  requireTopics(config.trajectories, "trajectories", reader);
  for (const std::string& event : config.record_on)
    reader.require(event == "stop" || event == "collision" || event == "invalid", "record_on",
                   "has '" + event + "', which is neither stop, collision nor invalid");
  if (values.valid()) config.parameters = values.toXml();
  const std::string problem = contradictionIn(config.monitor);
  if (!problem.empty()) throw std::invalid_argument(reader.place() + problem);
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
