#pragma once

#include <string>
#include <variant>
#include <vector>

namespace proximity_server::scene {

/// A value of YAML or of the parameters of ROS, before its meaning is known.
struct FileValue {
  struct Member;
  using List = std::vector<FileValue>;
  using Map = std::vector<Member>;  ///< in the order of the text; each name once

  std::variant<std::monostate, bool, double, std::string, List, Map> content;
  int line = 0;  ///< the line of the text, counted from 1; 0 if there is no text
};
struct FileValue::Member {
  std::string name;
  FileValue value;
};

/// Reads YAML with one document. Numbers, true, false and null (also ~ and an empty value) have their usual meaning;
/// all other and all quoted values are texts. Anchors, aliases and tags of YAML are refused.
///
/// It makes the values from the events of libyaml: 0.7 s and 126 MB for a mesh of 200,000 triangles. With the events of
/// yaml-cpp (0.6, 0.7) it takes 3.1 s and 465 MB, and YAML::Load() 5.7 s and 821 MB, which accepts a name twice in a map.
///
/// Limit:   10 million values, nested 50 deep.
/// Failure: throws std::invalid_argument with `source`, the line and the reason: not YAML, two documents, a name twice
///          in a map, a name that is not a text, an alias or a tag, beyond a limit.
FileValue readYaml(const std::string& text, const std::string& source);

/// A name in YAML: in quotes if YAML would take it for something else.
std::string yamlName(const std::string& name);

}  // namespace proximity_server::scene
