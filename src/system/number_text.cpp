#include "system/number_text.h"

#include <algorithm>
#include <cmath>

#ifdef __cpp_lib_to_chars

#include <array>

namespace proximity_server::system {
namespace {

constexpr std::size_t kLongest = 400;  // characters of a number without an exponent and with a few places

void append(std::string& text, double number, std::chars_format format, int precision) {
  std::array<char, kLongest> digits;
  text.append(digits.data(),
              std::to_chars(digits.data(), digits.data() + digits.size(), number, format, precision).ptr);
}

}  // namespace

template <>
std::optional<double> numberIn<double>(std::string_view text) {
  double value = 0.0;
  const char* const end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, value);
  return error == std::errc() && stop == end ? std::optional<double>(value) : std::nullopt;
}

std::string shortest(double number) {
  std::array<char, 32> text;
  return {text.data(), std::to_chars(text.data(), text.data() + text.size(), number).ptr};
}

std::string shortestDecimal(double number) {
  std::array<char, kLongest> text;
  return {text.data(), std::to_chars(text.data(), text.data() + text.size(), number, std::chars_format::fixed).ptr};
}

void appendFixed(std::string& text, double number, int places) {
  append(text, number, std::chars_format::fixed, places);
}

void appendRounded(std::string& text, double number, int digits) {
  append(text, number, std::chars_format::general, digits);
}

}  // namespace proximity_server::system

#else  // libstdc++ before version 11 has neither function for double. These functions give the same answers.

#include <locale.h>

#include <array>
#include <cerrno>
#include <cfenv>
#include <cmath>
#include <cstdio>
#include <cstdlib>

namespace proximity_server::system {
namespace {

/// While it lives, printf() and strtod() of this thread have the locale C.
class InLocaleC {
 public:
  InLocaleC() : before_(uselocale(localeC())) {}
  ~InLocaleC() { uselocale(before_); }
  InLocaleC(const InLocaleC&) = delete;
  InLocaleC& operator=(const InLocaleC&) = delete;

 private:
  static locale_t localeC() {
    static const locale_t locale = newlocale(LC_ALL_MASK, "C", nullptr);
    return locale;
  }
  locale_t before_;
};

template <typename Number>
std::string printed(const char* format, int precision, Number number) {
  const InLocaleC in_locale_c;
  std::array<char, 400> text;
  return {text.data(), static_cast<std::size_t>(std::snprintf(text.data(), text.size(), format, precision, number))};
}

/// A number as 0.2e-1 has the digits "2" and the exponent -1.
struct Decimal {
  std::string digits;
  int exponent;
};

/// A positive number with one digit before the point and `precision` behind it: "2.0e-02".
std::string rounded(double number, int precision, int direction = FE_TONEAREST) {
  const int before = std::fegetround();
  std::fesetround(direction);
  const std::string text = printed("%.*e", precision, number);
  std::fesetround(before);
  return text;
}

/// The fewest digits that are read as a positive number; of several decimals with so many digits, the nearest one.
Decimal shortestDecimalOf(double number) {
  const auto isRead = [number](const std::string& text) { return numberIn<double>(text) == number; };
  int precision = 0;
  for (int enough = 16; precision < enough;) {  // 17 digits tell a number from all others
    const int half = (precision + enough) / 2;
    if (isRead(rounded(number, half))) {
      enough = half;
    } else {
      precision = half + 1;
    }
  }
  std::string text = rounded(number, precision);
  // The numbers above a power of two are twice as far from it as those below. So a decimal above it may be read as it
  // although another one below it, which is nearer, is not.
  if (precision > 0) {
    const std::string above = rounded(number, precision - 1, FE_UPWARD);
    if (isRead(above)) text = above;
  }
  const std::size_t e = text.find('e');
  const int exponent = std::atoi(text.c_str() + e + 1) + 1;
  text.resize(e);
  if (text.size() > 1) text.erase(1, 1);  // the point
  return {text, exponent};
}

/// The text without an exponent. A whole number has all of its own digits.
std::string withoutExponent(double number, const Decimal& decimal) {
  const auto [digits, exponent] = decimal;
  const int size = static_cast<int>(digits.size());
  if (exponent >= size) return printed("%.*f", 0, number);
  if (exponent <= 0) return "0." + std::string(static_cast<std::size_t>(-exponent), '0') + digits;
  return std::string(digits).insert(static_cast<std::size_t>(exponent), ".");
}

std::string withExponent(const Decimal& decimal) {
  std::string text = decimal.digits;
  if (text.size() > 1) text.insert(1, ".");
  return text + printed("e%+0*d", 3, decimal.exponent - 1);
}

/// Writes a number by `write`, which gets its absolute value.
template <typename Write>
std::string signedText(double number, const Write& write) {
  const std::string sign = std::signbit(number) ? "-" : "";
  if (std::isnan(number)) return sign + "nan";
  if (std::isinf(number)) return sign + "inf";
  return sign + (number == 0.0 ? "0" : write(std::abs(number)));
}

}  // namespace

template <>
std::optional<double> numberIn<double>(std::string_view text) {
  // strtod() also reads blanks, a plus sign and hexadecimal numbers.
  if (text.empty() || text.find_first_of(" \t\n\v\f\r+") == 0) return std::nullopt;
  const std::string_view digits = text.substr(text.front() == '-' ? 1 : 0, 2);
  if (digits == "0x" || digits == "0X") return std::nullopt;
  const std::string all(text);  // ends with a zero
  const InLocaleC in_locale_c;
  char* stop = nullptr;
  errno = 0;
  const double value = std::strtod(all.c_str(), &stop);
  const bool is_out_of_range = errno == ERANGE && (value == 0.0 || std::isinf(value));
  return stop == all.data() + all.size() && !is_out_of_range ? std::optional<double>(value) : std::nullopt;
}

std::string shortest(double number) {
  return signedText(number, [](double positive) {
    const Decimal decimal = shortestDecimalOf(positive);
    const std::string scientific = withExponent(decimal), fixed = withoutExponent(positive, decimal);
    return fixed.size() <= scientific.size() ? fixed : scientific;
  });
}

std::string shortestDecimal(double number) {
  return signedText(number, [](double positive) { return withoutExponent(positive, shortestDecimalOf(positive)); });
}

void appendFixed(std::string& text, double number, int places) { text += printed("%.*f", places, number); }
void appendRounded(std::string& text, double number, int digits) { text += printed("%.*g", digits, number); }

}  // namespace proximity_server::system

