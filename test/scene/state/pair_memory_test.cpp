#include "scene/state/pair_memory.h"

#include <gtest/gtest.h>

namespace proximity_server::scene::pair_memory_test {

TEST(PairMemory, KnowsNoPairAtTheBeginning) {
  const PairMemory<int> memory(10);
  EXPECT_EQ(memory.find(0, 0), nullptr);
  EXPECT_EQ(memory.find(3, 7), nullptr);
}

TEST(PairMemory, GivesANewPairANewValue) {
  PairMemory<int> memory(10);
  EXPECT_EQ(memory.of(3, 7), 0);
}

TEST(PairMemory, KeepsWhatIsWrittenToAPair) {
  PairMemory<int> memory(10);
  memory.of(3, 7) = 37;
  memory.of(4, 7) = 47;
  EXPECT_EQ(memory.of(3, 7), 37);
  ASSERT_NE(memory.find(3, 7), nullptr);
  EXPECT_EQ(*memory.find(3, 7), 37);
  EXPECT_EQ(*memory.find(4, 7), 47);
}

TEST(PairMemory, DoesNotTakeAPairForItsReverse) {
  PairMemory<int> memory(10);
  memory.of(3, 7) = 37;
  EXPECT_EQ(memory.find(7, 3), nullptr);
  memory.of(7, 3) = 73;
  EXPECT_EQ(*memory.find(3, 7), 37);
  EXPECT_EQ(*memory.find(7, 3), 73);
}

// A table of 8 places, all of which are taken, so that some pairs are not where they would be alone.
TEST(PairMemory, TellsPairsApartThatHaveANumberInCommon) {
  PairMemory<int> memory(4);
  for (int a = 0; a < 2; ++a)
    for (int b = 0; b < 4; ++b) memory.of(a, b) = 10 * a + b;
  for (int a = 0; a < 2; ++a) {
    for (int b = 0; b < 4; ++b) {
      ASSERT_NE(memory.find(a, b), nullptr);
      EXPECT_EQ(*memory.find(a, b), 10 * a + b);
      EXPECT_EQ(memory.of(a, b), 10 * a + b);
    }
  }
}

// A table of 8 places, all of which a pair may take.
TEST(PairMemory, InAFullTableANewPairTakesThePlaceOfOneOldOne) {
  PairMemory<int> memory(4);
  for (int i = 0; i < 8; ++i) memory.of(i, i + 100) = i + 1;
  for (int i = 0; i < 8; ++i) {
    ASSERT_NE(memory.find(i, i + 100), nullptr);
    EXPECT_EQ(*memory.find(i, i + 100), i + 1);
  }
  EXPECT_EQ(memory.of(8, 108), 0) << "the value of the old pair";
  int left = 0;
  for (int i = 0; i < 8; ++i) left += memory.find(i, i + 100) != nullptr;
  EXPECT_EQ(left, 7);
  EXPECT_NE(memory.find(8, 108), nullptr);
}

TEST(PairMemory, HasRoomForTheNumberOfPairsThatItIsMadeFor) {
  PairMemory<int> memory(32 * 32);
  for (int a = 0; a < 32; ++a)
    for (int b = 0; b < 32; ++b) memory.of(a, b) = 32 * a + b;
  for (int a = 0; a < 32; ++a) {
    for (int b = 0; b < 32; ++b) {
      ASSERT_NE(memory.find(a, b), nullptr) << a << ", " << b;
      EXPECT_EQ(*memory.find(a, b), 32 * a + b);
    }
  }
}

}  // namespace proximity_server::scene::pair_memory_test
