// A query takes no memory from the heap.
#include "allocations.h"
#include "chance.h"
#include "heap_in_use.h"
#include "oracle/shape_pairs.h"
#include "proximity_server/narrowphase/motion/motion.h"
#include "proximity_server/narrowphase/signed_distance.h"
#include "sanitized.h"

#include <gtest/gtest.h>

#include <vector>

namespace proximity_server::narrowphase::allocation_test {

TEST(Allocation, CounterSeesOperatorNew) {
  const long before = allocations();
  const std::vector<double> on_the_heap(100, 1.0);
  EXPECT_GT(allocations(), before) << on_the_heap.size();
}

TEST(Allocation, QueryTakesNoMemory) {
  const std::vector<PairCase> cases = pairsInEveryState(allShapes(), 1, /*seed=*/31);
  for (const PairCase& c : cases) {
    WarmStart warm_start;
    const long before = allocations();
    const double cold = signedDistance(c.a, c.b, c.a_T_b).distance;
    const double warm = signedDistance(c.a, c.b, c.a_T_b, Options::above(0.1), warm_start).lower_bound;
    const long taken = allocations() - before;
    EXPECT_EQ(taken, 0) << cold << warm << describe(c);
  }
}

TEST(Allocation, SearchAboutAnAxisTakesNoMemory) {
  const Shape ellipsoid = Ellipsoid{{0.3, 0.3, 0.4}}, cone = Cone{0.2, 0.6};
  Eigen::Isometry3d a_T_b(Eigen::AngleAxisd(1e-3, Eigen::Vector3d::UnitX()));
  const long before = allocations();
  const SignedDistance result = signedDistance(ellipsoid, cone, a_T_b);
  EXPECT_EQ(allocations() - before, 0);
  EXPECT_GE(result.iterations, 64) << "the search about an axis was not reached";
}

TEST(Allocation, QueryOfAHullFarFromItsOriginTakesNoMemory) {
  const Eigen::Vector3d far(1e6, 0, 0);
  const Shape hull = ConvexHull({far, far + Eigen::Vector3d(1, 0, 0), far + Eigen::Vector3d(0, 1, 0)}),
              box = Box{{1, 1, 1}};
  ASSERT_TRUE(hull.isFarFromOrigin());
  const Eigen::Isometry3d a_T_b(Eigen::Translation3d(Eigen::Vector3d(0, 0, 0.5) - far));
  const long before = allocations();
  const SignedDistance result = signedDistance(box, hull, a_T_b);
  EXPECT_EQ(allocations() - before, 0);
  EXPECT_EQ(result.status, Status::Converged) << "the search near the origin was not reached";
}

// Regression: nearly all vertices are the farthest within the rounding of their place, in each direction, and each cell
// of the table had its own list of them: 88 MB.
TEST(Allocation, HullHardlyLargerThanTheRoundingOfItsPlaceTakesLittleMemory) {
  Chance random(34);
  std::vector<Eigen::Vector3d> points;
  const int count = kIsSanitized ? 4000 : 20000;
  for (int i = 0; i < count; ++i) points.push_back(Eigen::Vector3d::Constant(1.0) + 3e-14 * randomDirection(random));
  const ConvexHull hull(points);
  ASSERT_GT(hull.size(), count / 20);
  const std::size_t before = heapInUse();
  const HullSupport support(hull);
  EXPECT_LT(heapInUse() - before, 10'000'000) << support.hull().size();
}

TEST(Allocation, MotionTakesNoMemory) {
  const std::vector<PairCase> cases = pairsInEveryState(allShapes(), 1, /*seed=*/32);
  Chance random(33);
  for (const PairCase& c : cases) {
    const MotionChain a_motion = {{randomPose(random, 0.5), randomDirection(random), 2.0 * randomDirection(random)}};
    const MotionChain b_motion = {a_motion.front(), {c.a_T_b, randomDirection(random), randomDirection(random)}};
    MinimumOptions options;
    options.max_queries = 50;
    const long before = allocations();
    const double free = timeOfContact(c.a, a_motion, c.b, b_motion).t_free;
    const double smallest = minimumDistance(c.a, a_motion, c.b, b_motion, options).lower_bound;
    const long taken = allocations() - before;
    EXPECT_EQ(taken, 0) << free << smallest << describe(c);
  }
}

}  // namespace proximity_server::narrowphase::allocation_test
