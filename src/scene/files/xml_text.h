#pragma once

#include <tinyxml2.h>

#include <string>

namespace proximity_server::scene {

/// Parses an XML text into `document`, in bounded memory and time: entities are not expanded, nothing outside of the
/// text is read, and elements may not be nested deeper than tinyxml2 allows (500). A declaration may follow a comment.
///
/// Failure: throws std::invalid_argument with the reason and the line: not well-formed, nested too deep, or beyond the
///          limits for XML in input_limits.h.
void parseXml(const std::string& given, tinyxml2::XMLDocument& document);

}  // namespace proximity_server::scene
