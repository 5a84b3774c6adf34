#include "scene/loading/urdf_document.h"

#include "proximity_server/scene/loading/model_options.h"
#include "proximity_server/scene/model/names.h"
#include "scene/files/xml_text.h"
#include "scene/mesh/input_limits.h"

#include <console_bridge/console.h>
#include <tinyxml2.h>
#include <urdf_parser/urdf_parser.h>

#include <algorithm>
#include <map>
#include <mutex>
#include <stdexcept>
#include <vector>

namespace proximity_server::scene {
namespace {

using tinyxml2::XMLElement;

[[noreturn]] void fail(const std::string& why) { throw std::invalid_argument("URDF: " + why); }

std::string attribute(const XMLElement& element, const char* name) {
  const char* value = element.Attribute(name);
  return value ? value : "";
}

/// While it exists, it keeps urdfdom's errors from the console. The logger of urdfdom is global, so only one reader
/// runs at a time.
class UrdfdomErrors : console_bridge::OutputHandler {
 public:
  UrdfdomErrors() : alone_(mutex_) { console_bridge::useOutputHandler(this); }
  ~UrdfdomErrors() override { console_bridge::restorePreviousOutputHandler(); }

  /// The errors; "" if there were none.
  const std::string& text() const { return text_; }

 private:
  void log(const std::string& text, console_bridge::LogLevel level, const char* /*file*/, int /*line*/) override {
    if (level < console_bridge::CONSOLE_BRIDGE_LOG_ERROR) return;
    text_ += (text_.empty() ? "" : "; ") + text;
  }

