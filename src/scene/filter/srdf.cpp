#include "scene/filter/srdf.h"

#include "proximity_server/scene/filter/srdf_reason.h"
#include "proximity_server/scene/model/names.h"
#include "scene/files/xml_text.h"
#include "scene/mesh/input_limits.h"

#include <algorithm>
#include <initializer_list>
#include <stdexcept>

namespace proximity_server::scene {
namespace {

using tinyxml2::XMLElement;

[[noreturn]] void fail(const XMLElement& element, const std::string& what) {
  throw std::invalid_argument("SRDF, line " + std::to_string(element.GetLineNum()) + ": " + what);
}

/// Refuses misspelt child elements, which would have no effect.
void refuseMisspeltChildren(const XMLElement& parent, const std::vector<std::string>& known) {
  for (auto* child = parent.FirstChildElement(); child; child = child->NextSiblingElement()) {
    const std::string meant = misspelledName(child->Name(), known);
    if (!meant.empty())
      fail(*child, "unknown element <" + std::string(child->Name()) + ">, did you mean <" + meant + ">?");
  }
}

/// Refuses misspelt attributes of an element.
void refuseMisspeltAttributes(const XMLElement& element, const std::vector<std::string>& known) {
  for (auto* attribute = element.FirstAttribute(); attribute; attribute = attribute->Next()) {
    const std::string meant = misspelledName(attribute->Name(), known);
    if (meant.empty() || element.Attribute(meant.c_str())) continue;
    fail(element, "<" + std::string(element.Name()) + "> has the unknown attribute " + attribute->Name() +
                      ", did you mean " + meant + "?");
  }
}

std::string required(const XMLElement& element, const char* name) {
  if (const char* value = element.Attribute(name)) return value;
  fail(element, "<" + std::string(element.Name()) + "> has no attribute " + name);
}

std::string optional(const XMLElement& element, const char* name) {
  const char* value = element.Attribute(name);
  return value ? value : "";
}

/// Calls read(child) for each child of that name, in order, and returns the results.
template <typename Read>
auto readAll(const XMLElement& parent, const char* name, const Read& read) {
  std::vector<decltype(read(parent))> result;
  for (auto* child = parent.FirstChildElement(name); child; child = child->NextSiblingElement(name)) {
    result.push_back(read(*child));
  }
  return result;
}

std::string readName(const XMLElement& element) {
  refuseMisspeltAttributes(element, {"name"});
  return required(element, "name");
}

std::string readLink(const XMLElement& element) {
  refuseMisspeltAttributes(element, {"link"});
  return required(element, "link");
}

Srdf::Names readLinks(const XMLElement& element) {
  refuseMisspeltAttributes(element, {"link1", "link2", "reason"});
  return {required(element, "link1"), required(element, "link2")};
}

Srdf::Names readChain(const XMLElement& element) {
  refuseMisspeltAttributes(element, {"base_link", "tip_link"});
  return {required(element, "base_link"), required(element, "tip_link")};
}

Srdf::DisabledPair readDisabledPair(const XMLElement& element) {
  return {readLinks(element), optional(element, "reason")};
}

Srdf::Group readGroup(const XMLElement& element) {
  refuseMisspeltChildren(element, {"link", "joint", "chain", "group"});
  Srdf::Group group;
  group.name = readName(element);
  group.links = readAll(element, "link", readName);
  group.joints = readAll(element, "joint", readName);
  group.subgroups = readAll(element, "group", readName);
  group.chains = readAll(element, "chain", readChain);
  return group;
}

template <typename Thing>
void appendAll(const std::vector<Thing>& more, std::vector<Thing>& things) {
  things.insert(things.end(), more.begin(), more.end());
}

/// Returns the first element that shows that the text is a URDF, or nullptr: a joint with a parent and a child, or a
/// link with geometry or inertia. Neither can be directly below the <robot> of an SRDF, which has <joint> and <link>
/// only inside its groups.
const XMLElement* findUrdfElement(const XMLElement& robot) {
  const auto hasAny = [](const XMLElement& element, std::initializer_list<const char*> names) {
    return std::any_of(names.begin(), names.end(), [&](const char* name) { return element.FirstChildElement(name); });
  };
  for (auto* child = robot.FirstChildElement(); child; child = child->NextSiblingElement()) {
    const std::string name = child->Name();
    if (name == "link" && hasAny(*child, {"collision", "visual", "inertial"})) return child;
    if (name == "joint" && hasAny(*child, {"parent"}) && hasAny(*child, {"child"})) return child;
  }
  return nullptr;
}

/// True if the SRDF has any entry that this package reads.
bool saysAnything(const Srdf& srdf) {
  return !srdf.disable_collisions.empty() || !srdf.enable_collisions.empty() ||
         !srdf.disable_default_collisions.empty() || !srdf.virtual_joints.empty() || !srdf.groups.empty();
}

void refuseUrdf(const XMLElement& robot, const Srdf& srdf) {
  // A file that is both is odd, but it tells which pairs it means.
  const XMLElement* element = saysAnything(srdf) ? nullptr : findUrdfElement(robot);
  if (!element) return;
  fail(*element, "this is a URDF: it describes the " + std::string(element->Name()) + " " +
                     quoted(optional(*element, "name")) +
                     ", and has nothing that an SRDF has (disable_collisions, groups)");
}

}  // namespace

Srdf readSrdf(const std::string& srdf_xml) {
  Srdf srdf;
  if (srdf_xml.empty()) return srdf;
  tinyxml2::XMLDocument document;
  try {
    parseXml(srdf_xml, document);
  } catch (const std::invalid_argument& error) {
    throw std::invalid_argument(std::string("SRDF: ") + error.what());
  }
  const XMLElement* robot = document.FirstChildElement("robot");
  if (!robot) throw std::invalid_argument("SRDF: no <robot> element");
  refuseMisspeltChildren(
      *robot, {"disable_collisions", "enable_collisions", "disable_default_collisions", "virtual_joint", "group"});
  srdf.robot = optional(*robot, "name");
  srdf.disable_collisions = readAll(*robot, "disable_collisions", readDisabledPair);
  srdf.enable_collisions = readAll(*robot, "enable_collisions", readLinks);
  srdf.disable_default_collisions = readAll(*robot, "disable_default_collisions", readLink);
  srdf.virtual_joints = readAll(*robot, "virtual_joint", readName);
  srdf.groups = readAll(*robot, "group", readGroup);
  if (srdf.groups.size() > kMaxGroups) {
    throw std::invalid_argument("SRDF: it has " + std::to_string(srdf.groups.size()) + " groups, more than " +
                                std::to_string(kMaxGroups));
  }
  refuseUrdf(*robot, srdf);
  return srdf;
}

bool isDecision(const std::string& srdf_reason) { return srdf_reason.compare(0, 6, "User: ") == 0; }

void renameAll(Srdf& srdf, const std::function<std::string(const std::string&)>& rename) {
  const auto each = [&](std::vector<std::string>& names) {
    for (std::string& name : names) name = rename(name);
  };
  const auto both = [&](Srdf::Names& names) { names = {rename(names.first), rename(names.second)}; };
  for (Srdf::DisabledPair& pair : srdf.disable_collisions) both(pair.links);
  for (Srdf::Names& names : srdf.enable_collisions) both(names);
  each(srdf.disable_default_collisions);
  each(srdf.virtual_joints);
  for (Srdf::Group& group : srdf.groups) {
    group.name = rename(group.name);
    for (std::vector<std::string>* names : {&group.links, &group.joints, &group.subgroups}) each(*names);
    for (Srdf::Names& chain : group.chains) both(chain);
  }
}

void append(const Srdf& more, Srdf& srdf) {
  appendAll(more.disable_collisions, srdf.disable_collisions);
  appendAll(more.enable_collisions, srdf.enable_collisions);
  appendAll(more.disable_default_collisions, srdf.disable_default_collisions);
  appendAll(more.virtual_joints, srdf.virtual_joints);
  appendAll(more.groups, srdf.groups);
}

}  // namespace proximity_server::scene
