#include "scene/loading/xml_text.h"

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

void parseXml(const std::string& text, tinyxml2::XMLDocument& document) {
  if (text.size() > kMaxBytes) throw std::invalid_argument("it is larger than 256 MiB");
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
