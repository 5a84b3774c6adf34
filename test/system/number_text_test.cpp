#include "system/number_text.h"

#include "sanitized.h"
#include "scene/files.h"

#include <gtest/gtest.h>
#include <locale.h>
#ifdef PROXIMITY_ADDRESS_SANITIZED
#include <sanitizer/lsan_interface.h>
#endif

#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <random>
#include <string>
#include <vector>

namespace proximity_server::system::number_text_test {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN(), kInfinity = std::numeric_limits<double>::infinity();

struct Written {
  double number;
  const char *shortest, *decimal;
};

const Written kWritten[] = {
    {0.0, "0", "0"},
    {-0.0, "-0", "-0"},
    {1.0, "1", "1"},
    {-0.02, "-0.02", "-0.02"},
    {0.1 + 0.2, "0.30000000000000004", "0.30000000000000004"},
    {1.0 / 3.0, "0.3333333333333333", "0.3333333333333333"},
    {123456.789, "123456.789", "123456.789"},
    // If both texts have the same length, the one without an exponent is taken.
    {1e-3, "0.001", "0.001"},
    {1e-4, "1e-04", "0.0001"},
    {1.5e-5, "1.5e-05", "0.000015"},
    {10000.0, "10000", "10000"},
    {100000.0, "1e+05", "100000"},
    {123456789012345680.0, "123456789012345680", "123456789012345680"},
    // A whole number shows all of its own digits, not those that tell it from others.
    {123456789012345678901.0, "123456789012345683968", "123456789012345683968"},
    {1e22, "1e+22", "10000000000000000000000"},
    {1e23, "1e+23", "99999999999999991611392"},
    // A power of two: rounded to 16 digits it is another number, so that the next one of 16 digits is the shortest.
    {5.684341886080802e-14, "5.684341886080802e-14", "0.00000000000005684341886080802"},
    {9007199254740992.0, "9007199254740992", "9007199254740992"},
    {kInfinity, "inf", "inf"},
    {-kInfinity, "-inf", "-inf"},
    {kNan, "nan", "nan"},
};

TEST(NumberText, IsTheShortestThatIsReadAsTheNumber) {
  for (const Written& written : kWritten) {
    EXPECT_EQ(shortest(written.number), written.shortest);
    EXPECT_EQ(shortestDecimal(written.number), written.decimal);
  }
  EXPECT_EQ(shortest(5e-324), "5e-324");
  EXPECT_EQ(shortest(2.2250738585072011e-308), "2.225073858507201e-308");  // the largest that is not normal
  EXPECT_EQ(shortest(1e308), "1e+308");
  EXPECT_EQ(shortest(-1.7976931348623157e308), "-1.7976931348623157e+308");
  EXPECT_EQ(shortestDecimal(5e-324), "0." + std::string(323, '0') + "5");
  EXPECT_EQ(shortestDecimal(1e308).size(), 309U);
}

struct Read {
  const char* text;
  double number;
};

TEST(NumberText, IsReadAsTheNearestNumber) {
  const Read all[] = {
      {"0.1", 0.1},
      {"-7", -7.0},
      {".5", 0.5},
      {"5.", 5.0},
      {"1e3", 1000.0},
      {"1E+03", 1000.0},
      {"1e-3", 0.001},
      {"000012.500", 12.5},
      {"5e-324", 5e-324},
      {"2.2250738585072011e-308", 2.2250738585072011e-308},
      {"1.7976931348623157e308", 1.7976931348623157e308},
      {"0e400", 0.0},
      {"9007199254740993", 9007199254740992.0},  // between two numbers: the even one
      {"9007199254740993.00000000000000000000000000000000000001", 9007199254740994.0},
      {"inf", kInfinity},
      {"-Infinity", -kInfinity},
  };
  for (const Read& read : all) EXPECT_EQ(numberIn<double>(read.text), read.number) << read.text;
  EXPECT_TRUE(std::signbit(numberIn<double>("-0").value()));
  EXPECT_TRUE(std::isnan(numberIn<double>("nan").value()));
}

TEST(NumberText, IsRefusedIfAnythingElseIsThere) {
  for (const char* const text :
       {"",      " ",   "+1",  "+",     "-",  "--1", "-+1", " 1",  "1 ",       "\n1",   "1\t",    "0x10",
        "0X1p3", "1p3", "1,5", "1.5.2", "1e", "1e+", "e5",  "one", "infinite", "1e400", "-1e400", "1e-400"})
    EXPECT_FALSE(numberIn<double>(text)) << text;
  EXPECT_FALSE(numberIn<double>(std::string_view("1\0", 2)));
  EXPECT_EQ(numberIn<double>(std::string_view("12345").substr(0, 2)), 12.0);
}

TEST(NumberText, WholeNumbersHaveTheRangeOfTheirType) {
  EXPECT_EQ(numberIn<std::uint64_t>("18446744073709551615"), 18446744073709551615U);
  EXPECT_FALSE(numberIn<std::uint64_t>("18446744073709551616"));
  EXPECT_FALSE(numberIn<std::uint64_t>("-1"));
  EXPECT_FALSE(numberIn<int>("1.0"));
  EXPECT_FALSE(numberIn<int>("+1"));
}

/// A text of so many digits, or of fewer.
std::string digits(double number, int precision) {
  char text[64];
  return {text, static_cast<std::size_t>(std::snprintf(text, sizeof text, "%.*e", precision, number))};
}

std::size_t digitsIn(const std::string& text) {
  std::size_t count = 0;
  for (const char c : text.substr(0, text.find('e'))) count += c >= '0' && c <= '9' ? 1 : 0;
  return count;
}

// All bit patterns are equally likely, so nearly all exponents come.
TEST(NumberText, OfARandomNumberIsReadBackBitByBitAndNoDigitCanBeLeftOut) {
  std::mt19937_64 random(36);
  int with_exponent = 0;
  for (int i = 0; i < 20000; ++i) {
    const std::uint64_t bits = random();
    double number = 0.0;
    std::memcpy(&number, &bits, sizeof number);
    if (!std::isfinite(number)) continue;
    const std::string text = shortest(number);
    EXPECT_EQ(numberIn<double>(text), number) << text;
    EXPECT_EQ(numberIn<double>(shortestDecimal(number)), number) << text;
    if (text.find('e') == std::string::npos) continue;
    ++with_exponent;
    const int shorter = static_cast<int>(digitsIn(text)) - 2;  // one digit stands before the point
    if (shorter < 0) continue;
    EXPECT_NE(std::strtod(digits(number, shorter).c_str(), nullptr), number) << text;
  }
  EXPECT_GT(with_exponent, 19000);
}

TEST(NumberText, RoundedNumbersAreThoseOfPrintf) {
  std::mt19937 random(1);
  const auto printed = [](const char* format, int precision, double number) {
    char text[400];
    std::snprintf(text, sizeof text, format, precision, number);
    return std::string(text);
  };
  std::vector<double> numbers{0.0, -0.0, 0.05, 0.25, 2.5, 999.95, 1e300, -1e-300, kInfinity, kNan};
  std::uniform_real_distribution<double> decade(-8.0, 8.0);
  for (int i = 0; i < 2000; ++i) numbers.push_back((i % 2 == 0 ? 1.0 : -1.0) * std::pow(10.0, decade(random)));
  for (const double number : numbers) {
    const int digits = static_cast<int>(random() % 6);
    std::string fixed = "a ", rounded = "b ";
    appendFixed(fixed, number, digits);
    appendRounded(rounded, number, digits + 1);
    ASSERT_EQ(fixed, "a " + printed("%.*f", digits, number));
    ASSERT_EQ(rounded, "b " + printed("%.*g", digits + 1, number));
  }
}

/// A locale that writes 0,5, of nothing but what localedef itself has; null if it cannot be made.
locale_t commaLocale() {
  const scene::TemporaryFiles files;
  std::string characters =
      "<code_set_name> ASCII\n<comment_char> %\n<escape_char> /\n<mb_cur_min> 1\n<mb_cur_max> 1\nCHARMAP\n";
  for (int code = 0; code < 128; ++code) {
    char line[32];
    std::snprintf(line, sizeof line, "<U%04X> /x%02x\n", code, code);
    characters += line;
  }
  files.write("characters", characters + "END CHARMAP\n");
  files.write("source", "LC_NUMERIC\ndecimal_point \",\"\nthousands_sep \"\"\ngrouping -1\nEND LC_NUMERIC\n");
  // It says that the other categories are missing.
  [[maybe_unused]] const int code = std::system(
      ("cd " + files.path("") + " && localedef --no-archive -c -f ./characters -i ./source ./xx_XX 2>/dev/null")
          .c_str());
#ifdef PROXIMITY_ADDRESS_SANITIZED
  const __lsan::ScopedDisabler keeps_the_folders_of_locpath;  // newlocale() of glibc never frees them
#endif
  setenv("LOCPATH", files.path("").c_str(), 1);
  const locale_t comma = newlocale(LC_NUMERIC_MASK, "xx_XX", nullptr);
  unsetenv("LOCPATH");
  return comma;
}

TEST(NumberText, IsTheSameInEveryLocale) {
  const locale_t comma = commaLocale();
  ASSERT_TRUE(comma);
  const locale_t before = uselocale(comma);
  const std::string printed = digits(1.5, 1), written = shortest(0.5), decimal = shortestDecimal(1.5e-5);
  std::string rounded;
  appendFixed(rounded, 12.25, 1);
  appendRounded(rounded, 0.01250, 4);
  const std::optional<double> read = numberIn<double>("0.5"), with_comma = numberIn<double>("0,5");
  uselocale(before);
  freelocale(comma);
  EXPECT_EQ(printed, "1,5e+00");
  EXPECT_EQ(written, "0.5");
  EXPECT_EQ(decimal, "0.000015");
  EXPECT_EQ(rounded, "12.20.0125");
  EXPECT_EQ(read, 0.5);
  EXPECT_FALSE(with_comma);
}

// --- readable messages

TEST(Readable, IsAMessageOfOrdinaryLengthAsItIs) {
  const std::string path(500, 'p'), message = path + ", line 3:\n  " + path + " is wrong ";
  EXPECT_EQ(readable(""), "");
  EXPECT_EQ(readable(message), message);
  EXPECT_EQ(readable(" \n" + message), " \n" + message);
}

// With its quotes, the name has 5000010 bytes, and 512 of them stay.
TEST(Readable, IsALongNameCutInItsMiddleAndNoReasonIsLost) {
  const std::string name = "begin" + std::string(5000000, 'x') + "end";
  const std::string text = readable("object '" + name + "' has no link '" + name + "': did you mean 'hand'?");
  EXPECT_LT(text.size(), 1300U);
  EXPECT_EQ(text.find("object 'beginxxx"), 0U);
  EXPECT_NE(text.find("xxx...(4999498 bytes left out)...xxx"), std::string::npos) << text;
  EXPECT_NE(text.find("xxxend' has no link 'beginxxx"), std::string::npos) << text;
  EXPECT_NE(text.find("xxxend': did you mean 'hand'?"), std::string::npos) << text;
}

TEST(Position, IsANumberOrAnAngle) {
  for (const char* const text : {"0.5", "+0.5", "28.64788975654116deg", "+28.64788975654116 deg"}) {
    const auto position = positionIn(text);
    ASSERT_TRUE(position.has_value()) << text;
    EXPECT_DOUBLE_EQ(position->value, 0.5) << text;
    EXPECT_EQ(position->is_in_degrees, std::string(text).find('g') != std::string::npos) << text;
  }
  for (const char* const text :
       {"", "deg", " deg", "+deg", "+-1", "1 rad", "1deg ", "1  deg", "inf", "nan deg", "1e400deg"})
    EXPECT_FALSE(positionIn(text).has_value()) << text;
}

TEST(Readable, IsALongMessageOfShortWordsCutInItsMiddle) {
  std::string list;
  for (int i = 0; i < 100000; ++i) list += "name" + std::to_string(i) + ", ";
  const std::string text = readable("there is none of " + list + "as was asked");
  EXPECT_LT(text.size(), 16500U);
  EXPECT_EQ(text.find("there is none of name0, name1, "), 0U);
  EXPECT_EQ(text.rfind("name99999, as was asked"), text.size() - 23);
}

TEST(Readable, StaysUtf8) {
  for (const std::string character : {"\xC3\xA4", "\xE2\x82\xAC", "\xF0\x9F\xA4\x96"}) {
    for (std::size_t shift = 0; shift < 4; ++shift) {
      std::string name(shift, 'x');
      for (int i = 0; i < 1000; ++i) name += character;
      std::string text = readable(name);
      EXPECT_LT(text.size(), 600U);
      const std::size_t begin = text.find("...("), end = text.find(")...") + 4;
      ASSERT_NE(begin, std::string::npos);
      EXPECT_EQ((begin - shift) % character.size(), 0U);
      EXPECT_EQ((text.size() - end) % character.size(), 0U);
    }
  }
  EXPECT_LT(readable(std::string(10000, '\x80')).size(), 600U) << "no UTF-8";
}

}  // namespace proximity_server::system::number_text_test
