#include "scene/query/closest_pieces.h"

#include "proximity_server/narrowphase/signed_distance.h"
#include "scene/model/numbers.h"
#include "scene/small_robots.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace proximity_server::scene::closest_pieces_test {

using namespace narrowphase;

using Eigen::Isometry3d;
using Eigen::Vector3d;

constexpr double kTolerance = Question().tolerance;

SignedDistance resultOf(double lower_bound, double distance, double upper_bound, Status status = Status::Converged) {
  SignedDistance result;
  result.status = status;
  result.lower_bound = lower_bound;
  result.distance = distance;
  result.upper_bound = upper_bound;
  return result;
}
SignedDistance exactly(double distance) { return resultOf(distance, distance, distance); }

Question withoutDepth() {
  Question question;
  question.depth = Question::Depth::NotWanted;
  return question;
}

const LeafPair kFirst{1, 2}, kSecond{3, 4};

// --- padding

// Points at x = 1 and x = 3 with a padding of 0.5: each surface moves out by a quarter.
TEST(Padded, MovesBothSurfacesOutwardsByHalfOfThePadding) {
  SignedDistance result = resultOf(1.75, 2.0, 2.25);
  result.normal = Vector3d::UnitX();
  result.point_a = {1, 5, 6};
  result.point_b = {3, 5, 6};
  const SignedDistance less = padded(result, 0.5);
  EXPECT_EQ(less.distance, 1.5);
  EXPECT_EQ(less.lower_bound, 1.25);
  EXPECT_EQ(less.upper_bound, 1.75);
  EXPECT_EQ(less.point_a, Vector3d(1.25, 5, 6));
  EXPECT_EQ(less.point_b, Vector3d(2.75, 5, 6));
}

// --- the limit

TEST(IsBeyond, MeansProvenToBeFartherThanTheLimit) {
  EXPECT_TRUE(isBeyond(resultOf(1.1, 1.2, 1.3), 1.0));
  EXPECT_FALSE(isBeyond(resultOf(1.0, 1.2, 1.3), 1.0));
  EXPECT_FALSE(isBeyond(resultOf(0.9, 1.2, 1.3), 1.0));
}

TEST(IsFinal, IsAnOverlapWhoseDepthNobodyAskedFor) {
  EXPECT_TRUE(isFinal(exactly(-0.1), withoutDepth()));
  EXPECT_TRUE(isFinal(exactly(0.0), withoutDepth()));
  EXPECT_FALSE(isFinal(exactly(0.1), withoutDepth()));
  EXPECT_TRUE(isFinal(resultOf(-kInfinity, 0.1, 0.0, Status::Threshold), withoutDepth()));
  EXPECT_FALSE(isFinal(exactly(-0.1), Question()));
}

TEST(LimitOfClosestPieces, IsTheOuterOneUntilSomethingNearerIsFound) {
  ClosestPieces closest;
  EXPECT_EQ(closest.limit(1.0, {}), 1.0);
  closest.offer(kFirst, exactly(2.0), 1.0);  // beyond
  EXPECT_EQ(closest.limit(1.0, {}), 1.0);
  closest.offer(kSecond, exactly(0.5), 1.0);
  EXPECT_EQ(closest.limit(1.0, {}), 0.5);
  EXPECT_EQ(closest.limit(0.25, {}), 0.25);
}

TEST(LimitOfClosestPieces, LeavesNothingAfterAnOverlapWhoseDepthNobodyAskedFor) {
  ClosestPieces closest;
  closest.offer(kFirst, exactly(-0.1), kInfinity);
  EXPECT_EQ(closest.limit(kInfinity, withoutDepth()), -kInfinity);
  EXPECT_EQ(closest.limit(kInfinity, {}), -0.1);
}

// --- offers

TEST(ClosestPieces, AreEmptyBeforeTheFirstOffer) {
  const ClosestPieces closest;
  EXPECT_TRUE(closest.empty());
  EXPECT_TRUE(closest.is_beyond);
  EXPECT_EQ(closest.lower_bound, kInfinity);
  EXPECT_EQ(closest.upper_bound, kInfinity);
}

