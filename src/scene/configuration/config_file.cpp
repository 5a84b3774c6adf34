#include "proximity_server/scene/configuration/robot_config.h"
#include "proximity_server/scene/model/names.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

namespace proximity_server::scene {
namespace {

bool hasName(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

bool hasOneOf(const FileValue::Map& members, const std::vector<std::string>& names) {
  return std::any_of(members.begin(), members.end(),
                     [&](const FileValue::Member& member) { return hasName(names, member.name); });
}

/// Finds the maps that have parameters of a robot, none below another one.
void findParameters(const FileValue& value, const std::vector<std::string>& of_robot,
                    std::vector<const FileValue*>& found) {
  const auto* const members = std::get_if<FileValue::Map>(&value.content);
  if (!members) return;
  if (hasOneOf(*members, of_robot)) return found.push_back(&value);
  for (const FileValue::Member& member : *members) findParameters(member.value, of_robot, found);
}

/// The map with the parameters of the node: the value itself, or the only one below it, as in a dump of all parameters.
const FileValue& parametersIn(const FileValue& value, const std::vector<std::string>& of_robot,
                              const std::string& source) {
  std::vector<const FileValue*> found;
  findParameters(value, of_robot, found);
  if (found.size() > 1)
    throw std::invalid_argument(source + ": lines " + std::to_string(found[0]->line) + " and " +
                                std::to_string(found[1]->line) +
                                " both begin parameters of a node; rosparam dump FILE /NODE writes those of one");
  if (!found.empty()) return *found.front();
  const auto* const members = std::get_if<FileValue::Map>(&value.content);
  if (members && hasOneOf(*members, parametersOfNode())) return value;
  throw std::invalid_argument(source + ": there is no parameter of the node in it");
}

/// Reads the rows that the file has.
void readBy(const std::vector<Parameter>& rows, ParameterReader& reader, const ConfigFile& file) {
  for (const Parameter& row : rows) reader.read(row);
  const std::string problem = contradictionIn(file.levels);
  if (!problem.empty()) throw std::invalid_argument(reader.place() + problem);
}

}  // namespace

ConfigFile configFrom(const std::string& yaml, const std::string& source, const std::string& folder) {
  ConfigFile file;
  const std::vector<Parameter> rows = robotParameters(file.robot, file.levels);
  const FileValue text = readYaml(yaml, source);
  ParameterReader reader(parametersIn(text, namesOf(rows), source), source, folder);
  reader.require(!reader.isSet("robots"), "robots", "describes several robots, but the URDF is one");
  readBy(rows, reader, file);
  std::string reference_frame;  // a link, as there is no tf
  reader.read("reference_frame", reference_frame);
  for (ObjectEdit& object : file.robot.objects.objects)
    if (object.place.link.empty() && object.place.frame.empty()) object.place.frame = reference_frame;
  std::vector<std::string> skipped;
  for (const std::string& name : reader.unknown()) {
    if (hasName(parametersOfNode(), name))
      skipped.push_back(name);
    else
      file.warnings.push_back(source + ": parameter " + unknownName(name, reader.known()) + " has no effect");
  }
  if (!skipped.empty())
    file.warnings.push_back(source + ": only a running node uses " + listed(skipped, skipped.size()));
  return file;
}

ConfigFile thresholdsFrom(const std::string& yaml, const std::string& source) {
  ConfigFile file;
  std::vector<Parameter> rows = robotParameters(file.robot, file.levels);
  const auto isOfLevel = [](const Parameter& row) {
    return row.name.find("stop_distance") != std::string::npos || row.name.find("warn_distance") != std::string::npos;
  };
  rows.erase(std::remove_if(rows.begin(), rows.end(), [&](const Parameter& row) { return !isOfLevel(row); }),
             rows.end());
  const FileValue text = readYaml(yaml, source);
  if (!std::holds_alternative<FileValue::Map>(text.content))
    throw std::invalid_argument(source + ": must map names to distances");
  ParameterReader reader(text, source);
  readBy(rows, reader, file);
  for (const std::string& name : reader.unknown())
    reader.require(false, name, "is unknown" + didYouMean(name, reader.known()));
  return file;
}

}  // namespace proximity_server::scene
