#include "node/record/record_ring.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <deque>
#include <random>
#include <thread>
#include <vector>

namespace proximity_server::node::record_ring_test {

bool append(RecordRing& ring, const std::vector<std::uint8_t>& bytes) {
  std::uint8_t* const place = ring.reserve(bytes.size());
  if (!place) return false;
  std::copy(bytes.begin(), bytes.end(), place);
  ring.commit();
  return true;
}

std::vector<std::uint8_t> take(RecordRing& ring) {
  const RecordRing::Entry entry = ring.front();
  std::vector<std::uint8_t> bytes(entry.data, entry.data + entry.size);
  ring.pop();
  return bytes;
}

TEST(RecordRing, GivesWhatWasAppendedInItsOrderAcrossTheEndOfItsMemory) {
  RecordRing ring(256);
  std::deque<std::vector<std::uint8_t>> expected;
  std::mt19937 random(1);
  int refused = 0, taken = 0;
  for (int i = 0; i < 20000; ++i) {
    const std::vector<std::uint8_t> bytes(random() % 100, static_cast<std::uint8_t>(i));
    if (random() % 2 == 0 && append(ring, bytes)) {
      expected.push_back(bytes);
    } else if (!expected.empty()) {
      ++refused;
      ++taken;
      ASSERT_EQ(take(ring), expected.front()) << i;
      expected.pop_front();
    }
  }
  EXPECT_GT(refused, 1000);
  EXPECT_GT(taken, 1000);
}

TEST(RecordRing, RefusesWhatDoesNotFitAndIsThenAsBefore) {
  RecordRing ring(64);
  EXPECT_FALSE(append(ring, std::vector<std::uint8_t>(57)));
  EXPECT_TRUE(append(ring, std::vector<std::uint8_t>(56, 7)));
  EXPECT_FALSE(append(ring, {}));
  EXPECT_EQ(take(ring), std::vector<std::uint8_t>(56, 7));
  EXPECT_EQ(ring.front().data, nullptr);
  EXPECT_FALSE(append(*std::make_unique<RecordRing>(0), {}));
}

TEST(RecordRing, HandsEntriesFromOneThreadToAnother) {
  RecordRing ring(1024);
  constexpr std::uint32_t kEntries = 5000;
  std::thread writer([&] {
    for (std::uint32_t i = 0; i < kEntries;)
      if (std::uint8_t* const place = ring.reserve(sizeof i)) {
        std::memcpy(place, &i, sizeof i);
        ring.commit();
        ++i;
      } else {
        std::this_thread::yield();
      }
  });
  std::uint32_t wrong = 0;
  for (std::uint32_t i = 0; i < kEntries;) {
    const RecordRing::Entry entry = ring.front();
    if (!entry.data) {
      std::this_thread::yield();
      continue;
    }
    wrong += entry.size != sizeof i || std::memcmp(entry.data, &i, sizeof i) != 0;
    ring.pop();
    ++i;
  }
  writer.join();
  EXPECT_EQ(wrong, 0u);
}

}  // namespace proximity_server::node::record_ring_test