TEST(ClosestPieces, TakeTheFirstOfferAlsoWhereItIsBeyondTheLimit) {
  ClosestPieces closest;
  closest.offer(kFirst, exactly(2.0), 1.0);
  EXPECT_EQ(closest.leaves, kFirst);
  EXPECT_TRUE(closest.is_beyond);
  EXPECT_EQ(closest.result.distance, 2.0);
}

TEST(ClosestPieces, TakeWhatIsCloser) {
  ClosestPieces closest;
  closest.offer(kFirst, exactly(0.5), 1.0);
  closest.offer(kSecond, exactly(0.25), 1.0);
  EXPECT_EQ(closest.leaves, kSecond);
  EXPECT_EQ(closest.result.distance, 0.25);
  EXPECT_FALSE(closest.is_beyond);
}

TEST(ClosestPieces, KeepTheFirstOfEqualDistances) {
  ClosestPieces closest;
  closest.offer(kFirst, exactly(0.5), 1.0);
  closest.offer(kSecond, exactly(0.5), 1.0);
  EXPECT_EQ(closest.leaves, kFirst);
}

// The distance of what is beyond the limit is its lower bound only; here it is smaller than that of what is not beyond.
TEST(ClosestPieces, TakeWhatIsWithinTheLimitBeforeWhatIsBeyond) {
  const SignedDistance beyond = resultOf(1.1, 1.1, 9.0, Status::Threshold), within = resultOf(0.9, 1.5, 1.6);
  ClosestPieces closest;
  closest.offer(kFirst, beyond, 1.0);
  closest.offer(kSecond, within, 1.0);
  EXPECT_EQ(closest.leaves, kSecond);
  EXPECT_FALSE(closest.is_beyond);
  closest.offer(kFirst, beyond, 1.0);
  EXPECT_EQ(closest.leaves, kSecond);
  EXPECT_FALSE(closest.is_beyond);
}

TEST(ClosestPieces, AreBoundedByTheSmallestBoundsOfAllOffers) {
  ClosestPieces closest;
  closest.offer(kFirst, resultOf(0.5, 0.6, 0.7), 2.0);
  closest.offer(kSecond, resultOf(0.25, 0.65, 0.9, Status::IterationLimit), 2.0);
  closest.offer({5, 6}, resultOf(0.375, 0.8, 0.9, Status::Degenerate), 2.0);
  EXPECT_EQ(closest.leaves, kFirst);
  EXPECT_EQ(closest.lower_bound, 0.25);
  EXPECT_EQ(closest.lower_bound_status, Status::IterationLimit);
  EXPECT_EQ(closest.upper_bound, 0.7);
  closest.offer({7, 8}, resultOf(0.3, 0.55, 0.625), 2.0);
  EXPECT_EQ(closest.lower_bound, 0.25);
  EXPECT_EQ(closest.upper_bound, 0.625);
}

// --- searches

/// Two floating links; b stands in the frame of a.
struct TwoCompounds {
  TwoCompounds(const std::string& of_a, const std::string& of_b) : model(floatingLinks({of_a, of_b})) {}

  ClosestPieces closest(const RelativePose& a_T_b, double limit = kInfinity, const Question& question = {},
                        const LeafPair& likely = {}, double padding = 0.0, Skipping skipping = Skipping::On) const {
    PieceSearch search(model.pieces.size(), skipping);
    return search.between({robot[a], robot[b], a_T_b, padding}, likely, limit, question);
  }

  std::vector<int> leavesBelow(int volume) const {
    const Volume& top = (*robot.volumes())[volume];
    if (top.isLeaf()) return {volume};
    std::vector<int> leaves = leavesBelow(top.parts[0]);
    const std::vector<int> others = leavesBelow(top.parts[1]);
    leaves.insert(leaves.end(), others.begin(), others.end());
    return leaves;
  }

