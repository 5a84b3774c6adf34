// FCL as a third opinion. Its distances are upper bounds where its points lie in the shapes; it stalls now and then.
#include "narrowphase/certificate.h"
#include "oracle/shape_pairs.h"
#include "tools/second_opinion/fcl_shape.h"

#include <fcl/narrowphase/collision.h>
#include <fcl/narrowphase/distance.h>
#include <gtest/gtest.h>

namespace proximity_server::narrowphase::fcl_comparison_test {

struct Opinion {
  PairCase pair_case;
  SignedDistance ours;
  bool fcl_collides;
  fcl::DistanceResultd fcl;
};

const std::vector<Opinion>& opinions() {
  static const std::vector<Opinion> all = [] {
    std::mt19937 random(71);
    std::vector<Opinion> result;
    for (const NamedShape& a : solidShapes())
      for (const NamedShape& b : solidShapes())
        for (int i = 0; i < 60; ++i) {
          const double reach =
              1.5 * (a.shape.coreRadius() + a.shape.margin() + b.shape.coreRadius() + b.shape.margin());
          const PairCase c{a.name + "-" + b.name, a.shape, b.shape, randomPose(random, reach)};
          const fcl::CollisionObjectd on_a(tools::fclShape(c.a)), on_b(tools::fclShape(c.b), fcl::Transform3d(c.a_T_b));
          Opinion opinion{c, signedDistance(c.a, c.b, c.a_T_b), false, {}};
          fcl::CollisionResultd collision;
          opinion.fcl_collides = fcl::collide(&on_a, &on_b, fcl::CollisionRequestd(), collision) > 0;
          fcl::DistanceRequestd request(true);
          request.distance_tolerance = 1e-9;
          fcl::distance(&on_a, &on_b, request, opinion.fcl);
          result.push_back(opinion);
        }
    return result;
  }();
  return all;
}

TEST(FclComparison, BetweenAThirdAndTwoThirdsOverlap) {
  std::size_t overlaps = 0;
  for (const Opinion& o : opinions()) overlaps += o.fcl_collides ? 1 : 0;
  EXPECT_GT(overlaps, 3 * opinions().size() / 10);
  EXPECT_LT(overlaps, 7 * opinions().size() / 10);
}

TEST(FclComparison, BothSeeTheSameOverlaps) {
  for (const Opinion& o : opinions()) {
    if (std::abs(o.ours.distance) < 1e-5) continue;  // FCL's own tolerance is 1e-6
    EXPECT_EQ(o.fcl_collides, o.ours.distance < 0.0) << describe(o.pair_case);
  }
}

TEST(FclComparison, FclFindsNoNearerPoints) {
  int compared = 0;
  for (const Opinion& o : opinions()) {
    const Eigen::Vector3d &on_a = o.fcl.nearest_points[0], &on_b = o.fcl.nearest_points[1];
    if (o.fcl_collides || !on_a.allFinite() || !on_b.allFinite()) continue;
    if (outsideBy(o.pair_case.a, on_a) > 1e-9L) continue;
    if (outsideBy(o.pair_case.b, o.pair_case.a_T_b.inverse() * on_b) > 1e-9L) continue;
    ++compared;
    EXPECT_LE(o.ours.distance, (on_b - on_a).norm() + 3e-9) << describe(o.pair_case);
  }
  EXPECT_GT(compared, 300);
}

TEST(FclComparison, DistancesAgreeButForFclsStalls) {
  int compared = 0, agreed = 0;
  for (const Opinion& o : opinions()) {
    if (o.fcl_collides) continue;
    ++compared;
    agreed += std::abs(o.fcl.min_distance - o.ours.distance) < 1e-6 ? 1 : 0;
  }
  EXPECT_GT(compared, 300);
  EXPECT_GT(agreed, 9 * compared / 10);
}

}  // namespace proximity_server::narrowphase::fcl_comparison_test
