#include "tools/sweep/blocks_in_threads.h"

#include <gtest/gtest.h>

#include <atomic>
#include <numeric>
#include <set>

#include "sanitized.h"

namespace proximity_server::tools::blocks_in_threads_test {

struct Block {
  int number = -1;
  int answer = -1;
};

constexpr int kThreads = 4;

/// Work that takes another time for each block.
int slowly(int number) {
  int sum = number;
  for (int i = 0; i < (number * 7919) % 2000; ++i) sum = (sum * 31 + i) % 1000003;
  return sum;
}

TEST(BlocksInThreads, WritesEachBlockOnceAndInOrder) {
  const int count = repeats(3000);
  int read = 0;
  std::vector<int> written;
  BlocksInThreads<Block> blocks({[&](Block& block) {
                                   block.number = read++;
                                   return block.number < count;
                                 },
                                 [](Block& block, int) { block.answer = slowly(block.number); },
                                 [&](Block& block) {
                                   EXPECT_EQ(block.answer, slowly(block.number));
                                   written.push_back(block.number);
                                 }},
                                kThreads);
  blocks.run();
  std::vector<int> expected(static_cast<std::size_t>(count));
  std::iota(expected.begin(), expected.end(), 0);
  EXPECT_EQ(written, expected);
}

TEST(BlocksInThreads, UsesBlocksAgainAndReadsOnlyFewAhead) {
  std::set<const Block*> used;
  std::atomic<int> read{0}, written{0};
  BlocksInThreads<Block> blocks({[&](Block& block) {
                                   used.insert(&block);
                                   EXPECT_LE(read - written, 4 * kThreads);
                                   return ++read <= 1000;
                                 },
                                 [](Block&, int) {}, [&](Block&) { ++written; }},
                                kThreads);
  blocks.run();
  EXPECT_EQ(written, 1000);
  EXPECT_LE(used.size(), std::size_t{4 * kThreads});
}

TEST(BlocksInThreads, AnErrorOfReadingComesAfterTheBlocksBeforeIt) {
  int read = 0;
  std::vector<int> written;
  BlocksInThreads<Block> blocks(
      {[&](Block& block) {
         if (read == 20) throw std::invalid_argument("line 20");
         block.number = read++;
         return true;
       },
       [](Block& block, int) { slowly(block.number); }, [&](Block& block) { written.push_back(block.number); }},
      kThreads);
  EXPECT_THROW(blocks.run(), std::invalid_argument);
  EXPECT_EQ(written.size(), 20U);
}

TEST(BlocksInThreads, AnErrorOfAnsweringOrWritingEndsAll) {
  for (const bool in_answer : {true, false}) {
    std::atomic<int> read{0};
    const auto fail = [](const Block& block) {
      if (block.number == 10) throw std::runtime_error("block 10");
    };
    BlocksInThreads<Block> blocks({[&](Block& block) {
                                     block.number = read++;
                                     return true;  // without an end
                                   },
                                   [&](Block& block, int) { in_answer ? fail(block) : void(); },
                                   [&](Block& block) { in_answer ? void() : fail(block); }},
                                  kThreads);
    EXPECT_THROW(blocks.run(), std::runtime_error);
    EXPECT_LE(read, 10 + 4 * kThreads + 1);
  }
}

}  // namespace proximity_server::tools::blocks_in_threads_test