  std::vector<LeafPair> allPairs() const {
    std::vector<LeafPair> pairs;
    for (const int leaf_a : leavesBelow(a))
      for (const int leaf_b : leavesBelow(b)) pairs.push_back({leaf_a, leaf_b});
    return pairs;
  }

  const Piece& pieceOf(int leaf) const { return model.pieces[(*robot.volumes())[leaf].piece]; }

  /// By the narrowphase alone, without bounds and memory.
  double distanceOf(const LeafPair& pair, const RelativePose& a_T_b) const {
    const Piece &piece_a = pieceOf(pair.a), &piece_b = pieceOf(pair.b);
    Isometry3d pose = Isometry3d::Identity();
    pose.linear() = a_T_b.rotation;
    pose.translation() = a_T_b.translation;
    return signedDistance(piece_a.shape, piece_b.shape, piece_a.body_T_piece.inverse() * pose * piece_b.body_T_piece)
        .distance;
  }

  double smallestDistance(const RelativePose& a_T_b) const {
    double smallest = kInfinity;
    for (const LeafPair& pair : allPairs()) smallest = std::min(smallest, distanceOf(pair, a_T_b));
    return smallest;
  }

  const RobotModel model;
  const PlacedRobot robot{model, std::make_shared<const Volumes>(model)};
  const int a = model.findLink("0"), b = model.findLink("1");
};

RelativePose shifted(double x, double y, double z) { return {Eigen::Matrix3d::Identity(), {x, y, z}}; }

std::string ballsAlongX(int count) {
  std::string balls;
  for (int i = 0; i < count; ++i) balls += ball("0.5", std::to_string(2 * i) + " 0 0");
  return balls;
}

std::string mixture(int count, double turn) {
  std::string collisions;
  for (int i = 0; i < count; ++i) {
    const std::string place =
        std::to_string(0.7 * (i % 3)) + " " + std::to_string(0.5 * (i % 5)) + " " + std::to_string(0.3 * i);
    const std::string angles = std::to_string(turn) + " 0.2 " + std::to_string(i);
    if (i % 3 == 0) collisions += box("0.2 0.4 0.1", place, angles);
    if (i % 3 == 1) collisions += cylinder("0.1", "0.6", place, angles);
    if (i % 3 == 2) collisions += ball("0.15", place);
  }
  return collisions;
}

// Balls of radius 0.5 at x = 0, 2, 4, 6, 8 and one at (4, 3, 0): the third is 3 - 1 from it.
TEST(PieceSearch, FindsTheClosestOfManyAndOne) {
  const TwoCompounds compounds(ballsAlongX(5), ball("0.5"));
  const RelativePose pose = shifted(4, 3, 0);
  const ClosestPieces closest = compounds.closest(pose);
  ASSERT_FALSE(closest.empty());
  EXPECT_FALSE(closest.is_beyond);
  EXPECT_NEAR(closest.result.distance, 2.0, kTolerance);
  EXPECT_EQ(compounds.pieceOf(closest.leaves.a).body_T_piece.translation(), Vector3d(4, 0, 0));
  EXPECT_EQ(closest.leaves.b, compounds.b);
  EXPECT_LE(closest.lower_bound, 2.0);
  EXPECT_GE(closest.lower_bound, 2.0 - kTolerance);
  EXPECT_GE(closest.upper_bound, 2.0);
}

TEST(PieceSearch, FindsTheClosestOfOneAndMany) {
  const TwoCompounds compounds(ball("0.5"), ballsAlongX(5));
  const ClosestPieces closest = compounds.closest(shifted(-6, 0, 2));
  EXPECT_NEAR(closest.result.distance, 1.0, kTolerance);
  EXPECT_EQ(compounds.pieceOf(closest.leaves.b).body_T_piece.translation(), Vector3d(6, 0, 0));
}

TEST(PieceSearch, OfTwoSinglePiecesIsTheirDistance) {
  const ClosestPieces closest = TwoCompounds(ball("0.5"), ball("0.5")).closest(shifted(0, 0, 3));
  EXPECT_NEAR(closest.result.distance, 2.0, kTolerance);
}