#endif

namespace proximity_server::system {
namespace {

constexpr std::size_t kLongestWord = 512, kLongestMessage = 16384;  // [byte]

/// The place at or behind this one where a character of UTF-8 begins.
std::size_t beginOfCharacter(std::string_view text, std::size_t place) {
  const auto isInside = [](char byte) { return (static_cast<unsigned char>(byte) & 0xC0U) == 0x80U; };
  constexpr int kMostBytes = 4;  // of a character; other bytes are not UTF-8
  for (int i = 0; i < kMostBytes && place < text.size() && isInside(text[place]); ++i) ++place;
  return place;
}

std::string cut(std::string_view text, std::size_t most) {
  if (text.size() <= most) return std::string(text);
  const std::size_t front = beginOfCharacter(text, most / 2), back = beginOfCharacter(text, text.size() - most / 2);
  return std::string(text.substr(0, front)) + "...(" + std::to_string(back - front) + " bytes left out)..." +
         std::string(text.substr(back));
}

}  // namespace

std::optional<PositionText> positionIn(std::string_view text) {
  constexpr double kDegree = 3.14159265358979323846 / 180.0;
  constexpr std::string_view kUnit = "deg";
  PositionText position;
  position.is_in_degrees = text.size() > kUnit.size() && text.substr(text.size() - kUnit.size()) == kUnit;
  if (position.is_in_degrees) {
    text.remove_suffix(kUnit.size());
    if (text.back() == ' ') text.remove_suffix(1);
  }
  if (text.size() > 1 && text[0] == '+' && text[1] != '-') text.remove_prefix(1);
  const std::optional<double> number = numberIn<double>(text);
  if (!number || !std::isfinite(*number)) return std::nullopt;
  position.value = position.is_in_degrees ? *number * kDegree : *number;
  return position;
}

std::string readable(std::string message) {
  if (message.size() <= kLongestWord) return message;
  constexpr const char* kBlanks = " \t\r\n";
  std::string text;
  for (std::size_t begin = 0; begin < message.size();) {
    const std::size_t word = std::min(message.find_first_not_of(kBlanks, begin), message.size());
    const std::size_t end = std::min(message.find_first_of(kBlanks, word), message.size());
    text.append(message, begin, word - begin);
    text += cut(std::string_view(message).substr(word, end - word), kLongestWord);
    begin = end;
  }
  return cut(text, kLongestMessage);
}

}  // namespace proximity_server::system