  static std::mutex mutex_;
  std::lock_guard<std::mutex> alone_;
  std::string text_;
};
std::mutex UrdfdomErrors::mutex_;

bool isOneOf(const std::string& name, const std::vector<std::string>& names) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

/// Removes all other elements, and all nodes that are not elements: texts, comments.
void keepOnly(XMLElement& parent, const std::vector<std::string>& names) {
  tinyxml2::XMLNode* next = nullptr;
  for (tinyxml2::XMLNode* child = parent.FirstChild(); child; child = next) {
    next = child->NextSibling();
    const bool is_kept = child->ToElement() && isOneOf(child->Value(), names);
    if (!is_kept) parent.DeleteChild(child);
  }
}

/// True if the element or one inside of it has one of these names.
bool holds(const XMLElement& element, const std::vector<std::string>& names) {
  if (isOneOf(element.Name(), names)) return true;
  for (auto* child = element.FirstChildElement(); child; child = child->NextSiblingElement()) {
    if (holds(*child, names)) return true;
  }
  return false;
}

/// Adds a warning about each element of `parent` that urdfdom ignores silently although it holds geometry, links or
/// joints.
void warnOfDropped(const XMLElement& parent, const std::string& where, const std::vector<std::string>& known,
                   std::vector<std::string>& warnings) {
  for (auto* child = parent.FirstChildElement(); child; child = child->NextSiblingElement()) {
    if (isOneOf(child->Name(), known) || !holds(*child, {"link", "joint", "collision", "geometry"})) continue;
    warnings.push_back(where + "the element <" + child->Name() + ">, line " + std::to_string(child->GetLineNum()) +
                       ", is no part of a URDF and is ignored with all that is in it.");
  }
}

void refuseXacro(const XMLElement& robot) {
  for (auto* child = robot.FirstChildElement(); child; child = child->NextSiblingElement()) {
    const std::string name = child->Name();
    if (name.compare(0, 6, "xacro:") != 0) continue;
    fail("line " + std::to_string(child->GetLineNum()) + ": <" + name +
         ">: this is a xacro file; run xacro on it and take the URDF that it prints");
  }
}

int count(const XMLElement* parent, const char* name = nullptr) {
  int n = 0;
  for (auto* child = parent ? parent->FirstChildElement(name) : nullptr; child;
       child = child->NextSiblingElement(name)) {
    ++n;
  }
  return n;
}

void checkNumber(const XMLElement& robot, const char* name) {
  const int number = count(&robot, name);
  if (number <= kMaxLinks) return;
  fail("the robot has " + std::to_string(number) + " " + name + "s, more than " + std::to_string(kMaxLinks));
}

/// urdfdom would take the first of several shapes or origins.
void checkCollision(const XMLElement& collision, const std::string& where) {
  if (count(&collision, "geometry") != 1) fail(where + ": expected one <geometry>");
  if (count(collision.FirstChildElement("geometry")) != 1) fail(where + ": expected one shape in its <geometry>");
  if (count(&collision, "origin") > 1) fail(where + ": more than one <origin>");
}

/// urdfdom ignores an element with a misspelt name.
void checkLink(const XMLElement& link) {
  const std::string name = attribute(link, "name");
  if (name.empty()) fail("a link without a name, line " + std::to_string(link.GetLineNum()));
  const std::string where = "link " + quoted(name) + ", ";
  int number = 0;
  for (auto* child = link.FirstChildElement(); child; child = child->NextSiblingElement()) {
    const int misspelling = editDistance(child->Name(), "collision");
    if (misspelling == 0) checkCollision(*child, where + "<collision> " + std::to_string(++number));
    if (misspelling == 1 || misspelling == 2) {
      fail(where + "unknown element <" + child->Name() + ">, did you mean <collision>?");
    }
  }
}

/// Makes the visual geometry of the link its collision geometry, if that is wanted.
void takeVisual(XMLElement& link, FromVisual& visuals) {
  if (!link.FirstChildElement("visual")) return;
  ++visuals.seen;
  if (link.FirstChildElement("collision")) return;
  const std::string name = attribute(link, "name");
  if (!isOneOf(name, visuals.wanted) && !isOneOf(kAllLinks, visuals.wanted)) return visuals.only_seen.push_back(name);
  visuals.taken.insert(name);
  while (XMLElement* const visual = link.FirstChildElement("visual")) visual->SetName("collision");
}

/// urdfdom passes a text that it cannot read as a number to printf, as the format.
void checkNumbers(const XMLElement& element, const std::string& where) {
  static const std::vector<std::string> kNames = {"name", "type", "link", "joint", "filename"};
  for (auto* attribute = element.FirstAttribute(); attribute; attribute = attribute->Next()) {
    const std::string value = attribute->Value();
    if (!isOneOf(attribute->Name(), kNames) && value.find('%') != std::string::npos) {
      fail(where + ": " + attribute->Name() + " " + quoted(value) + " is not numeric");
    }
  }
  for (auto* child = element.FirstChildElement(); child; child = child->NextSiblingElement()) {
    checkNumbers(*child, where);
  }
}

std::string linkOf(const XMLElement& joint, const char* end) {
  const XMLElement* element = joint.FirstChildElement(end);
  return element ? attribute(*element, "link") : "";
}

/// urdfdom never frees links that form a loop.
void checkTree(const XMLElement& robot) {
  std::map<std::string, std::string> parent_of;
  for (auto* joint = robot.FirstChildElement("joint"); joint; joint = joint->NextSiblingElement("joint")) {
    const std::string child = linkOf(*joint, "child");
    if (child.empty()) continue;  // urdfdom reports this error
    if (!parent_of.emplace(child, linkOf(*joint, "parent")).second) {
      fail("link " + quoted(child) + " is the child of two joints, one of them " + quoted(attribute(*joint, "name")));
    }
  }
  for (const auto& [link, parent] : parent_of) {
    auto above = parent_of.find(parent);
    for (std::size_t steps = 0; above != parent_of.end(); ++steps) {
      if (steps == parent_of.size()) fail("link " + quoted(link) + " hangs in a loop of joints, not on the root");
      above = parent_of.find(above->second);
    }
  }
}

}  // namespace

urdf::ModelInterfaceSharedPtr readUrdf(const std::string& urdf_xml, FromVisual& visuals,
                                       std::vector<std::string>& warnings) {
  tinyxml2::XMLDocument document;
  try {
    parseXml(urdf_xml, document);
  } catch (const std::invalid_argument& error) {
    fail(error.what());
  }
  XMLElement* robot = document.FirstChildElement("robot");
  if (!robot) fail("no <robot> element");
  refuseXacro(*robot);
  warnOfDropped(*robot, "", {"link", "joint", "material", "transmission", "gazebo"}, warnings);
  checkNumber(*robot, "link");
  checkNumber(*robot, "joint");
  if (count(robot, "link") == 0) fail("the robot has no links");
  for (auto* link = robot->FirstChildElement("link"); link; link = link->NextSiblingElement("link")) {
    takeVisual(*link, visuals);
    checkLink(*link);
    warnOfDropped(*link, "link " + quoted(attribute(*link, "name")) + ": ", {"collision", "visual", "inertial"},
                  warnings);
    keepOnly(*link, {"collision"});
    checkNumbers(*link, "link " + quoted(attribute(*link, "name")));
  }
  keepOnly(*robot, {"link", "joint"});
  for (auto* joint = robot->FirstChildElement("joint"); joint; joint = joint->NextSiblingElement("joint")) {
    keepOnly(*joint, {"origin", "parent", "child", "axis", "limit", "mimic"});
    checkNumbers(*joint, "joint " + quoted(attribute(*joint, "name")));
  }
  checkTree(*robot);

  // Only the robot is passed on: urdfdom's own parser (TinyXML 1) fails on some declarations and comments before it.
  tinyxml2::XMLPrinter printer(nullptr, true);
  robot->Accept(&printer);
  const UrdfdomErrors errors;
  urdf::ModelInterfaceSharedPtr model = urdf::parseURDF(printer.CStr());
  if (!errors.text().empty()) fail(errors.text());
  if (!model) fail("urdfdom refuses it without giving a reason");
  return model;
}

}  // namespace proximity_server::scene