// In one place ball 0 is 0.1 deep, in another ball 4 is 0.75 deep.
TEST(PieceSearch, FindsTheDeepestOfSeveralOverlaps) {
  const TwoCompounds compounds(ballsAlongX(5), ball("0.5", "0 0.9 0") + ball("0.5", "8 0.25 0"));
  const ClosestPieces closest = compounds.closest(shifted(0, 0, 0));
  EXPECT_NEAR(closest.result.distance, -0.75, kTolerance);
  EXPECT_EQ(compounds.pieceOf(closest.leaves.a).body_T_piece.translation(), Vector3d(8, 0, 0));
}

TEST(PieceSearch, FindsTheSameAsAllPairsOneByOne) {
  const TwoCompounds compounds(mixture(7, 0.3), mixture(6, 1.1));
  Chance chance(51);
  int apart = 0, overlapping = 0;
  for (int i = 0; i < 600; ++i) {
    const Isometry3d pose = chance.pose(1.0);
    const RelativePose a_T_b{pose.linear(), pose.translation()};
    const double truth = compounds.smallestDistance(a_T_b);
    for (const Skipping skipping : {Skipping::On, Skipping::Off}) {
      const ClosestPieces closest = compounds.closest(a_T_b, kInfinity, {}, {}, 0.0, skipping);
      EXPECT_NEAR(closest.result.distance, truth, 2.0 * kTolerance);
      EXPECT_NEAR(compounds.distanceOf(closest.leaves, a_T_b), truth, 2.0 * kTolerance);
      EXPECT_LE(closest.lower_bound, truth + kTolerance);
      EXPECT_GE(closest.upper_bound, truth - kTolerance);
    }
    (truth > 0.0 ? apart : overlapping) += 1;
  }
  EXPECT_GT(apart, 50);
  EXPECT_GT(overlapping, 50);
}

// In float, in which the bounds are computed, the squares of the longer ones would overflow.
TEST(PieceSearch, FindsTheClosestHoweverFarTheyAre) {
  const TwoCompounds compounds(ballsAlongX(5), mixture(6, 1.1));
  for (const double far : {1e6, 1e12, 1e14, 1e16, 1e20, 1e25, 1e29}) {
    const RelativePose a_T_b = shifted(far, -0.5 * far, 0.25 * far);
    const double truth = compounds.smallestDistance(a_T_b),
                 rounding = 32.0 * std::numeric_limits<double>::epsilon() * far;
    const ClosestPieces closest = compounds.closest(a_T_b, 1.5 * truth);
    ASSERT_FALSE(closest.empty()) << far;
    EXPECT_NEAR(closest.result.distance, truth, rounding) << far;
    EXPECT_LE(closest.lower_bound, truth + rounding) << far;
    EXPECT_GE(closest.upper_bound, truth - rounding) << far;
  }
}

TEST(PieceSearch, FindsTheSameWhateverIsLikely) {
  const TwoCompounds compounds(mixture(5, 0.3), mixture(4, 1.1));
  const Isometry3d pose = turned(0.5, {1, 2, 3}, {1.5, 1.0, 0.5});
  const RelativePose a_T_b{pose.linear(), pose.translation()};
  const ClosestPieces expected = compounds.closest(a_T_b);
  for (const LeafPair& likely : compounds.allPairs()) {
    const ClosestPieces closest = compounds.closest(a_T_b, kInfinity, {}, likely);
    EXPECT_EQ(closest.leaves, expected.leaves);
    EXPECT_NEAR(closest.result.distance, expected.result.distance, kTolerance);
    EXPECT_NEAR(closest.lower_bound, expected.lower_bound, kTolerance);
  }
}

// The closest two are 2 apart.
TEST(PieceSearch, ProvesThatNothingIsCloserThanALimitBelowTheDistance) {
  const TwoCompounds compounds(ballsAlongX(5), ball("0.5"));
  const ClosestPieces closest = compounds.closest(shifted(4, 3, 0), 1.9);
  EXPECT_TRUE(closest.empty() || closest.is_beyond);
  EXPECT_GT(closest.lower_bound, 1.9);
  EXPECT_LE(closest.lower_bound, 2.0);
}

