#pragma once

#include "proximity_server/scene/model/names.h"
#include "system/number_text.h"

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace proximity_server::tools {

/// The fields of one record of comma-separated values (RFC 4180), without the blanks around unquoted fields.
/// Throws std::invalid_argument for a quote that does not end.
std::vector<std::string> csvFields(const std::string& record);

/// The text as one field, in quotes if necessary.
std::string csvField(const std::string& text);

using system::numberIn;

/// Reads a number as numberIn() does, from a text that may begin with a plus sign.
template <typename Number>
std::optional<Number> signedNumberIn(std::string_view text) {
  const bool has_plus = text.size() > 1 && text[0] == '+' && text[1] != '-';
  return numberIn<Number>(text.substr(has_plus ? 1 : 0));
}

/// The finite number that a text is, with or without a plus sign; nullopt if it is anything else.
std::optional<double> finiteNumber(const std::string& text);

using scene::shortest;

}  // namespace proximity_server::tools
