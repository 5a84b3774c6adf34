#include "scene/pieces/triangle_tree.h"

#include "proximity_server/narrowphase/signed_distance.h"
#include "scene/small_robots.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

namespace proximity_server::scene::triangle_tree_test {

using Eigen::Vector3d;

Effort endless() { return Effort(std::numeric_limits<double>::infinity()); }

/// The nearest point by all permutations of the corners, which must agree.
Vector3d nearestOfAnyOrder(const Triangle& triangle, const Vector3d& p) {
  const Vector3d nearest = nearestPoint(triangle, p);
  std::array<int, 3> order{0, 1, 2};
  do {
    const Vector3d other = nearestPoint({triangle[order[0]], triangle[order[1]], triangle[order[2]]}, p);
    EXPECT_LE((other - nearest).norm(), 1e-14);
  } while (std::next_permutation(order.begin(), order.end()));
  return nearest;
}

void expectNearest(const Triangle& triangle, const Vector3d& p, const Vector3d& expected) {
  const Vector3d nearest = nearestOfAnyOrder(triangle, p);
  EXPECT_LE((nearest - expected).norm(), 1e-14) << nearest.transpose() << " and not " << expected.transpose();
}

// --- one triangle: the right angle is at the origin, the legs are 4 and 2 long

const Triangle kRight{Vector3d(0, 0, 0), Vector3d(4, 0, 0), Vector3d(0, 2, 0)};

TEST(NearestPointOfATriangle, AboveItsFaceIsTheFootOfThePerpendicular) {
  expectNearest(kRight, {1, 0.5, 3}, {1, 0.5, 0});
  expectNearest(kRight, {1, 0.5, -3}, {1, 0.5, 0});
  expectNearest(kRight, {1, 0.5, 0}, {1, 0.5, 0});
}

// The long edge is x + 2 y = 4; its outward direction is (1, 2).
TEST(NearestPointOfATriangle, BesideAnEdgeIsOnTheEdge) {
  expectNearest(kRight, {3, -1, 2}, {3, 0, 0});
  expectNearest(kRight, {-5, 1.5, -1}, {0, 1.5, 0});
  expectNearest(kRight, {2 + 1, 1 + 2, 7}, {2, 1, 0});
}

TEST(NearestPointOfATriangle, BeyondACornerIsTheCorner) {
  expectNearest(kRight, {-1, -2, 1}, {0, 0, 0});
  expectNearest(kRight, {6, -1, 1}, {4, 0, 0});
  expectNearest(kRight, {-1, 5, 1}, {0, 2, 0});
}

// The square of their normals underflows, and rounding lets a few seem to be below the point.
TEST(NearestPointOfATriangle, OfAtomsIsFinite) {
  Chance chance(1);
  const auto within = [&](double size) {
    return Vector3d(size * chance.between(-1, 1), size * chance.between(-1, 1), size * chance.between(-1, 1));
  };
  constexpr double kAtom = 1.8e-108;
  for (int i = 0; i < 300000; ++i) {
    const Triangle triangle{within(kAtom), within(kAtom), within(kAtom)};
    const Vector3d p = within(1.0);
    ASSERT_NEAR((nearestPoint(triangle, p) - p).norm(), p.norm(), 1e-14) << p.transpose();
  }
}

TEST(NearestPointOfATriangle, WithoutAreaIsThatOfTheSegment) {
  const Triangle segment{Vector3d(0, 0, 0), Vector3d(1, 1, 0), Vector3d(3, 3, 0)};
  expectNearest(segment, {2, 0, 5}, {1, 1, 0});
  expectNearest(segment, {5, 3, 5}, {3, 3, 0});
  expectNearest(segment, {-5, 3, 5}, {0, 0, 0});
  expectNearest({Vector3d(1, 2, 3), Vector3d(1, 2, 3), Vector3d(1, 2, 3)}, {7, 8, 9}, {1, 2, 3});
}

// --- the tree

std::vector<Triangle> triangles(int count) {
  Chance chance(7);
  std::vector<Triangle> result;
  for (int i = 0; i < count; ++i) {
    const Vector3d centre = chance.between(0, 5) * chance.direction();
    result.push_back({centre + 0.4 * chance.direction(), centre + 0.4 * chance.direction(), centre});
  }
  return result;
}

TEST(TriangleTree, FindsTheNearestPointOfAllTriangles) {
  for (const int count : {1, 4, 5, 9, 300}) {
    const std::vector<Triangle> all = triangles(count);
    const TriangleTree tree(all);
    Effort effort = endless();
    Chance chance(9);
    for (int i = 0; i < 200; ++i) {
      const Vector3d p = chance.between(0, 8) * chance.direction();
      double smallest = std::numeric_limits<double>::infinity();
      for (const Triangle& triangle : all) smallest = std::min(smallest, (nearestPoint(triangle, p) - p).norm());
      const TriangleTree::Nearest nearest = tree.nearest(p, effort);
      EXPECT_NEAR(nearest.distance, smallest, 1e-14);
      EXPECT_NEAR((nearest.point - p).norm(), smallest, 1e-14);
      EXPECT_LE((nearestPoint(*nearest.triangle, p) - nearest.point).norm(), 1e-14) << "it belongs to another triangle";
    }
  }
}

TEST(TriangleTree, SearchesOnlyThePartOfTheDistancesThatMatters) {
  const std::vector<Triangle> all = triangles(300);
  const TriangleTree tree(all);
  Effort effort = endless();
  Chance chance(10);
  int beyond = 0, within = 0;
  for (int i = 0; i < 200; ++i) {
    const Vector3d p = chance.between(0, 8) * chance.direction();
    const double exact = tree.nearest(p, effort).distance, far = chance.between(0, 4), enough = chance.between(0, 4);
    const TriangleTree::Nearest near = tree.nearest(p, effort, nullptr, {0.0, far});
    EXPECT_EQ(near.triangle == nullptr, exact >= far);
    EXPECT_NEAR(near.distance, std::min(exact, far), 1e-14);
    beyond += exact > far;
    const TriangleTree::Nearest some = tree.nearest(p, effort, &all[i], {enough});
    EXPECT_EQ(some.distance <= enough, exact <= enough);
    EXPECT_TRUE(exact <= enough || some.distance == exact);
    EXPECT_NEAR((nearestPoint(*some.triangle, p) - p).norm(), some.distance, 1e-14);
    within += some.distance > exact;
  }
  EXPECT_GT(beyond, 20);
  EXPECT_GT(within, 20);
}

// Held against the distances of the triangles as hulls.
TEST(TriangleTree, FindsWhetherATriangleMayMeetAnyOfThem) {
  const auto shape = [](const Triangle& t) { return narrowphase::Shape(narrowphase::ConvexHull({t[0], t[1], t[2]})); };
  int met = 0, missed = 0;
  for (const int count : {1, 5, 60}) {
    const std::vector<Triangle> all = triangles(count);
    const TriangleTree tree(all);
    Effort effort = endless();
    Chance chance(11);
    for (int i = 0; i < 200; ++i) {
      Triangle other = all[i % count];
      const Vector3d offset = chance.between(0, 0.8) * chance.direction();
      for (Vector3d& corner : other) corner += offset + 0.3 * chance.direction();
      bool meets = false;
      for (const Triangle& triangle : all)
        meets |= signedDistance(shape(triangle), shape(other), Eigen::Isometry3d::Identity()).distance <= 0.0;
      (meets ? met : missed) += 1;
      EXPECT_EQ(tree.mayMeet(other, effort), meets);
    }
  }
  EXPECT_GT(met, 50);
  EXPECT_GT(missed, 50);
}

TEST(TriangleTree, TrianglesInOnePlaneMeetOnlyWhereTheyOverlap) {
  const TriangleTree tree({kRight});
  Effort effort = endless();
  const auto moved = [](double x, double y) {
    return Triangle{Vector3d(x, y, 0), Vector3d(x + 1, y, 0), Vector3d(x, y + 1, 0)};
  };
  EXPECT_TRUE(tree.mayMeet(moved(1, 0.5), effort));
  EXPECT_TRUE(tree.mayMeet(moved(4, 0), effort));  // in a corner
  EXPECT_FALSE(tree.mayMeet(moved(4.001, 0), effort));
  EXPECT_FALSE(tree.mayMeet(moved(2.1, 1), effort));  // beyond the long edge, inside of its box
}

TEST(TriangleTree, EndsWhenTheEffortIsSpent) {
  const TriangleTree tree(triangles(300));
  Effort none(0.0);
  EXPECT_THROW(tree.nearest({0, 0, 0}, none), Effort::Exceeded);
}

TEST(TriangleTree, SpendsLessEffortThanLookingAtAllTriangles) {
  const TriangleTree tree(triangles(3000));
  const double whole = 1.0;
  Effort effort(whole);
  tree.nearest({1, 1, 1}, effort);
  const double spent = whole - effort.secondsLeft(), all = 3000 * 20 / 3e8;  // 20 steps a triangle
  EXPECT_GT(spent, 0.0);
  EXPECT_LT(spent, 0.2 * all);
}

// As in files of CAD: a plane of few large triangles beside a plane of many small ones. With equally many triangles in both
// children of each node a point takes 6287 steps, as most boxes are as large as a large triangle; here it takes 3140.
TEST(TriangleTree, KeepsFewLargeTrianglesApartFromManySmallOnes) {
  std::vector<Triangle> all;
  const auto add = [&](const Vector3d& p, double size) {
    all.push_back({p, p + size * Vector3d::UnitX(), p + size * Vector3d::UnitY()});
  };
  for (int i = 0; i < 4096; ++i) add({0.01 * (i % 64), 0.01 * (i / 64), 0.0}, 0.01);
  for (int i = 0; i < 64; ++i) add({0.08 * (i % 8) - 0.6, 0.08 * (i / 8) - 0.6, 0.05}, 2.0);
  const TriangleTree tree(all);
  const double whole = 1.0;
  Effort effort(whole);
  Chance chance(5);
  for (int i = 0; i < 100; ++i) tree.nearest({chance.between(0, 0.6), chance.between(0, 0.6), 0.02}, effort);
  EXPECT_LT((whole - effort.secondsLeft()) * 3e8 / 100, 4500);  // steps for one point
}

}  // namespace proximity_server::scene::triangle_tree_test
