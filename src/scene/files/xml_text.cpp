#include "scene/files/xml_text.h"

#include "proximity_server/scene/files/xml_declarations.h"
#include "scene/mesh/input_limits.h"

#include <algorithm>
#include <cstring>
#include <stdexcept>
#include <string_view>
#include <utility>

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

/// The end of the comment, CDATA or declaration that begins at a place, npos if it has none; the next place if nothing of
/// this kind begins there. Text like a declaration in a comment or in CDATA is none.
std::size_t endOfSection(const std::string& xml, std::size_t begin) {
  using Ends = std::pair<std::string_view, std::string_view>;
  for (const auto& [opening, closing] : {Ends{"<!--", "-->"}, Ends{"<![CDATA[", "]]>"}, Ends{"<?", "?>"}}) {
    if (xml.compare(begin, opening.size(), opening) != 0) continue;
    const std::size_t end = xml.find(closing, begin + opening.size());
    return end == std::string::npos ? end : end + closing.size();
  }
  return begin + 1;
}

}  // namespace

std::string withoutLateDeclarations(std::string xml) {
  for (std::size_t begin = xml.find('<'); begin != std::string::npos;) {
    const std::size_t end = endOfSection(xml, begin);
    if (end == std::string::npos) break;  // the parser says so
    if (begin > 0 && xml[begin + 1] == '?')
      std::replace_if(
          &xml[begin], &xml[end], [](char c) { return c != '\n'; }, ' ');
    begin = xml.find('<', end);
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
