#include "tools/text/csv.h"

#include <cmath>
#include <stdexcept>

namespace proximity_server::tools {
namespace {

constexpr const char* kBlanks = " \t\r";

std::string trimmed(const std::string& text) {
  const auto first = text.find_first_not_of(kBlanks);
  return first == std::string::npos ? "" : text.substr(first, text.find_last_not_of(kBlanks) - first + 1);
}

/// The field that begins with a quote at `position`; moves `position` behind the closing quote.
std::string quotedField(const std::string& record, std::size_t& position) {
  std::string field;
  for (++position; position < record.size(); ++position) {
    if (record[position] != '"') {
      field += record[position];
    } else if (position + 1 < record.size() && record[position + 1] == '"') {
      field += record[position++];
    } else {
      ++position;
      return field;
    }
  }
  throw std::invalid_argument("a quote does not end");
}

}  // namespace

std::vector<std::string> csvFields(const std::string& record) {
  std::vector<std::string> fields;
  for (std::size_t position = 0;; ++position) {
    const auto first = record.find_first_not_of(kBlanks, position);
    if (first != std::string::npos && record[first] == '"') {
      position = first;
      fields.push_back(quotedField(record, position));
      const auto next = record.find(',', position);
      if (!trimmed(record.substr(position, next - position)).empty()) {
        throw std::invalid_argument("there is text behind a closing quote");
      }
      position = next;
    } else {
      const auto next = record.find(',', position);
      fields.push_back(trimmed(record.substr(position, next - position)));
      position = next;
    }
    if (position == std::string::npos) return fields;
  }
}

std::string csvField(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos && trimmed(text) == text) return text;
  std::string quoted = "\"";
  for (const char letter : text) {
    if (letter == '"') quoted += '"';
    quoted += letter;
  }
  return quoted + '"';
}

std::optional<double> finiteNumber(const std::string& text) {
  const std::optional<double> value = signedNumberIn<double>(text);
  return value && std::isfinite(*value) ? value : std::nullopt;
}
}  // namespace proximity_server::tools
