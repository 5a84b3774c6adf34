// The table of parameters, what the node reads by it, and the files that are made of it: config/PARAMETERS.md,
// config/proximity.yaml and config/Proximity.cfg. With PROXIMITY_WRITE_PARAMETERS set (./dev parameters), the tests
// write these files before they compare them.

#include <proximity_server/ProximityConfig.h>
#include "node/robot/load_config.h"
#include "node/robot/parameter_table.h"
#include "proximity_server/scene/model/names.h"
#include "scene/files.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <limits>
#include <regex>
#include <sstream>
#include <stdexcept>
#include <tuple>
#include <type_traits>

namespace proximity_server::node::parameters_test {

using scene::JointLimits;
using scene::Parameter;
using scene::Range;
using XmlRpc::XmlRpcValue;
using FreeObjects = scene::ObjectRules::FreeObjects;

// ---- The values of fields as YAML has them

std::string yaml(double number) {
  std::string text = scene::shortest(number);
  const std::size_t end = std::min(text.find('e'), text.size());
  return text.find('.') == std::string::npos ? text.insert(end, ".0") : text;  // YAML takes 1e-9 for a text
}
std::string yaml(int number) { return std::to_string(number); }
std::string yaml(bool is_set) { return is_set ? "true" : "false"; }
std::string yaml(FreeObjects free_objects) { return yaml(free_objects == FreeObjects::Checked); }
std::string yaml(const std::string& text) { return text.empty() ? R"("")" : text; }
std::string list(bool is_empty) { return is_empty ? "[]" : "[...]"; }
std::string map(bool is_empty) { return is_empty ? "{}" : "{...}"; }
template <class Entry>
std::string yaml(const std::vector<Entry>& entries) {
  return list(entries.empty());
}
std::string yaml(const scene::ObjectFile& file) { return list(file.objects.empty()); }
std::string yaml(const std::map<std::string, double>& numbers) { return map(numbers.empty()); }
std::string yaml(const JointLimits& limits) {
  return limits.of_all ? yaml(*limits.of_all) : map(limits.of_joint.empty());
}

std::string yaml(const scene::FileValue& value) {
  const auto* number = std::get_if<double>(&value.content);
  if (const auto* text = std::get_if<std::string>(&value.content)) return *text == "off" ? "\"off\"" : *text;
  const auto* entries = std::get_if<scene::FileValue::Map>(&value.content);
  if (const auto* listed = std::get_if<scene::FileValue::List>(&value.content)) return list(listed->empty());
  return number ? yaml(*number) : map(entries && entries->empty());
}

std::string yaml(const Parameter& parameter) {
  return std::visit([](const auto* field) { return yaml(*field); }, parameter.field);
}

// ---- The files

/// Without the marks of code, and with the name of the file that a link leads to.
std::string plain(const std::string& markdown) {
  const std::regex mark("`"), here(R"(\[([^\]]*)\]\(#[^)]*\))"), there(R"(\[([^\]]*)\]\(\.\./([^)#]*)[^)]*\))");
  const std::string text = std::regex_replace(markdown, mark, "");
  return std::regex_replace(std::regex_replace(text, here, "$1 in README.md"), there, "$1 in $2");
}

/// A comment in lines of at most 130 characters.
std::string comment(const std::string& text) {
  std::istringstream words(text);
  std::string result, line = "#";
  for (std::string word; words >> word; line += " " + word) {
    if (line.size() + 1 + word.size() <= 130) continue;
    result += line + "\n";
    line = "#";
  }
  return result + line + "\n";
}

std::string rangeText(const Parameter& parameter) {
  return parameter.range.lowest < parameter.range.highest ? parameter.range.text() : "";
}

std::string changeText(const Parameter& parameter) {
  switch (parameter.change) {
    case Parameter::Change::Live:
      return "live";
    case Parameter::Change::Reload:
      return "reload";
    default:
      return "start";
  }
}

/// The text has links to headings of README.md.
std::string rowOfTable(const Parameter& parameter) {
  const auto cell = [](const std::string& text) { return (text.empty() ? "-" : text) + " | "; };
  return "| `" + parameter.name + "` | `" + yaml(parameter) + "` | " + cell(rangeText(parameter)) +
         cell(parameter.unit) + cell(changeText(parameter)) +
         std::regex_replace(parameter.text, std::regex(R"(\]\(#)"), "](README.md#") + " |\n";
}

std::string entryOfYaml(const Parameter& parameter) {
  const std::string range = rangeText(parameter), unit = parameter.unit.empty() ? "" : " " + parameter.unit;
  const std::string heading =
      parameter.heading.empty() ? "" : "\n" + comment("--- " + plain(parameter.heading) + " ---") + "\n";
  return heading +
         comment(plain(parameter.text) + " (" + (range.empty() ? "" : range + unit + ", ") + changeText(parameter) +
                 ")") +
         parameter.name + ": " + yaml(parameter) + "\n";
}

/// A live parameter can be one of those that dynamic_reconfigure knows.
std::string lineOfCfg(const Parameter& parameter) {
  if (parameter.change != Parameter::Change::Live) return "";
  const std::string unit = parameter.unit.empty() ? "" : "[" + parameter.unit + "] ";
  const std::string text =
      plain(parameter.text.substr(0, std::min(parameter.text.find(". "), parameter.text.size() - 1)));
  const auto line = [&](const std::string& type, const std::string& numbers) {
    return "gen.add(\"" + parameter.name + "\", " + type + ", 0, \"" + unit + text + "\", " + numbers + ")\n";
  };
  const Range& range = parameter.range;
  if (const auto* field = std::get_if<double*>(&parameter.field))
    return line("double_t", yaml(**field) + ", " + yaml(range.lowest) + ", " + yaml(range.highest));
  if (const auto* field = std::get_if<int*>(&parameter.field))
    return line("int_t", yaml(**field) + ", " + scene::shortest(range.lowest) + ", " + scene::shortest(range.highest));
  if (const auto* field = std::get_if<bool*>(&parameter.field)) return line("bool_t", **field ? "True" : "False");
  throw std::logic_error(parameter.name + " has a type that dynamic_reconfigure does not know");
}

/// A file of which the part between two texts is made of the table.
struct MadeFile {
  std::string path, begin, end;
  std::string (*entry)(const Parameter&);
};
const MadeFile kMadeFiles[] = {
    {"config/PARAMETERS.md", "|---|---|---|---|---|---|\n", "", rowOfTable},
    {"config/proximity.yaml", "Lengths are in metres, times in seconds.\n", "", entryOfYaml},
    {"config/Proximity.cfg", "gen = ParameterGenerator()\n", "\nexit(", lineOfCfg},
};

/// The content with its part replaced.
std::string withPart(const std::string& content, const MadeFile& file, const std::string& part) {
  const std::size_t begin = content.find(file.begin);
  if (begin == std::string::npos) throw std::runtime_error(file.path + " lacks the line " + file.begin);
  const std::size_t first = begin + file.begin.size();
  return content.substr(0, first) + part + (file.end.empty() ? "" : content.substr(content.find(file.end, first)));
}

TEST(ParameterFiles, SayWhatTheTableSays) {
  Config config;
  const std::vector<Parameter> table = parameterTable(config);
  for (const MadeFile& file : kMadeFiles) {
    const std::string path = PROXIMITY_SOURCE_DIR "/" + file.path;
    std::string part;
    for (const Parameter& parameter : table) part += file.entry(parameter);
    const std::string wanted = withPart(scene::readFile(path), file, part);
    if (std::getenv("PROXIMITY_WRITE_PARAMETERS")) std::ofstream(path) << wanted;
    const std::string found = scene::readFile(path);
    for (const Parameter& parameter : table) {
      EXPECT_TRUE(found.find(file.entry(parameter)) != std::string::npos)
          << file.path << " differs from the tables of parameters in " << parameter.name
          << "; ./dev parameters writes it";
    }
    EXPECT_EQ(found, wanted) << file.path << "; ./dev parameters writes it";
  }
}

// ---- The node

/// A value of the parameter that sets a number in it, or none if it has no numbers.
XmlRpcValue withNumber(const Parameter& parameter, double number) {
  XmlRpcValue value;
  if (std::holds_alternative<double*>(parameter.field) || std::holds_alternative<JointLimits*>(parameter.field)) {
    value = number;
  } else if (std::holds_alternative<int*>(parameter.field)) {
    value = static_cast<int>(number);
  } else if (std::holds_alternative<std::map<std::string, double>*>(parameter.field)) {
    value["link"] = number;
  } else if (std::holds_alternative<std::vector<std::pair<Parameter::Names, double>>*>(parameter.field)) {
    value[0]["links"][0] = "a";
    value[0]["links"][1] = "b";
    value[0][parameter.name.substr(parameter.name.rfind('_') + 1)] = number;
  }
  return value;
}

/// An allowed value that is not the default.
XmlRpcValue otherValue(const Parameter& parameter) {
  const Range& range = parameter.range;
  double number = (range.lowest + range.highest) / 2.0;
  if (const auto* field = std::get_if<double*>(&parameter.field))
    number = (**field + (**field > range.lowest ? range.lowest : range.highest)) / 2.0;
  XmlRpcValue value = withNumber(parameter, number);
  if (value.valid()) return value;
  if (std::holds_alternative<bool*>(parameter.field) || std::holds_alternative<FreeObjects*>(parameter.field)) {
    value = yaml(parameter) == "false";
  } else if (std::holds_alternative<std::string*>(parameter.field)) {
    value = "/other";
  } else if (std::holds_alternative<std::vector<std::string>*>(parameter.field)) {
    value[0] = parameter.name == "record_on" ? "stop" : "a";
  } else if (std::holds_alternative<std::vector<Parameter::Names>*>(parameter.field)) {
    value[0][0] = "a";
    value[0][1] = "b";
  } else if (parameter.name == "robots") {
    value["left"]["description"] = "a";
  } else if (parameter.name == "tracked") {
    value[0]["topic"] = "/people";
    value[0]["type"] = "PoseArray";
    value[0]["radius"] = 0.3;
  } else if (parameter.name == "sensed") {
    value[0]["topic"] = "/camera/points";
  } else if (parameter.name == "pose_latency") {
    value = "limit";
  } else if (std::holds_alternative<scene::FileValue*>(parameter.field)) {
    value = 0.125;
  } else if (std::holds_alternative<scene::ObjectFile*>(parameter.field)) {
    value[0]["id"] = "ball";
    value[0]["primitives"][0]["type"] = "SPHERE";
    value[0]["primitives"][0]["dimensions"][0] = 0.1;
  }
  return value;
}

/// The names of the parameters that are not at their default.
std::vector<std::string> changesIn(Config config) {
  Config defaults;
  const std::vector<Parameter> table = parameterTable(config), default_table = parameterTable(defaults);
  std::vector<std::string> names;
  for (std::size_t i = 0; i < table.size(); ++i) {
    if (yaml(table[i]) != yaml(default_table[i])) names.push_back(table[i].name);
  }
  return names;
}

Config configWith(const std::string& name, const XmlRpcValue& value) {
  XmlRpcValue values;
  values[name] = value;
  return configFrom(values, "/node");
}

TEST(Parameters, HaveTheirDefaultsIfNothingIsSet) {
  EXPECT_EQ(changesIn(configFrom({}, "/node")), std::vector<std::string>());
}

TEST(Parameters, OfTheNodeAreThoseThatNoToolUses) {
  Config config;
  std::vector<std::string> of_node, of_robot;
  for (const Parameter& parameter : scene::robotParameters(config, config.monitor)) of_robot.push_back(parameter.name);
  for (const Parameter& parameter : parameterTable(config))
    if (std::find(of_robot.begin(), of_robot.end(), parameter.name) == of_robot.end())
      of_node.push_back(parameter.name);
  of_node.erase(std::find(of_node.begin(), of_node.end(), "reference_frame"));  // of objects, too
  of_node.insert(of_node.end(), {"diagnostic_period", "conditional_pairs"});
  std::vector<std::string> known = scene::parametersOfNode();
  std::sort(of_node.begin(), of_node.end());
  std::sort(known.begin(), known.end());
  EXPECT_EQ(known, of_node);
}

TEST(Parameters, SetTheirOwnFieldAndNoOther) {
  Config config;
  for (const Parameter& parameter : parameterTable(config)) {
    EXPECT_EQ(changesIn(configWith(parameter.name, otherValue(parameter))), std::vector<std::string>{parameter.name});
  }
}

TEST(Parameters, AreRefusedByNameOutsideOfTheirRange) {
  Config config;
  int count = 0;
  for (const Parameter& parameter : parameterTable(config)) {
    for (const double number : {parameter.range.lowest - 1.0, parameter.range.highest + 1.0}) {
      const XmlRpcValue value = withNumber(parameter, number);
      if (!value.valid()) continue;
      ++count;
      const std::string refusal = scene::errorOf([&] { configWith(parameter.name, value); });
      EXPECT_EQ(refusal.find("parameter /node/" + parameter.name), 0u) << refusal;
      EXPECT_NE(refusal.find(" is " + scene::shortest(number) + ", outside of " + parameter.range.text()),
                std::string::npos)
          << parameter.name << ": " << refusal;
    }
  }
  EXPECT_GT(count, 40);
}

TEST(Parameters, TakeBothEndsOfTheirRanges) {
  for (double Range::*end : {&Range::lowest, &Range::highest}) {
    Config config;
    XmlRpcValue values;
    for (const Parameter& parameter : parameterTable(config)) {
      const XmlRpcValue value = withNumber(parameter, parameter.range.*end);
      if (value.valid()) values[parameter.name] = value;
    }
    EXPECT_NO_THROW(configFrom(values, "/node"));
  }
}

// ---- Tracked sources

XmlRpcValue people() {
  XmlRpcValue entry;
  entry["topic"] = "/seen/people";
  entry["type"] = "PoseArray";
  entry["radius"] = 0.3;
  return entry;
}

TEST(TrackedParameter, HasANameAndNumbersByDefault) {
  XmlRpcValue list;
  list[0] = people();
  list[1] = people();
  list[1]["name"] = "cart";
  list[1]["type"] = "PointCloud2";
  for (const char* number : {"max_age", "speed", "near_speed", "intrusion", "uncertainty"}) list[1][number] = 0.75;
  const std::vector<TrackedSource> tracked = configWith("tracked", list).tracked;
  ASSERT_EQ(tracked.size(), 2U);
  TrackedSource expected;
  expected.name = "seen/people";
  expected.topic = "/seen/people";
  expected.radius = 0.3;
  EXPECT_EQ(tracked[0], expected);
  EXPECT_EQ(expected.max_age, 0.5);
  EXPECT_EQ(expected.speed, 1.6);
  EXPECT_EQ(expected.near_speed, 2.0);
  expected.name = "cart";
  expected.type = TrackedSource::Type::PointCloud2;
  expected.max_age = expected.speed = expected.near_speed = expected.intrusion = expected.uncertainty = 0.75;
  EXPECT_EQ(tracked[1], expected);
  list[0]["speed"] = 4.0;
  EXPECT_EQ(configWith("tracked", list).tracked[0].near_speed, 5.0);
}

TEST(TrackedParameter, IsRefusedByEntryAndField) {
  const auto refusal = [](const std::string& field, const XmlRpcValue& value) {
    XmlRpcValue list;
    list[0] = people();
    list[1] = people();
    list[1]["name"] = "cart";
    list[1][field] = value;
    return scene::errorOf([&] { configWith("tracked", list); });
  };
  EXPECT_EQ(refusal("radius", 0.3), "");
  const std::tuple<std::string, XmlRpcValue, std::string> kRefusals[] = {
      {"topic", "no topic", " is no name of a topic: 'no topic'"},
      {"type", "LaserScan", " is 'LaserScan', but must be PoseArray or PointCloud2"},
      {"radius", 0.0, " is 0, outside of [0.001, 10]"},
      {"max_age", "old", " must be a number"},
      {"raduis", 1.0, " is unknown: did you mean 'radius'?"},
      {"near_speed", 1.0, " must not be below speed"},
      {"name", "", " is '', no name of an object"},
      {"name", "*", " is '*', no name of an object"},
      {"name", "seen/people", " is 'seen/people', as that of an entry before it"}};
  for (const auto& [field, value, reason] : kRefusals)
    EXPECT_EQ(refusal(field, value), "parameter /node/tracked[1]/" + field + reason);
  EXPECT_EQ(scene::errorOf([] { configWith("tracked", 1.0); }),
            "parameter /node/tracked must be a list of {topic: ..., type: ..., radius: ...}");
  XmlRpcValue of_text;
  of_text[0] = "/people";
  EXPECT_EQ(scene::errorOf([&] { configWith("tracked", of_text); }),
            "parameter /node/tracked[0] must be of the form {topic: /people, type: PoseArray, radius: 0.3}");
  XmlRpcValue without_radius, list;
  without_radius["topic"] = "/people";
  without_radius["type"] = "PoseArray";
  list[0] = without_radius;
  EXPECT_EQ(scene::errorOf([&] { configWith("tracked", list); }),
            "parameter /node/tracked[0]/radius is missing: that of the ball around each point [m]");
}

TEST(SensedParameter, HasANameAndNumbersByDefault) {
  XmlRpcValue people_list, list;
  people_list[0] = people();
  for (const int i : {0, 1}) list[i]["topic"] = "/camera/points";
  list[1]["name"] = "wrist";
  for (const char* number : {"max_age", "resolution", "self_padding", "range", "persistence"}) list[1][number] = 0.25;
  list[1]["clearing"] = false;
  list[1]["max_points"] = 1000;
  list[1]["link_self_padding"]["hand"] = 0.5;
  XmlRpcValue values;
  values["sensed"] = list;
  values["tracked"] = people_list;
  const Config config = configFrom(values, "/node");
  ASSERT_EQ(config.tracked.size(), 3U);
  EXPECT_EQ(config.tracked[0].name, "seen/people") << "those that are tracked come first";
  EXPECT_TRUE(config.isTracking() && config.isSensing());
  TrackedSource expected;
  expected.name = "camera/points";
  expected.topic = "/camera/points";
  expected.type = TrackedSource::Type::PointCloud2;
  expected.sensing.emplace();
  EXPECT_EQ(config.tracked[1], expected);
  EXPECT_EQ(expected.sensing->resolution, 0.02);
  EXPECT_EQ(expected.sensing->self_padding, 0.02);
  expected.name = "wrist";
  expected.max_age = 0.25;
  *expected.sensing = {0.25, 0.25, {{"hand", 0.5}}, 0.25, 0.25, false, 1000};
  EXPECT_EQ(config.tracked[2], expected);
}

TEST(SensedParameter, IsRefusedByEntryAndField) {
  const auto refusal = [](const auto& spoil) {
    XmlRpcValue list;
    list[0]["topic"] = "/camera/points";
    spoil(list);
    return scene::errorOf([&] { configWith("sensed", list); });
  };
  const std::string entry = "parameter /node/sensed[0]";
  EXPECT_EQ(refusal([](XmlRpcValue&) {}), "");
  EXPECT_EQ(refusal([](XmlRpcValue& list) { list = 1.0; }),
            "parameter /node/sensed must be a list of {topic: ..., resolution: ...}");
  EXPECT_EQ(refusal([](XmlRpcValue& list) { list[0] = "/camera"; }),
            entry + " must be of the form {topic: /camera/points, resolution: 0.02}");
  EXPECT_EQ(refusal([](XmlRpcValue& list) { list[0]["topic"] = ""; }), entry + "/topic is no name of a topic: ''");
  EXPECT_EQ(refusal([](XmlRpcValue& list) { list[0]["type"] = "LaserScan"; }),
            entry + "/type is 'LaserScan', but must be PointCloud2 or Octomap");
  const auto map = [](const char* field) {
    return [field](XmlRpcValue& list) {
      list[0]["type"] = "Octomap";
      if (field) list[0][field] = 0.1;
    };
  };
  EXPECT_EQ(refusal(map(nullptr)), "");
  EXPECT_EQ(refusal(map("range")).find(entry + "/range is unknown"), 0U) << "a map has no range";
  EXPECT_EQ(refusal([](XmlRpcValue& list) { list[0]["resolution"] = 0.0; }),
            entry + "/resolution is 0, outside of [0.001, 1]");
  EXPECT_EQ(refusal([](XmlRpcValue& list) { list[0]["link_self_padding"]["hand"] = -1.0; }),
            entry + "/link_self_padding/hand is -1, outside of [0, 10]");
  EXPECT_EQ(refusal([](XmlRpcValue& list) { list[0]["padding"] = 0.1; }).find(entry + "/padding is unknown"), 0U);
  EXPECT_EQ(refusal([](XmlRpcValue& list) { list[1]["topic"] = "/camera/points"; }),
            "parameter /node/sensed[1]/name is 'camera/points', as that of an entry before it");
}

// ---- dynamic_reconfigure

dynamic_reconfigure::Config defaultsOfReconfigure() {
  dynamic_reconfigure::Config message;
  ProximityConfig::__getDefault__().__toMessage__(message);
  return message;
}

TEST(LiveParameters, AreThoseOfDynamicReconfigure) {
  Config config;
  std::vector<std::string> live;
  for (const Parameter& parameter : parameterTable(config)) {
    if (parameter.change == Parameter::Change::Live) live.push_back(parameter.name);
  }
  std::vector<std::string> sent;
  for (const auto& entry : ProximityConfig::__getParamDescriptions__()) sent.push_back(entry->name);
  EXPECT_EQ(sent, live);
  config.monitor = monitorSettingsFrom(defaultsOfReconfigure(), "/node");
  EXPECT_EQ(changesIn(config), std::vector<std::string>());
}

TEST(LiveParameters, AreFieldsOfTheMonitorSettings) {
  Config defaults;
  for (const Parameter& parameter : parameterTable(defaults)) {
    if (parameter.change != Parameter::Change::Live) continue;
    Config config;
    config.monitor = configWith(parameter.name, otherValue(parameter)).monitor;
    EXPECT_EQ(changesIn(config), std::vector<std::string>{parameter.name});
  }
}

TEST(LiveParameters, AreRefusedWithTheReason) {
  const auto refusalOf = [](const std::string& name, double value) {
    dynamic_reconfigure::Config message = defaultsOfReconfigure();
    for (auto& entry : message.doubles) {
      if (entry.name == name) entry.value = value;
    }
    return scene::errorOf([&] { monitorSettingsFrom(message, "/node"); });
  };
  EXPECT_EQ(refusalOf("rate", std::numeric_limits<double>::quiet_NaN()),
            "parameter /node/rate is nan, outside of [0, 1000]");
  EXPECT_EQ(
      refusalOf("object_stop_distance", 0.1),
      "parameter /node/object_stop_distance is 0.1, above object_warn_distance, which is 0.05: the level WARN comes "
      "before STOP");
  EXPECT_EQ(refusalOf("tracked_stop_distance", 0.6),
            "parameter /node/tracked_stop_distance is 0.6, above tracked_warn_distance, which is 0.5: the level WARN "
            "comes before STOP");
}

}  // namespace proximity_server::node::parameters_test
