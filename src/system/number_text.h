#pragma once

#include <charconv>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>

namespace proximity_server::system {

// Numbers as texts, the same ones in every locale.
//
// They come from <charconv>, or where that has none for double (libstdc++ 10 of Debian 11), from printf() and strtod().
// A shortest text then takes 2 to 9 us. double-conversion writes the same digits of 900,000 numbers in 0.2 to 3 us, which
// is not worth a dependency that only Debian 11 needs; nlohmann-json misses the shortest text of 124 in 300,000.

/// The number that the whole of a text is, without blanks and without a plus sign before it; nullopt if the text is
/// anything else, such as a hexadecimal number, or if no number of this type is near it.
template <typename Number>
std::optional<Number> numberIn(std::string_view text) {
  Number value{};
  const char* const end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, value);
  return error == std::errc() && stop == end ? std::optional<Number>(value) : std::nullopt;
}
template <>
std::optional<double> numberIn<double>(std::string_view text);

/// A position of a joint, or an angle, as a text states it.
struct PositionText {
  double value = 0.0;          ///< [rad] or [m]
  bool is_in_degrees = false;  ///< the text is
};

/// Reads a finite number, or an angle like "90deg" or "90 deg", with any sign; nullopt if the whole of the text is neither.
std::optional<PositionText> positionIn(std::string_view text);

/// The shortest text that gives the same number when it is read: "0.02", "1e-05".
std::string shortest(double number);

/// The shortest such text without an exponent: "0.00001".
std::string shortestDecimal(double number);

/// Appends a number with so many places behind the point: "12.0". It allocates only where the text has to grow.
void appendFixed(std::string& text, double number, int places);

/// Appends a number with at most so many digits, those at the end that are 0 left out: "12", "0.0125", "1.5e+06".
void appendRounded(std::string& text, double number, int digits);

/// A message as people can read it, because what comes from outside has any length: each word of more than 512 bytes,
/// and a message of more than 16384, is cut in its middle: "aaa...(49999488 bytes left out)...aaa". UTF-8 stays UTF-8.
std::string readable(std::string message);

}  // namespace proximity_server::system
