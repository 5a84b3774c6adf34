#include "tools/sweep/state_range.h"

#include "scene/files.h"

#include <gtest/gtest.h>

namespace proximity_server::tools::state_range_test {

TEST(StateRange, ShardsLieEndToEndAndDifferByAtMostOneState) {
  for (const std::uint64_t count : {1ULL, 7ULL, 1000ULL, 1000000007ULL, 18446744073709551614ULL}) {
    for (const std::uint64_t of : {1ULL, 2ULL, 3ULL, 7ULL, 64ULL}) {
      std::uint64_t next = 0;
      for (std::uint64_t number = 1; number <= of; ++number) {
        const StateRange range = rangeOf(ShardNumber{number, of}, count);
        EXPECT_EQ(range.begin, next);
        EXPECT_GE(range.size(), count / of);
        EXPECT_LE(range.size(), count / of + 1);
        next = range.end;
      }
      EXPECT_EQ(next, count);
    }
  }
}

TEST(StateRange, ReadsWhatItWrites) {
  const StateRange range = readRange("17:18446744073709551615");
  EXPECT_EQ(range.begin, 17U);
  EXPECT_EQ(range.end, 18446744073709551615ULL);
  EXPECT_EQ(textOf(range), "17:18446744073709551615");
  EXPECT_EQ(readShard("3/8").number, 3U);
  EXPECT_EQ(readShard("3/8").of, 8U);
}

TEST(StateRange, NamesTextsThatAreNoShardOrRange) {
  for (const char* text :
       {"", "3", "3/", "/3", "a/3", "3/4x", "-1/4", " 1/4", "1:4", "18446744073709551616/18446744073709551616"})
    EXPECT_EQ(scene::errorOf([&] { readShard(text); }), "'" + std::string(text) + "' is not of the form I/N, as 3/8");
  for (const char* text : {"0/4", "5/4", "0/0"})
    EXPECT_NE(scene::errorOf([&] { readShard(text); }).find("shards are numbered from 1 to N"), std::string::npos);
  for (const char* text : {"", "3", "3:", ":3", "3/4", "1:2:3", "1:-2"})
    EXPECT_EQ(scene::errorOf([&] { readRange(text); }),
              "'" + std::string(text) + "' is not of the form A:B, as 0:1000");
  for (const char* text : {"3:3", "4:3"})
    EXPECT_NE(scene::errorOf([&] { readRange(text); }).find("has no state"), std::string::npos);
}

}  // namespace proximity_server::tools::state_range_test
