#include "proximity_server/scene/query/pair_distances.h"

#include <gtest/gtest.h>

#include <limits>

namespace proximity_server::scene::pair_distances_test {

const ShapeRef kObject = ShapeRef::ofObject(0);

TEST(PairDistances, OfTwoLinksCountInEitherOrderAndForSingleCollisions) {
  PairDistances distances(0.1, 0.2);
  distances.setPair(5, 2, 0.3);
  EXPECT_EQ(distances.of({{2}, {5}}), 0.3);
  EXPECT_EQ(distances.of({{5, 1}, {2}}), 0.3);
  EXPECT_EQ(distances.of({{5}, {3}}), 0.1);
  EXPECT_EQ(distances.of({{5}, kObject}), 0.2);
  distances.setPair(2, 5, 0.4);
  EXPECT_EQ(distances.of({{5}, {2}}), 0.4) << "the later one replaces the earlier one";
}

TEST(PairDistances, WithObjectsAreThoseOfTheLink) {
  PairDistances distances(0.1, 0.2);
  distances.setWithObjects(5, 0.3);
  EXPECT_EQ(distances.of({{5}, kObject}), 0.3);
  EXPECT_EQ(distances.of({kObject, {5}}), 0.3);
  EXPECT_EQ(distances.of({{2}, kObject}), 0.2);
  EXPECT_EQ(distances.of({kObject, ShapeRef::ofObject(1)}), 0.2);
  EXPECT_EQ(distances.of({{5}, {2}}), 0.1);
}

TEST(PairDistances, OfAnObjectCountBeforeThoseOfALink) {
  PairDistances distances(0.1, 0.2);
  distances.setWithObjects(5, 0.7);
  distances.setObject(3, 0.4);
  const ShapeRef own = ShapeRef::ofObject(3);
  EXPECT_EQ(distances.of({{5}, own}), 0.4);
  EXPECT_EQ(distances.of({own, {2}}), 0.4);
  EXPECT_EQ(distances.of({own, kObject}), 0.4);
  EXPECT_EQ(distances.of({kObject, own}), 0.4);
  EXPECT_EQ(distances.of({{5}, kObject}), 0.7);
  EXPECT_EQ(distances.of({{3}, kObject}), 0.2) << "a link with the number of the object";
  EXPECT_EQ(distances.of({{3}, {2}}), 0.1);
  distances.setObject(1, 0.05);
  EXPECT_EQ(distances.of({ShapeRef::ofObject(1), {5}}), 0.05) << "also a smaller one";
  EXPECT_EQ(distances.of({ShapeRef::ofObject(1), own}), 0.4) << "of two the larger one";
  distances.setObject(3, 0.3);
  EXPECT_EQ(distances.of({{5}, own}), 0.3);
}

TEST(PairDistances, OfObjectsAreInTheRangeAndComparedUntilTheyAreForgotten) {
  PairDistances distances(0.1, 0.1);
  const PairDistances before = distances;
  distances.setObject(0, 0.5);
  distances.setObject(7, 0.01);
  EXPECT_EQ(distances.range(PairKind::WithObject).smallest, 0.01);
  EXPECT_EQ(distances.range(PairKind::WithObject).largest, 0.5);
  EXPECT_EQ(distances.range(PairKind::OfLinks).largest, 0.1);
  EXPECT_EQ(distances.range(PairKind::Any).largest, 0.5);
  EXPECT_EQ(distances.largestOfObjects(), 0.5);
  EXPECT_TRUE(distances.areEqual(PairKind::OfLinks));
  EXPECT_FALSE(distances.areEqual(PairKind::WithObject));
  EXPECT_FALSE(distances.areEqual(PairKind::Any));
  EXPECT_FALSE(distances == before);
  distances.setObject(7, std::numeric_limits<double>::infinity());
  EXPECT_FALSE(distances.areFinite());
  distances.forgetObjects();
  EXPECT_TRUE(distances.areFinite());
  EXPECT_TRUE(distances.areEqual(PairKind::Any));
  EXPECT_TRUE(distances == before);
  EXPECT_EQ(distances.largestOfObjects(), -std::numeric_limits<double>::infinity());
}

TEST(PairDistances, HaveARangeForEachKindOfPair) {
  PairDistances distances(0.1, 0.2);
  distances.setPair(2, 5, -0.3);
  distances.setWithObjects(5, 0.7);
  const auto expectRange = [&](PairKind kind, double smallest, double largest) {
    EXPECT_EQ(distances.range(kind).smallest, smallest);
    EXPECT_EQ(distances.range(kind).largest, largest);
  };
  expectRange(PairKind::OfLinks, -0.3, 0.1);
  expectRange(PairKind::WithObject, 0.2, 0.7);
  expectRange(PairKind::Any, -0.3, 0.7);
}

TEST(PairDistances, AreEqualOnlyWhereNoPairOfTheKindHasItsOwn) {
  PairDistances distances(0.1, 0.1);
  EXPECT_TRUE(distances.areEqual(PairKind::Any));
  distances.setWithObjects(5, 0.1);
  EXPECT_TRUE(distances.areEqual(PairKind::OfLinks));
  EXPECT_FALSE(distances.areEqual(PairKind::WithObject));
  EXPECT_FALSE(distances.areEqual(PairKind::Any));
  EXPECT_FALSE(PairDistances(0.1, 0.2).areEqual(PairKind::Any));
}

TEST(PairDistances, AreFiniteIfEachOneIs) {
  PairDistances distances(0.1, 0.2);
  EXPECT_TRUE(distances.areFinite());
  distances.setWithObjects(5, std::numeric_limits<double>::infinity());
  EXPECT_FALSE(distances.areFinite());
}

}  // namespace proximity_server::scene::pair_distances_test
