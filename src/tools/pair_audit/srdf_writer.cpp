#include "tools/pair_audit/srdf_writer.h"

#include "proximity_server/scene/files/xml_declarations.h"
#include "proximity_server/scene/filter/srdf_reason.h"

#include <tinyxml2.h>

#include <algorithm>
#include <set>
#include <stdexcept>
#include <utility>

namespace proximity_server::tools {
namespace {

using tinyxml2::XMLElement;
using Names = std::pair<std::string, std::string>;

constexpr const char* kDisable = "disable_collisions";

Names ordered(const std::string& a, const std::string& b) { return {std::min(a, b), std::max(a, b)}; }

/// The reason why a pair need not be checked; "" if it must be checked.
std::string reasonOf(const PairEvidence& evidence) {
  if (evidence.are_neighbours) return evidence.nearClass() == NearClass::Sometimes ? "" : "Adjacent";
  if (evidence.alwaysInContact()) return "Always";
  if (!evidence.isBeyond()) return "";
  return evidence.isProvenBeyond() ? "Never" : "Never: not proven, closest seen " + lengthText(evidence.smallest);
}

XMLElement* makeEntry(tinyxml2::XMLDocument& document, const scene::RobotModel& robot, const scene::ShapeRefPair& pair,
                      const std::string& reason) {
  XMLElement* entry = document.NewElement(kDisable);
  entry->SetAttribute("link1", nameOf(pair.a, robot).c_str());
  entry->SetAttribute("link2", nameOf(pair.b, robot).c_str());
  entry->SetAttribute("reason", reason.c_str());
  return entry;
}

std::string decisionOf(const PairLevels& pair) { return "User: " + contactText(pair); }

std::string textOf(const tinyxml2::XMLDocument& document) {
  tinyxml2::XMLPrinter printer;
  document.Print(&printer);
  return printer.CStr();
}

bool isDecision(const XMLElement& entry) {
  const char* reason = entry.Attribute("reason");
  return entry.Name() == std::string(kDisable) && reason && scene::isDecision(reason);
}

XMLElement& parse(const std::string& srdf_xml, const std::string& robot, tinyxml2::XMLDocument& document) {
  if (srdf_xml.empty()) {
    document.InsertEndChild(document.NewDeclaration());
    XMLElement* root = document.NewElement("robot");
    root->SetAttribute("name", robot.c_str());
    document.InsertEndChild(root);
  } else if (document.Parse(scene::withoutLateDeclarations(srdf_xml).c_str()) != tinyxml2::XML_SUCCESS) {
    throw std::invalid_argument(std::string("SRDF: ") + document.ErrorStr());
  }
  XMLElement* root = document.FirstChildElement("robot");
  if (!root) throw std::invalid_argument("SRDF: no <robot> element");
  return *root;
}

/// The pairs of an enable_collisions, and those that a person has disabled: the study decides about neither.
std::set<Names> decidedPairs(const XMLElement& root) {
  std::set<Names> pairs;
  for (auto* entry = root.FirstChildElement(); entry; entry = entry->NextSiblingElement()) {
    const char *a = entry->Attribute("link1"), *b = entry->Attribute("link2");
    if (a && b && (entry->Name() == std::string("enable_collisions") || isDecision(*entry)))
      pairs.insert(ordered(a, b));
  }
  return pairs;
}

/// Removes all other disable_collisions. Returns the node before the first of them, or the last child if there was none.
tinyxml2::XMLNode* removeDisabled(XMLElement& root) {
  XMLElement* entry = root.FirstChildElement(kDisable);
  if (!entry) return root.LastChild();
  tinyxml2::XMLNode* before = entry->PreviousSibling();
  while (entry) {
    XMLElement* next = entry->NextSiblingElement(kDisable);
    if (!isDecision(*entry)) root.DeleteChild(entry);
    entry = next;
  }
  return before;
}

}  // namespace

std::string writeSrdf(const std::string& srdf_xml, const scene::RobotModel& robot, const PairStudy& study) {
  tinyxml2::XMLDocument document;
  XMLElement& root = parse(srdf_xml, robot.name, document);
  const std::set<Names> decided = decidedPairs(root);
  tinyxml2::XMLNode* before = removeDisabled(root);
  for (const PairEvidence& evidence : study.pairs) {
    const std::string reason = reasonOf(evidence);
    const std::string &a = nameOf(evidence.pair.a, robot), &b = nameOf(evidence.pair.b, robot);
    if (reason.empty() || decided.count(ordered(a, b))) continue;
    XMLElement* entry = makeEntry(document, robot, evidence.pair, reason);
    before = before ? root.InsertAfterChild(before, entry) : root.InsertFirstChild(entry);
  }
  return textOf(document);
}

std::string disablingEntry(const scene::RobotModel& robot, const PairLevels& pair) {
  tinyxml2::XMLDocument document;
  tinyxml2::XMLPrinter line(nullptr, /*compact=*/true);
  document.InsertEndChild(makeEntry(document, robot, pair.pair, decisionOf(pair)))->Accept(&line);
  return line.CStr();
}

std::string withDisabled(const std::string& srdf_xml, const scene::RobotModel& robot,
                         const std::vector<PairLevels>& pairs) {
  if (pairs.empty()) return srdf_xml;
  tinyxml2::XMLDocument document;
  XMLElement& root = parse(srdf_xml, robot.name, document);
  for (const PairLevels& pair : pairs) root.InsertEndChild(makeEntry(document, robot, pair.pair, decisionOf(pair)));
  return textOf(document);
}

}  // namespace proximity_server::tools
