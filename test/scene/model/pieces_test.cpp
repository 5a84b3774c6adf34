#include "scene/model/pieces.h"

#include "scene/small_robots.h"

#include <gtest/gtest.h>

#include <cmath>

namespace proximity_server::scene::pieces_test {

using namespace narrowphase;

using Eigen::Isometry3d;
using Eigen::Vector3d;

Piece pieceOf(const Shape& shape, const Isometry3d& body_T_piece = Isometry3d::Identity()) {
  return {shape, body_T_piece, 0};
}

TEST(ReachFrom, OfABallIsTheDistanceOfItsCentreAndItsRadius) {
  EXPECT_NEAR(reachFrom({3, 5, 0}, pieceOf(Sphere{1.0}, at(0, 1, 0))), 5.0 + 1.0, 1e-12);
}

// A capsule reaches half of its length and its radius from its centre.
TEST(ReachFrom, OfACapsuleHoldsItsCaps) { EXPECT_NEAR(reachFrom({0, 0, 0}, pieceOf(Capsule{0.5, 4.0})), 2.5, 1e-12); }

// In the body's frame the segment goes from (0, 1, 0) to (0, 3, 0); its far end is 5 from (4, 0, 0).
TEST(ReachFrom, OfAHullIsTheDistanceOfItsFarthestVertex) {
  const Shape segment = ConvexHull({{0, 0, 0}, {2, 0, 0}});
  const Isometry3d pose = turned(M_PI / 2, Vector3d::UnitZ(), {0, 1, 0});
  EXPECT_NEAR(reachFrom({4, 0, 0}, pieceOf(segment, pose)), 5.0, 1e-12);
  EXPECT_NEAR(reachFrom({4, 0, 0}, pieceOf(segment.padded(0.25), pose)), 5.25, 1e-12);
}

}  // namespace proximity_server::scene::pieces_test
