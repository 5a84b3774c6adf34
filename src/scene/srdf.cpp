#include "srdf.h"

#include <stdexcept>

#include "input_limits.h"
#include "xml_text.h"

namespace proximity_server {
namespace {

using tinyxml2::XMLElement;

std::string required(const XMLElement& element, const char* name) {
  if (const char* value = element.Attribute(name)) return value;
  throw std::invalid_argument("SRDF, line " + std::to_string(element.GetLineNum()) + ": <" + element.Name() +
                              "> has no attribute " + name);
}

std::string optional(const XMLElement& element, const char* name) {
  const char* value = element.Attribute(name);
  return value ? value : "";
}

/// read(child) for each child of that name, in order.
template <typename Read>
auto readAll(const XMLElement& parent, const char* name, const Read& read) {
  std::vector<decltype(read(parent))> result;
  for (auto* child = parent.FirstChildElement(name); child; child = child->NextSiblingElement(name)) {
    result.push_back(read(*child));
  }
  return result;
}

std::string readName(const XMLElement& element) { return required(element, "name"); }

std::string readLink(const XMLElement& element) { return required(element, "link"); }

Srdf::Names readLinks(const XMLElement& element) { return {required(element, "link1"), required(element, "link2")}; }

Srdf::Names readChain(const XMLElement& element) {
  return {required(element, "base_link"), required(element, "tip_link")};
}

Srdf::DisabledPair readDisabledPair(const XMLElement& element) {
  return {readLinks(element), optional(element, "reason")};
}

Srdf::Group readGroup(const XMLElement& element) {
  Srdf::Group group;
  group.name = readName(element);
  group.links = readAll(element, "link", readName);
  group.joints = readAll(element, "joint", readName);
  group.subgroups = readAll(element, "group", readName);
  group.chains = readAll(element, "chain", readChain);
  return group;
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
  srdf.robot = optional(*robot, "name");
  srdf.disable_collisions = readAll(*robot, "disable_collisions", readDisabledPair);
  srdf.enable_collisions = readAll(*robot, "enable_collisions", readLinks);
  srdf.disable_default_collisions = readAll(*robot, "disable_default_collisions", readLink);
  srdf.virtual_joints = readAll(*robot, "virtual_joint", readName);
  srdf.groups = readAll(*robot, "group", readGroup);
  if (srdf.groups.size() > kMostGroups) {
    throw std::invalid_argument("SRDF: it has " + std::to_string(srdf.groups.size()) + " groups, more than " +
                                std::to_string(kMostGroups));
  }
  return srdf;
}

}  // namespace proximity_server
