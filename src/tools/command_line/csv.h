#pragma once

#include <optional>
#include <string>
#include <vector>

namespace proximity_server::tools {

/// The fields of one record of comma-separated values (RFC 4180), without the blanks about unquoted ones.
/// Throws std::invalid_argument for a quote that does not end.
std::vector<std::string> csvFields(const std::string& record);

/// One field, quoted where its text needs it.
std::string csvField(const std::string& text);

/// The finite number that a text is, with or without a plus sign; nullopt if it is anything else.
std::optional<double> finiteNumber(const std::string& text);

/// Shortest text that reads back as the same double; nan, inf and -inf.
std::string numberText(double value);

}  // namespace proximity_server::tools
