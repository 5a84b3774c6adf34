// The heap of a search, beside a sorted list.
#include "scene/bounds/heap.h"

#include "chance.h"

#include <gtest/gtest.h>

#include <iterator>
#include <set>

namespace proximity_server::scene::heap_test {

TEST(SearchHeap, GivesTheLargestFirst) {
  Chance random(1);
  SearchHeap<int> heap;
  std::multiset<int> expected;
  int pops = 0;
  for (int i = 0; i < 10000; ++i) {
    if (i % 1000 == 999) {
      heap.clear();
      expected.clear();
    }
    ASSERT_EQ(heap.empty(), expected.empty());
    if (expected.empty() || random() % 20 < 11) {
      const int value = static_cast<int>(random() % 100);
      heap.push(value);
      expected.insert(value);
    } else {
      ASSERT_EQ(heap.first(), *expected.rbegin());
      ASSERT_EQ(heap.pop(), *expected.rbegin());
      expected.erase(std::prev(expected.end()));
      ++pops;
    }
  }
  EXPECT_GT(pops, 4000);
}

}  // namespace proximity_server::scene::heap_test
