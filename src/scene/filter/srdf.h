#pragma once

#include <functional>
#include <string>
#include <utility>
#include <vector>

namespace proximity_server::scene {

/// The collision entries and groups of an SRDF, by name. The names are not checked.
struct Srdf {
  using Names = std::pair<std::string, std::string>;
  struct DisabledPair {
    Names links;
    std::string reason;
  };
  struct Group {
    std::string name;
    std::vector<std::string> links, joints, subgroups;
    std::vector<Names> chains;  ///< base and tip link
  };
  std::string robot;
  std::vector<DisabledPair> disable_collisions;
  std::vector<Names> enable_collisions;
  std::vector<std::string> disable_default_collisions;
  std::vector<std::string> virtual_joints;
  std::vector<Group> groups;
};

/// Reads an SRDF; an empty text is an empty SRDF. Throws std::invalid_argument with the line: for unreadable XML, a
/// missing <robot>, a missing or misspelt attribute, a misspelt element, or a URDF in place of the SRDF.
Srdf readSrdf(const std::string& srdf_xml);

/// Replaces each name of a link, joint or group by rename(name).
void renameAll(Srdf& srdf, const std::function<std::string(const std::string&)>& rename);

/// Adds the entries of another SRDF.
void append(const Srdf& more, Srdf& srdf);

}  // namespace proximity_server::scene
