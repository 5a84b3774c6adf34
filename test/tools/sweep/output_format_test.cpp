#include "tools/sweep/output_format.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <random>

namespace proximity_server::tools::output_format_test {

template <typename Number>
Number numberAt(const std::string& bytes, std::size_t place) {
  Number number;
  std::memcpy(&number, bytes.data() + place, sizeof number);
  return number;
}

// numpy.lib.format, version 1.0: magic, version, little endian size of the rest of the header, a Python dictionary,
// blanks and a line end; all of it a multiple of 64 bytes. sweep_python_test loads files with numpy itself.
TEST(OutputFormat, TheHeaderIsThatOfNumpyAndKeepsItsSize) {
  for (const std::uint64_t rows : {0ULL, 1ULL, 18446744073709551615ULL}) {
    const std::string header = npyHeader(npyPairType(), rows);
    EXPECT_EQ(header.size(), 256U);
    EXPECT_EQ(header.substr(0, 8), std::string("\x93NUMPY\x01\x00", 8));
    EXPECT_EQ(numberAt<std::uint16_t>(header, 8), header.size() - 10);
    EXPECT_NE(header.find("'shape': (" + std::to_string(rows) + ",), }  "), std::string::npos);
    EXPECT_EQ(header.back(), '\n');
  }
}

TEST(OutputFormat, ARowOfAPairHas24Bytes) {
  std::string bytes;
  appendNpy({1234567890123ULL, 7, 0.5, 0.25, 0.75}, bytes);
  ASSERT_EQ(bytes.size(), 24U);
  EXPECT_EQ(numberAt<std::uint64_t>(bytes, 0), 1234567890123ULL);
  EXPECT_EQ(numberAt<std::int32_t>(bytes, 8), 7);
  EXPECT_EQ(numberAt<float>(bytes, 12), 0.5F);
  EXPECT_EQ(numberAt<float>(bytes, 16), 0.25F);
  EXPECT_EQ(numberAt<float>(bytes, 20), 0.75F);
}

TEST(OutputFormat, BoundsAreRoundedToTheSafeSideByLessThanOneFloat) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> metres(-2.0, 2.0);
  for (int i = 0; i < 10000; ++i) {
    const double bound = metres(random);
    std::string bytes;
    appendNpy({0, 0, bound, bound, bound}, bytes);
    const float lower = numberAt<float>(bytes, 16), upper = numberAt<float>(bytes, 20);
    EXPECT_LE(static_cast<double>(lower), bound);
    EXPECT_GE(static_cast<double>(upper), bound);
    EXPECT_EQ(std::nextafter(lower, 3.0F), upper);  // no random double is a float
    EXPECT_TRUE(numberAt<float>(bytes, 12) == lower || numberAt<float>(bytes, 12) == upper);
  }
  std::string bytes;
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  appendNpy({0, -1, std::nan(""), -kInfinity, kInfinity}, bytes);
  EXPECT_TRUE(std::isnan(numberAt<float>(bytes, 12)));
  EXPECT_EQ(numberAt<float>(bytes, 16), -std::numeric_limits<float>::infinity());
  EXPECT_EQ(numberAt<float>(bytes, 20), std::numeric_limits<float>::infinity());
}

TEST(OutputFormat, TheSmallestIntegerHoldsAllNumbersOfPairs) {
  const auto bytesFor = [](std::size_t pairs) { return npyIntegerFor(pairs).bytes; };
  EXPECT_EQ(bytesFor(1), 1);
  EXPECT_EQ(bytesFor(128), 1);  // the last has the number 127
  EXPECT_EQ(bytesFor(129), 2);
  EXPECT_EQ(bytesFor(32768), 2);
  EXPECT_EQ(bytesFor(32769), 4);
  std::string bytes;
  npyIntegerFor(129).append(-2, bytes);
  npyIntegerFor(129).append(128, bytes);
  EXPECT_EQ(numberAt<std::int16_t>(bytes, 0), -2);
  EXPECT_EQ(numberAt<std::int16_t>(bytes, 2), 128);
}

}  // namespace proximity_server::tools::output_format_test
