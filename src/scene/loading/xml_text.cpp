#include "scene/loading/xml_text.h"

#include "proximity_server/scene/loading/xml_declarations.h"
#include "scene/mesh/input_limits.h"

#include <algorithm>
#include <cstring>
#include <stdexcept>

namespace proximity_server::scene {
namespace {

using tinyxml2::XMLElement;

void checkLength(const XMLElement& element, const char* text, const char* what) {
  if (std::strlen(text) <= kLongestAttribute) return;
  throw std::invalid_argument("line " + std::to_string(element.GetLineNum()) + ": " + what + " is longer than " +
                              std::to_string(kLongestAttribute) + " characters");
}

void checkLengths(const XMLElement& element) {
  checkLength(element, element.Name(), "the name of an element");
  for (auto* attribute = element.FirstAttribute(); attribute; attribute = attribute->Next()) {
    checkLength(element, attribute->Name(), "the name of an attribute");
    checkLength(element, attribute->Value(), "an attribute");
  }
  for (auto* child = element.FirstChildElement(); child; child = child->NextSiblingElement()) checkLengths(*child);
}

}  // namespace

std::string withoutLateDeclarations(std::string xml) {
  for (std::size_t begin = xml.find("<?", 1); begin != std::string::npos; begin = xml.find("<?", begin)) {
    const std::size_t end = xml.find("?>", begin);
    if (end == std::string::npos) break;  // the parser says so
    std::replace_if(
        &xml[begin], &xml[end + 2], [](char c) { return c != '\n'; }, ' ');
  }
  return xml;
}

void parseXml(const std::string& given, tinyxml2::XMLDocument& document) {
  if (given.size() > kMaxBytes) throw std::invalid_argument("it is larger than 256 MiB");
  const std::string text = withoutLateDeclarations(given);
  const auto begins = [](char c) { return c == '<' || c == '='; };
  if (std::count_if(text.begin(), text.end(), begins) > kMaxElementsAndAttributes) {
    throw std::invalid_argument("it has more than a million elements and attributes");
  }
  if (document.Parse(text.c_str(), text.size()) != tinyxml2::XML_SUCCESS) {
    throw std::invalid_argument(document.ErrorStr());
  }
  for (auto* element = document.FirstChildElement(); element; element = element->NextSiblingElement()) {
    checkLengths(*element);
  }
}

}  // namespace proximity_server::scene
