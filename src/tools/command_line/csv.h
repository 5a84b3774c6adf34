#pragma once

#include <optional>
#include <string>
#include <vector>

namespace proximity_server::tools {

/// The fields of one record of comma-separated values (RFC 4180), without the blanks around unquoted fields.
/// Throws std::invalid_argument for a quote that does not end.
std::vector<std::string> csvFields(const std::string& record);

/// The text as one field, in quotes if necessary.
std::string csvField(const std::string& text);

/// The finite number that a text is, with or without a plus sign; nullopt if it is anything else.
std::optional<double> finiteNumber(const std::string& text);

/// The shortest text that reads back as the same double; also nan, inf and -inf.
std::string numberText(double value);

}  // namespace proximity_server::tools
