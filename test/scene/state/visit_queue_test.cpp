#include "scene/state/visit_queue.h"

#include "scene/model/numbers.h"

#include <gtest/gtest.h>

namespace proximity_server::scene::visit_queue_test {

Visit visitOf(double lower_bound, int number) { return {{0, 0}, lower_bound, number, 0.0}; }

std::vector<int> numbersInOrder(VisitQueue& queue) {
  std::vector<int> numbers;
  while (!queue.empty()) numbers.push_back(queue.pop().number);
  return numbers;
}

TEST(VisitQueue, GivesTheSmallestLowerBoundFirst) {
  VisitQueue queue;
  const double bounds[] = {0.3, -0.2, 5.0, 0.0, kInfinity, -kInfinity, 0.1};
  for (int i = 0; i < 7; ++i) queue.push(visitOf(bounds[i], i));
  EXPECT_EQ(numbersInOrder(queue), (std::vector<int>{5, 1, 3, 6, 0, 2, 4}));
}

TEST(VisitQueue, GivesEqualBoundsByTheirNumbers) {
  VisitQueue queue;
  for (const int number : {4, 1, 3, 0, 2}) queue.push(visitOf(0.5, number));
  EXPECT_EQ(numbersInOrder(queue), (std::vector<int>{0, 1, 2, 3, 4}));
}

TEST(VisitQueue, TakesAVisitBackWithAnotherBound) {
  VisitQueue queue;
  for (int i = 0; i < 3; ++i) queue.push(visitOf(i, i));
  Visit first = queue.pop();
  first.lower_bound = 1.5;
  queue.push(first);
  EXPECT_EQ(numbersInOrder(queue), (std::vector<int>{1, 0, 2}));
}

TEST(VisitQueue, LowestBoundIsThatOfTheFirst) {
  VisitQueue queue;
  EXPECT_EQ(queue.lowestBound(), kInfinity);
  queue.push(visitOf(0.5, 0));
  queue.push(visitOf(0.25, 1));
  EXPECT_EQ(queue.lowestBound(), 0.25);
  queue.pop();
  EXPECT_EQ(queue.lowestBound(), 0.5);
}

TEST(VisitQueue, KeepsAllOfAVisit) {
  VisitQueue queue;
  queue.push({{2, 3}, 0.5, 1, 0.25, Visit::Bound::Motion});
  const Visit visit = queue.pop();
  EXPECT_EQ(visit.a, 2);
  EXPECT_EQ(visit.b, 3);
  EXPECT_EQ(visit.padding, 0.25);
  EXPECT_EQ(visit.bound, Visit::Bound::Motion);
}

TEST(VisitQueue, HoldsThoseThatWereNotGiven) {
  VisitQueue queue;
  for (int i = 0; i < 4; ++i) queue.push(visitOf(i, i));
  queue.pop();
  EXPECT_EQ(queue.all().size(), 3u);
  for (const Visit& visit : queue.all()) EXPECT_GT(visit.number, 0);
  queue.clear();
  EXPECT_TRUE(queue.empty());
  EXPECT_TRUE(queue.all().empty());
}

}  // namespace proximity_server::scene::visit_queue_test
