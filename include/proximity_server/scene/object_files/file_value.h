#pragma once

#include <string>
#include <variant>
#include <vector>

namespace proximity_server::scene {

/// A value as YAML and the parameters of ROS have it, before anybody knows what it means.
struct FileValue {
  struct Member;
  using List = std::vector<FileValue>;
  using Map = std::vector<Member>;  ///< in the order of the text; each name once

  std::variant<std::monostate, bool, double, std::string, List, Map> content;
  int line = 0;  ///< of the text, counted from 1; 0: it comes from no text
};
struct FileValue::Member {
  std::string name;
  FileValue value;
};

/// Reads YAML with one document. Numbers, true, false and null (also ~ and nothing) are what they look like, anything else
/// and what is quoted is a text. Of YAML the anchors, aliases and tags are left out.
///
/// Limit:   10 million values, nested 50 deep.
/// Failure: throws std::invalid_argument naming `source`, the line and the reason: no YAML, two documents, a name twice in
///          a map, a name that is no text, an alias or a tag, beyond a limit.
FileValue readYaml(const std::string& text, const std::string& source);

}  // namespace proximity_server::scene
