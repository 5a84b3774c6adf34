// Each parameter stands in five places: src/node/robot/config.h and config.cpp (what the node does), config/Proximity.cfg
// (the live ones, for dynamic_reconfigure), config/proximity.yaml and the table of config/README.md (the documents).
// The table is compared with the four others: names, defaults, ranges.

#include <gtest/gtest.h>
#include <proximity_server/ProximityConfig.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>
#include <map>
#include <optional>
#include <regex>
#include <sstream>
#include <stdexcept>

#include "node/robot/config.h"

namespace proximity_server::node::parameters_test {

using XmlRpc::XmlRpcValue;

struct Range {
  double lowest, highest;
  bool operator==(const Range& other) const { return lowest == other.lowest && highest == other.highest; }
};
std::ostream& operator<<(std::ostream& stream, const Range& range) {
  return stream << "[" << range.lowest << ", " << range.highest << "]";
}

/// What a document says of a parameter.
struct Documented {
  std::string value;  ///< the default, as YAML
  std::optional<Range> range;
  bool is_live = false;  ///< of the table only
};
using Document = std::map<std::string, Documented>;

/// The first interval of two numbers in a text.
std::optional<Range> rangeIn(const std::string& text) {
  const std::regex interval(R"(\[(-?[0-9.]+(?:e[-+]?\d+)?), (-?[0-9.]+(?:e[-+]?\d+)?)\])");
  std::smatch found;
  if (!std::regex_search(text, found, interval)) return std::nullopt;
  return Range{std::stod(found[1]), std::stod(found[2])};
}

std::ifstream open(const std::string& path) {
  std::ifstream file(PROXIMITY_SOURCE_DIR "/" + path);
  if (!file) throw std::runtime_error("cannot read " + path);
  return file;
}

/// The rows `name` | `default` | range | unit | live | meaning.
Document table() {
  std::ifstream file = open("config/README.md");
  const std::regex row(R"(\| `(\w+)` \| `([^`]*)` \| ([^|]*) \| ([^|]*) \| (\w+) \| .*)");
  Document document;
  std::smatch cell;
  for (std::string line; std::getline(file, line);) {
    if (std::regex_match(line, cell, row)) document[cell[1]] = {cell[2], rangeIn(cell[3]), cell[5] == "yes"};
  }
  return document;
}

/// The lines "name: default". The range is in the comment above them, which may be that of several names.
Document yaml() {
  std::ifstream file = open("config/proximity.yaml");
  const std::regex entry(R"((\w+): (.+))");
  Document document;
  std::smatch part;
  std::string comment;
  bool comment_goes_on = false;
  for (std::string line; std::getline(file, line);) {
    const bool is_comment = line.rfind('#', 0) == 0;
    if (is_comment) comment = comment_goes_on ? comment + line : line;
    comment_goes_on = is_comment;
    if (std::regex_match(line, part, entry)) document[part[1]] = {part[2], rangeIn(comment)};
  }
  return document;
}

/// A default of a document, with the type that YAML gives it.
XmlRpcValue valueOf(const std::string& text) {
  XmlRpcValue value;
  if (text == "[]") {
    value.setSize(0);
  } else if (text == "{}") {
    value.begin();  // makes it a struct
  } else if (text == "true" || text == "false") {
    value = XmlRpcValue(text == "true");
  } else if (std::regex_match(text, std::regex(R"(-?\d+)"))) {
    value = std::stoi(text);
  } else if (std::regex_match(text, std::regex(R"(-?\d[\d.]*(e[-+]?\d+)?)"))) {
    value = std::stod(text);
  } else {
    value = text == R"("")" ? std::string() : text;
  }
  return value;
}

/// All that the parameters set, as text.
std::string contentOf(const Config& config) {
  std::ostringstream text;
  text.precision(17);
  const auto addNames = [&](const std::pair<std::string, std::string>& names) {
    text << names.first << '-' << names.second << ' ';
  };
  const auto addLengths = [&](const std::map<std::string, double>& lengths) {
    for (const auto& [name, length] : lengths) text << name << '=' << length << ' ';
    text << ';';
  };
  for (const auto* list : {&config.mesh_roots, &config.allowed_mesh_roots}) {
    for (const std::string& entry : *list) text << entry << ' ';
    text << ';';
  }
  addLengths(config.model.link_mesh_tolerance);
  addLengths(config.model.link_padding);
  addLengths(config.max_deceleration.of_joint);
  for (const auto& [names, length] : config.filter.pair_padding) {
    addNames(names);
    text << length << ' ';
  }
  for (const auto* list : {&config.filter.exclude_pairs, &config.filter.only_pairs}) {
    for (const auto& names : *list) addNames(names);
    text << ';';
  }
  for (const std::string& word :
       {config.robot_description, config.semantic_description, config.reference_frame, config.tf_prefix,
        config.model.mesh_cache, config.filter.group, config.objects_file}) {
    text << word << ';';
  }
  for (const RobotSource& robot : config.robots) {
    for (const std::string& word : {robot.name, robot.description, robot.semantic, robot.tf_prefix, robot.joint_states})
      text << word << ';';
  }
  const MonitorSettings& monitor = config.monitor;
  for (const double number : {config.model.mesh_tolerance,
                              config.model.mesh_time_budget,
                              config.model.default_padding,
                              config.tolerance,
                              config.max_tf_age,
                              config.max_tf_skew,
                              config.tf_timeout,
                              config.max_request_time,
                              config.motion_time_budget,
                              monitor.rate,
                              monitor.threshold,
                              monitor.warn_distance,
                              monitor.stop_distance,
                              monitor.object_warn_distance,
                              monitor.object_stop_distance,
                              monitor.hysteresis,
                              monitor.lookahead,
                              monitor.influence_distance,
                              monitor.damping_gain,
                              monitor.stop_latency,
                              config.max_deceleration.of_all.value_or(0.0)}) {
    text << number << ' ';
  }
  text << config.max_batch << ' ' << config.realtime_priority << ' ' << monitor.max_reported_pairs << ' '
       << monitor.markers << ' ' << monitor.gradients << ' ' << monitor.max_constraints << ' '
       << config.model.allow_missing_meshes << ' ' << static_cast<int>(config.free_objects)
       << scene::yamlOf(config.objects);
  return text.str();
}

Config configWith(const std::string& name, const XmlRpcValue& value) {
  XmlRpcValue values;
  values[name] = value;
  return configFrom(values, "/node");
}

/// A value of a parameter that sets a number somewhere in it, of the form that the default has.
XmlRpcValue withNumber(const std::string& default_value, double number) {
  XmlRpcValue value = valueOf(default_value);
  if (value.getType() == XmlRpcValue::TypeInt) {
    value = static_cast<int>(number);
  } else if (value.getType() == XmlRpcValue::TypeStruct) {
    value["link"] = number;
  } else if (value.getType() == XmlRpcValue::TypeArray) {
    value[0]["links"][0] = "a";
    value[0]["links"][1] = "b";
    value[0]["padding"] = number;
  } else {
    value = number;
  }
  return value;
}

XmlRpcValue oneObject() {
  XmlRpcValue objects;
  objects[0]["id"] = "ball";
  objects[0]["primitives"][0]["type"] = "SPHERE";
  objects[0]["primitives"][0]["dimensions"][0] = 0.1;
  return objects;
}

/// Values of a parameter of which at least one is allowed and not the default.
std::vector<XmlRpcValue> otherValues(const std::string& name, const Documented& documented) {
  if (documented.range) {
    return {withNumber(documented.value, documented.range->lowest),
            withNumber(documented.value, documented.range->highest)};
  }
  XmlRpcValue value = valueOf(documented.value);
  if (value.getType() == XmlRpcValue::TypeBoolean) return {XmlRpcValue(!static_cast<bool>(value))};
  if (value.getType() == XmlRpcValue::TypeString) return {"other", "/other"};
  if (name == "objects") return {oneObject()};
  if (value.getType() == XmlRpcValue::TypeStruct) {
    value["left"]["description"] = "a";
    return {value};
  }
  const bool is_of_pairs = name.find("pairs") != std::string::npos;
  (is_of_pairs ? value[0][0] : value[0]) = "a";
  if (is_of_pairs) value[0][1] = "b";
  return {value};
}

/// Whether the node takes this value, and contentOf() shows it.
bool isSeen(const std::string& name, const XmlRpcValue& value) {
  try {
    return contentOf(configWith(name, value)) != contentOf(configFrom({}, "/node"));
  } catch (const std::invalid_argument&) {
    return false;  // stop_distance is at most warn_distance
  }
}

/// The range of a parameter in the words of the node, which refuses a number below it; nullopt if it is taken.
std::optional<Range> rangeOfNode(const std::string& name, const std::string& default_value) {
  try {
    configWith(name, withNumber(default_value, std::numeric_limits<int>::min()));
  } catch (const std::invalid_argument& refusal) {
    const std::string text = std::regex_replace(refusal.what(), std::regex(R"(e\+)"), "e");
    return text.find("parameter /node/" + name) == 0 ? rangeIn(text) : std::nullopt;
  }
  return std::nullopt;
}

template <typename Map>
std::vector<std::string> namesOf(const Map& map) {
  std::vector<std::string> names;
  for (const auto& [name, rest] : map) names.push_back(name);
  return names;
}

TEST(Parameters, ThatTheNodeReadsAreThoseOfTheTable) {
  std::vector<std::string> names = parameterNames();
  std::sort(names.begin(), names.end());
  EXPECT_EQ(names, namesOf(table()));
}

TEST(Parameters, ThatTheNodeReadsHaveTheDefaultsOfTheTable) {
  const std::string defaults = contentOf(configFrom({}, "/node"));
  for (const auto& [name, documented] : table()) {
    EXPECT_EQ(contentOf(configWith(name, valueOf(documented.value))), defaults) << name;
  }
}

// Else the test above would not see a wrong default.
TEST(Parameters, EachChangeWhatIsCompared) {
  for (const auto& [name, documented] : table()) {
    const std::vector<XmlRpcValue> values = otherValues(name, documented);
    EXPECT_TRUE(std::any_of(values.begin(), values.end(), [&n = name](const auto& value) { return isSeen(n, value); }))
        << name;
  }
}

TEST(Parameters, ThatTheNodeReadsHaveTheRangesOfTheTable) {
  int count = 0;
  for (const auto& [name, documented] : table()) {
    const XmlRpcValue::Type type = valueOf(documented.value).getType();
    const bool is_number = type == XmlRpcValue::TypeInt || type == XmlRpcValue::TypeDouble;
    EXPECT_TRUE(documented.range || !is_number) << name << " has no range in the table";
    if (!documented.range) continue;
    ++count;
    EXPECT_EQ(rangeOfNode(name, documented.value), documented.range) << name;
  }
  EXPECT_GT(count, 15);
}

TEST(Parameters, OfTheYamlFileAreThoseOfTheTable) {
  const Document rows = table(), entries = yaml();
  ASSERT_EQ(namesOf(entries), namesOf(rows));
  for (const auto& [name, documented] : rows) {
    const Documented& entry = entries.at(name);
    EXPECT_TRUE(valueOf(entry.value) == valueOf(documented.value)) << name << ": " << entry.value;
    EXPECT_EQ(entry.range, documented.range) << name;
  }
}

// ---- dynamic_reconfigure

/// What the generated code says of a live parameter; true and false are 1 and 0.
struct Live {
  double value, lowest, highest;
};
std::map<std::string, Live> liveParameters() {
  const dynamic_reconfigure::ConfigDescription description = ProximityConfig::__getDescriptionMessage__();
  std::map<std::string, Live> live;
  const auto add = [&](const auto& values, double Live::*field) {
    for (const auto& entry : values) live[entry.name].*field = entry.value;
  };
  for (const auto& [config, field] : {std::pair{&description.dflt, &Live::value},
                                      {&description.min, &Live::lowest},
                                      {&description.max, &Live::highest}}) {
    add(config->doubles, field);
    add(config->ints, field);
    add(config->bools, field);
  }
  return live;
}

TEST(Parameters, OfDynamicReconfigureAreTheLiveOnesOfTheTable) {
  Document rows = table();
  for (auto row = rows.begin(); row != rows.end();) row = row->second.is_live ? std::next(row) : rows.erase(row);
  const std::map<std::string, Live> live = liveParameters();
  ASSERT_EQ(namesOf(live), namesOf(rows));
  EXPECT_GT(rows.size(), 5u);
  for (const auto& [name, documented] : rows) {
    XmlRpcValue value = valueOf(documented.value);
    const double number =
        value.getType() == XmlRpcValue::TypeBoolean ? static_cast<bool>(value) : std::stod(documented.value);
    EXPECT_EQ(live.at(name).value, number) << name;
    const Range booleans{0.0, 1.0};
    EXPECT_EQ((Range{live.at(name).lowest, live.at(name).highest}), documented.range.value_or(booleans)) << name;
  }
}

}  // namespace proximity_server::node::parameters_test