TEST(PieceSearch, FindsWhatIsCloserThanALimitAboveTheDistance) {
  const TwoCompounds compounds(ballsAlongX(5), ball("0.5"));
  const ClosestPieces closest = compounds.closest(shifted(4, 3, 0), 2.1);
  EXPECT_FALSE(closest.is_beyond);
  EXPECT_NEAR(closest.result.distance, 2.0, kTolerance);
}

TEST(PieceSearch, TakesThePaddingOffDistanceAndBounds) {
  const TwoCompounds compounds(ballsAlongX(5), ball("0.5"));
  const RelativePose pose = shifted(4, 3, 0);
  const ClosestPieces closest = compounds.closest(pose, kInfinity, {}, {}, 0.25);
  EXPECT_NEAR(closest.result.distance, 1.75, kTolerance);
  EXPECT_NEAR(closest.lower_bound, 1.75, kTolerance);
  EXPECT_FALSE(compounds.closest(pose, 1.8, {}, {}, 0.25).is_beyond);
  EXPECT_TRUE(compounds.closest(pose, 1.7, {}, {}, 0.25).is_beyond);
  EXPECT_LE(compounds.closest(pose, 1.7, {}, {}, 0.25).lower_bound, 1.75);
}

// The limit lies between the padded distance and the one without padding.
TEST(PieceSearch, ComparesTheLimitWithThePaddedDistance) {
  const TwoCompounds compounds(mixture(7, 0.3), mixture(6, 1.1));
  const double padding = 0.25;
  Chance chance(53);
  for (int i = 0; i < 200; ++i) {
    const Isometry3d pose = chance.pose(2.0);
    const RelativePose a_T_b{pose.linear(), pose.translation()};
    const double truth = compounds.smallestDistance(a_T_b) - padding;
    const ClosestPieces closest = compounds.closest(a_T_b, truth + 0.1, {}, {}, padding);
    EXPECT_EQ(closest.result.status, Status::Converged);
    EXPECT_NEAR(closest.result.distance, truth, 2.0 * kTolerance);
    const ClosestPieces none = compounds.closest(a_T_b, truth - 0.1, {}, {}, padding);
    EXPECT_TRUE(none.is_beyond);
    EXPECT_GT(none.lower_bound, truth - 0.1);
    EXPECT_LE(none.lower_bound, truth + kTolerance);
  }
}

TEST(PieceSearch, WithoutDepthEndsAtAnyOverlap) {
  const TwoCompounds compounds(mixture(7, 0.3), mixture(7, 0.3));
  const ClosestPieces closest = compounds.closest(shifted(0.05, 0, 0), kInfinity, withoutDepth());
  ASSERT_FALSE(closest.empty());
  EXPECT_TRUE(isFinal(closest.result, withoutDepth()));
  EXPECT_LE(closest.upper_bound, 0.0);
}

// Regression: the depth of two balls is known, but not which of the balls are the deepest, and yet the answer of a
// scene said Converged with bounds far apart.
TEST(PieceSearch, WithoutDepthSaysThatOthersMayBeDeeper) {
  const TwoCompounds compounds(ball("0.5") + ball("0.5", "0.6 0 0"), ball("0.5"));
  for (const int leaf : compounds.leavesBelow(compounds.a)) {
    const bool is_deeper = compounds.pieceOf(leaf).body_T_piece.translation().x() == 0.0;  // by 0.4
    if (is_deeper) continue;
    const ClosestPieces closest = compounds.closest(shifted(0.1, 0, 0), kInfinity, withoutDepth(), {leaf, compounds.b});
    EXPECT_NEAR(closest.upper_bound, -0.5, kTolerance);
    EXPECT_LE(closest.lower_bound, -0.9);
    EXPECT_GE(closest.lower_bound, -0.9 - 4.0 * LeafGaps::kError);
    EXPECT_EQ(closest.lower_bound_status, Status::Threshold);
  }
}

}  // namespace proximity_server::scene::closest_pieces_test
