#include "urdf_document.h"

#include <console_bridge/console.h>
#include <tinyxml2.h>
#include <urdf_parser/urdf_parser.h>

#include <algorithm>
#include <mutex>
#include <stdexcept>
#include <vector>

#include "names.h"

namespace proximity_server {
namespace {

using tinyxml2::XMLElement;

[[noreturn]] void fail(const std::string& why) { throw std::invalid_argument("URDF: " + why); }

std::string attribute(const XMLElement& element, const char* name) {
  const char* value = element.Attribute(name);
  return value ? value : "";
}

/// Keeps urdfdom's errors from the console while it lives. Its logger is global, so one reader at a time.
class UrdfdomErrors : console_bridge::OutputHandler {
 public:
  UrdfdomErrors() : alone_(mutex_) { console_bridge::useOutputHandler(this); }
  ~UrdfdomErrors() override { console_bridge::restorePreviousOutputHandler(); }

  /// What was said, "" where nothing was.
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

void keepOnly(XMLElement& parent, const std::vector<std::string>& names) {
  XMLElement* next = nullptr;
  for (XMLElement* child = parent.FirstChildElement(); child; child = next) {
    next = child->NextSiblingElement();
    if (std::find(names.begin(), names.end(), child->Name()) == names.end()) parent.DeleteChild(child);
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

/// urdfdom takes the first of several shapes or origins.
void checkCollision(const XMLElement& collision, const std::string& where) {
  if (count(&collision, "geometry") != 1) fail(where + ": expected one <geometry>");
  if (count(collision.FirstChildElement("geometry")) != 1) fail(where + ": expected one shape in its <geometry>");
  if (count(&collision, "origin") > 1) fail(where + ": more than one <origin>");
}

/// urdfdom takes no notice of an element with a misspelt name.
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

}  // namespace

urdf::ModelInterfaceSharedPtr readUrdf(const std::string& urdf_xml) {
  tinyxml2::XMLDocument document;
  if (document.Parse(urdf_xml.c_str(), urdf_xml.size()) != tinyxml2::XML_SUCCESS) fail(document.ErrorStr());
  XMLElement* robot = document.FirstChildElement("robot");
  if (!robot) fail("no <robot> element");
  if (count(robot, "link") == 0) fail("the robot has no links");
  for (auto* link = robot->FirstChildElement("link"); link; link = link->NextSiblingElement("link")) {
    checkLink(*link);
    keepOnly(*link, {"collision"});
  }
  keepOnly(*robot, {"link", "joint"});
  for (auto* joint = robot->FirstChildElement("joint"); joint; joint = joint->NextSiblingElement("joint")) {
    keepOnly(*joint, {"origin", "parent", "child", "axis", "limit", "mimic"});
  }

  tinyxml2::XMLPrinter printer(nullptr, true);
  document.Print(&printer);
  const UrdfdomErrors errors;
  urdf::ModelInterfaceSharedPtr model = urdf::parseURDF(printer.CStr());
  if (!errors.text().empty()) fail(errors.text());
  if (!model) fail("urdfdom refuses it without giving a reason");
  return model;
}

}  // namespace proximity_server
