#include "tools/second_opinion/proven_bounds.h"

#include "sanitized.h"
#include "tools/second_opinion/single_piece.h"

#include <gtest/gtest.h>

namespace proximity_server::tools::proven_bounds_test {

using namespace narrowphase;

using Eigen::Isometry3d;
using Eigen::Vector3d;

/// [m] What rounding leaves open of solids of size 1, and what the polytope leaves open where a curved one is deep.
constexpr double kTight = 1e-8, kCurved = 0.03;

TEST(ExtentAlong, IsThatOfTheSupportPointOfTheOracle) {
  std::mt19937 random(5);
  for (const NamedShape& shape : allShapes())
    for (int i = 0; i < repeats(300); ++i) {
      const Vector3l direction = randomDirection(random).cast<long double>();
      const long double expected =
          direction.dot(coreSupport(shape.shape, direction)) + shape.shape.margin() * direction.norm();
      EXPECT_NEAR(static_cast<double>(extentAlong(shape.shape, direction) - expected), 0.0, 1e-15) << shape.name;
    }
}

TEST(PointInside, LiesInTheShapeAndDoesNotMoveWhatDoes) {
  std::mt19937 random(6);
  std::uniform_real_distribution<double> coordinate(-1.5, 1.5);
  int moved = 0;
  for (const NamedShape& shape : allShapes())
    for (int i = 0; i < repeats(300); ++i) {
      const Vector3d point(coordinate(random), coordinate(random), coordinate(random));
      const Vector3d inside = pointInside(shape.shape, point);
      EXPECT_LE(outsideBy(shape.shape, inside), 1e-14L) << shape.name;
      if (shape.shape.kind() == Shape::Kind::Hull && shape.shape.hull().dimension() < 3) continue;
      if (outsideBy(shape.shape, point) <= 0.0L)
        EXPECT_LE((inside - point).norm(), 1e-14) << shape.name;
      else
        ++moved;
    }
  EXPECT_GT(moved, repeats(1000));
}

/// Without hints: the axes and points are those of the narrowphase.
TEST(ProvenBounds, EncloseTheTruthOfTheOracle) {
  int apart = 0, deep = 0;
  for (const PairCase& pair : pairsInEveryState(solidShapes(), repeats(2), 17)) {
    const SinglePieces pieces(pair);
    const ProvenBounds proven = provenBounds(pieces.a(), pieces.b(), {});
    const Truth truth = signedDistanceOracle(pair.pair(), 20000);
    EXPECT_LE(proven.lower, truth.distance + truth.error_bound) << describe(pair);
    EXPECT_GE(proven.upper, truth.distance) << describe(pair);
    if (truth.distance > 1e-3L) {
      ++apart;
      EXPECT_LE(proven.upper - proven.lower, kTight) << describe(pair);
    } else if (truth.distance < -1e-3L) {
      ++deep;
      const bool is_curved = !pair.a.isPolytope() || !pair.b.isPolytope() || pair.a.margin() + pair.b.margin() > 0.0;
      EXPECT_LE(proven.upper - proven.lower, is_curved ? kCurved : kTight) << describe(pair);
    }
  }
  if (!kIsSanitized) {
    EXPECT_GT(apart, 50);
    EXPECT_GT(deep, 50);
  }
}

// On paper: two unit boxes side by side, 1 m between them.
TEST(ProvenBounds, AHintCannotMakeThemWrong) {
  const SinglePieces boxes({"boxes", Box{{1, 1, 1}}, Box{{1, 1, 1}}, at(2, 0, 0)});
  const double nan = std::numeric_limits<double>::quiet_NaN();
  Hints lies;
  lies.axes = {{0, 1, 0}, {0, 0, 0}, {nan, 0, 0}, {-1, 0, 0}};
  lies.points = {{{1.2, 0, 0}, {1.3, 0, 0}}, {{nan, 0, 0}, {1.5, 0, 0}}, {{1.4, 0, 0}, {1.4, 0, 0}}};
  const ProvenBounds proven = provenBounds(boxes.a(), boxes.b(), lies);
  EXPECT_NEAR(proven.lower, 1.0, 1e-12);
  EXPECT_NEAR(proven.upper, 1.0, 1e-12);
}

// On paper: of two boxes at 2 and 4 m the nearer one is 1.25 m from a box of 0.5 m at the origin.
TEST(ProvenBounds, OfSeveralPiecesAreThoseOfTheNearest) {
  const scene::Piece piece{Box{{1, 1, 1}}, Isometry3d::Identity(), 0},
      small{Box{{0.5, 0.5, 0.5}}, Isometry3d::Identity(), 0};
  const PlacedPieces a{{{&small, at(0, 0, 0)}}}, b{{{&piece, at(4, 0, 0)}, {&piece, at(0, 2, 0)}}};
  const ProvenBounds proven = provenBounds(a, b, {});
  EXPECT_NEAR(proven.lower, 1.25, 1e-12);
  EXPECT_NEAR(proven.upper, 1.25, 1e-12);
}

}  // namespace proximity_server::tools::proven_bounds_test
