#include "node/services/queries.h"

#include "node/answers.h"
#include "node/asked_robot.h"

#include <array>
#include <cmath>
#include <limits>
#include <set>
#include <string>

// Questions about the poses of tf. Every expected number is read off gantry.urdf.

namespace proximity_server::node::queries_test {

void expectFailure(const MinimumDistanceResponse& response, int code, const std::string& named) {
  expectRefusal(response, code, named);
  EXPECT_TRUE(saysNothing(response.pair));
}

// ---- minimum_distance

using MinimumDistance = AskedGantry;

TEST_F(MinimumDistance, OfBallAndBaseIsThatOfThePaper) {
  const ros::Time stamp = moveTo({0.5, 0.0, 0.0});
  const auto response = ask(between<MinimumDistanceRequest>("base", "ball", stamp));
  ASSERT_TRUE(response.success) << response.status.message;
  EXPECT_EQ(response.header.stamp, stamp);
  EXPECT_EQ(response.header.frame_id, "base");
  EXPECT_EQ(response.pair.state, Proximity::SEPARATED);
  EXPECT_NEAR(response.pair.distance, 0.3, kTolerance);
  EXPECT_LE(response.pair.lower_bound, 0.3 + 1e-15);  // rounding of 0.5 - 0.1 - 0.1
  EXPECT_GE(response.pair.upper_bound, 0.3 - 1e-15);
  EXPECT_TRUE(response.pair.unique);
  EXPECT_EQ(response.pair.representation, Proximity::EXACT);
}

TEST_F(MinimumDistance, GivesThePointsInTheReferenceFrameAndInTheLinks) {
  const ros::Time stamp = moveTo({0.5, 0.0, 0.0});
  const auto response = ask(between<MinimumDistanceRequest>("base", "ball", stamp));
  ASSERT_TRUE(response.pair.points_valid);
  expectNear(response.pair.point_a, 0.1, 0.0, 0.0);
  expectNear(response.pair.point_b, 0.4, 0.0, 0.0);
  expectNear(response.pair.normal, 1.0, 0.0, 0.0);
  expectNear(response.pair.point_a_link, 0.1, 0.0, 0.0);
  expectNear(response.pair.point_b_link, 0.0, 0.1, 0.0);  // the ball's frame is turned by a quarter about z
}

TEST_F(MinimumDistance, KeepsTheOrderOfTheRequest) {
  const ros::Time stamp = moveTo({0.5, 0.0, 0.0});
  const auto response = ask(between<MinimumDistanceRequest>("ball", "base", stamp));
  EXPECT_EQ(response.pair.a.link, "ball");
  EXPECT_EQ(response.pair.b.link, "base");
  expectNear(response.pair.point_a, 0.4, 0.0, 0.0);
  expectNear(response.pair.normal, -1.0, 0.0, 0.0);
}

TEST_F(MinimumDistance, WithoutNamesIsThatOfTheClosestPair) {
  MinimumDistanceRequest request;
  request.stamp = moveTo({0.0, 0.6, 0.0});
  const auto response = ask(request);
  EXPECT_NEAR(response.pair.distance, 0.2, kTolerance);
  EXPECT_EQ(links(response.pair), (std::set<std::string>{"ball", "block"}));
}

TEST_F(MinimumDistance, OfOneNamePutsThatLinkFirst) {
  MinimumDistanceRequest request;
  request.a = shape("block");
  request.stamp = moveTo({0.0, 0.6, 0.0});
  const auto response = ask(request);
  EXPECT_NEAR(response.pair.distance, 0.2, kTolerance);
  EXPECT_EQ(response.pair.a.link, "block");
  EXPECT_EQ(response.pair.b.link, "ball");
  expectNear(response.pair.normal, 0.0, -1.0, 0.0);
}

TEST_F(MinimumDistance, NamesTheClosestShapeOfALink) {
  const ros::Time stamp = moveTo({0.5, 1.0, -0.5});
  const auto response = ask(between<MinimumDistanceRequest>("ball", "block", stamp));
  EXPECT_EQ(response.pair.b.index, 2u);
  EXPECT_EQ(response.pair.b.name, "high");
  EXPECT_NEAR(response.pair.distance, 0.3, kTolerance);
}

TEST_F(MinimumDistance, OfASingleShapeIgnoresTheOthersOfItsLink) {
  // From (0.5, 1, 0) to the high cube: 0.4 along x and 0.4 along z.
  auto request = between<MinimumDistanceRequest>("ball", "block", moveTo({0.5, 1.0, 0.0}));
  const double paper = std::hypot(0.4, 0.4) - 0.1;
  EXPECT_NEAR(ask(request).pair.distance, 0.3, kTolerance);
  request.b = shape("block", 2);
  EXPECT_NEAR(ask(request).pair.distance, paper, kTolerance);
  request.b = shape("block", 0, "high");
  EXPECT_NEAR(ask(request).pair.distance, paper, kTolerance);
}

TEST_F(MinimumDistance, OfTwoShapesOfOneLinkNeverChanges) {
  MinimumDistanceRequest request;
  request.a = shape("block", 1);
  request.b = shape("block", 2);
  request.stamp = moveTo({0.5, 0.0, 0.2});
  expectFailure(ask(request), QueryStatus::PAIR_EXCLUDED, "ignore_filter");
  request.ignore_filter = true;
  EXPECT_NEAR(ask(request).pair.distance, 0.3, kTolerance);
}

TEST_F(MinimumDistance, BeyondTheThresholdProvesOnlyThat) {
  auto request = between<MinimumDistanceRequest>("base", "ball", moveTo({0.5, 0.0, 0.0}));
  request.threshold = 0.1;
  const auto response = ask(request);
  EXPECT_TRUE(response.success);
  EXPECT_EQ(response.pair.state, Proximity::BEYOND_THRESHOLD);
  EXPECT_GT(response.pair.lower_bound, 0.1);
  EXPECT_LE(response.pair.lower_bound, 0.3 + 1e-15);
  EXPECT_EQ(response.pair.distance, response.pair.lower_bound);
}

TEST_F(MinimumDistance, OfNeighboursNeedsIgnoreFilter) {
  auto request = between<MinimumDistanceRequest>("base", "block", moveTo({0.5, 0.0, 0.0}));
  expectFailure(ask(request), QueryStatus::PAIR_EXCLUDED, "adjacent");
  request.ignore_filter = true;
  const auto response = ask(request);
  ASSERT_TRUE(response.success) << response.status.message;
  EXPECT_NEAR(response.pair.distance, 0.8, kTolerance);
  EXPECT_FALSE(response.pair.unique) << "the faces are parallel";
}

TEST_F(MinimumDistance, InOverlapIsMinusTheDepth) {
  const ros::Time stamp = moveTo({0.15, 0.0, 0.0});
  const auto response = ask(between<MinimumDistanceRequest>("base", "ball", stamp));
  EXPECT_EQ(response.pair.state, Proximity::PENETRATING);
  EXPECT_NEAR(response.pair.distance, -0.05, kTolerance);
  expectNear(response.pair.point_a, 0.1, 0.0, 0.0);
  expectNear(response.pair.point_b, 0.05, 0.0, 0.0);
  expectNear(response.pair.normal, 1.0, 0.0, 0.0);
}

// ---- bad requests: the others are in the recording

using BadRequest = AskedGantry;

// Regression: it came back whole, after a long search for the nearest name.
TEST_F(BadRequest, ANameOfAnyLengthIsAnsweredWithAReadableMessage) {
  const ros::Time stamp = moveTo({0.5, 0.0, 0.0});
  const auto response = ask(between<MinimumDistanceRequest>("base", "ball" + std::string(5000000, 'x'), stamp));
  expectFailure(response, QueryStatus::UNKNOWN_LINK, "'ballxxx");
  EXPECT_LT(response.status.message.size(), 1000U);
  EXPECT_NE(response.status.message.find("bytes left out)"), std::string::npos) << response.status.message;
  EXPECT_NE(response.status.message.find("'ball'"), std::string::npos) << response.status.message;
}

// ---- time

using Stamp = AskedGantry;

TEST_F(Stamp, ZeroMeansTheLatestTimeThatAllJointsShare) {
  const ros::Time common = moveTo({0.5, 0.0, 0.0});
  const ros::Time later = common + ros::Duration(0.1);
  gantry_.publish({Gantry::slide({0.9, 0.0, 0.0}), Gantry::ball({0.9, 0.0, 0.0})}, later);
  const auto response = ask(between<MinimumDistanceRequest>("ball", "block"));  // the block needs the lift
  EXPECT_EQ(response.header.stamp, common);
  EXPECT_NEAR(response.pair.distance, std::hypot(0.4, 0.9) - 0.1, kTolerance);
}

TEST_F(Stamp, OfThePastGivesThePoseOfThen) {
  const ros::Time then = moveTo({0.5, 0.0, 0.0});
  const ros::Time now = moveTo({0.7, 0.0, 0.0});
  EXPECT_NEAR(ask(between<MinimumDistanceRequest>("base", "ball", now)).pair.distance, 0.5, kTolerance);
  EXPECT_NEAR(ask(between<MinimumDistanceRequest>("base", "ball", then)).pair.distance, 0.3, kTolerance);
}

TEST_F(Stamp, AFrameThatIsBrokenIsRefusedAndItsJointNamed) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double infinity = std::numeric_limits<double>::infinity();
  std::array<geometry_msgs::TransformStamped, 4> broken;
  broken.fill(Gantry::ball({0.5, 0.0, 0.0}));
  broken[0].transform.rotation.z = nan;
  broken[1].transform.rotation.w = 2.0;
  broken[2].transform.translation.x = nan;
  broken[3].transform.translation.x = infinity;
  for (const auto& transform : broken) {
    const ros::Time stamp = gantry_.moveTo({Gantry::slide({0.5, 0.0, 0.0}), transform});
    const auto response = ask(between<MinimumDistanceRequest>("base", "ball", stamp));
    EXPECT_FALSE(response.success);
    EXPECT_NE(response.status.message.find("'y_axis'"), std::string::npos) << response.status.message;
    EXPECT_TRUE(saysNothing(response.pair));
  }
  EXPECT_TRUE(ask(between<MinimumDistanceRequest>("base", "ball", moveTo({0.5, 0.0, 0.0}))).success);
}

// ---- separation_axis

using SeparationAxis = AskedGantry;

TEST_F(SeparationAxis, IsThatOfTheGap) {
  const auto response = ask(between<SeparationAxisRequest>("base", "ball", moveTo({0.5, 0.0, 0.0})));
  ASSERT_TRUE(response.success) << response.status.message;
  EXPECT_TRUE(response.separated);
  expectNear(response.axis, 1.0, 0.0, 0.0);
  EXPECT_NEAR(response.gap, 0.3, kTolerance);
  EXPECT_GT(response.plane_offset, 0.1);  // between the faces at 0.1 and 0.4
  EXPECT_LT(response.plane_offset, 0.4);
}

TEST_F(SeparationAxis, DeniesAGapWiderThanItIs) {
  auto request = between<SeparationAxisRequest>("base", "ball", moveTo({0.5, 0.0, 0.0}));
  request.margin = 0.31;
  const auto response = ask(request);
  EXPECT_TRUE(response.success);
  EXPECT_FALSE(response.separated);
  request.margin = 0.29;
  EXPECT_TRUE(ask(request).separated);
}

TEST_F(SeparationAxis, DoesNotExistInOverlap) {
  const auto response = ask(between<SeparationAxisRequest>("base", "ball", moveTo({0.15, 0.0, 0.0})));
  EXPECT_TRUE(response.success);
  EXPECT_FALSE(response.separated);
  EXPECT_TRUE(isNaN(response.axis));
  EXPECT_TRUE(std::isnan(response.gap) && std::isnan(response.plane_offset));
}

// ---- penetration_depth

using PenetrationDepth = AskedGantry;

TEST_F(PenetrationDepth, IsTheShortestWayOut) {
  // The centre of the ball is 0.05 under the face at x = 0.1, so the ball must move by 0.05 + 0.1.
  const auto response = ask(between<PenetrationDepthRequest>("base", "ball", moveTo({0.05, 0.0, 0.0})));
  ASSERT_TRUE(response.success) << response.status.message;
  EXPECT_TRUE(response.penetrating);
  EXPECT_NEAR(response.depth, 0.15, kTolerance);
  expectNear(response.direction, 1.0, 0.0, 0.0);
  EXPECT_LE(response.depth_lower_bound, 0.15 + 1e-15);
  EXPECT_GE(response.depth_upper_bound, 0.15 - 1e-15);
  ASSERT_TRUE(response.pair.points_valid);
  expectNear(response.pair.point_a, 0.1, 0.0, 0.0);
  expectNear(response.pair.point_b, -0.05, 0.0, 0.0);
}

TEST_F(PenetrationDepth, IsZeroApart) {
  const auto response = ask(between<PenetrationDepthRequest>("base", "ball", moveTo({0.5, 0.0, 0.0})));
  EXPECT_TRUE(response.success);
  EXPECT_FALSE(response.penetrating);
  EXPECT_EQ(response.depth, 0.0);
  EXPECT_EQ(response.depth_upper_bound, 0.0);
  EXPECT_TRUE(isNaN(response.direction));
}

TEST_F(PenetrationDepth, UpToTheThresholdIsOnlyBounded) {
  auto request = between<PenetrationDepthRequest>("base", "ball", moveTo({0.15, 0.0, 0.0}));  // 0.05 deep
  request.threshold = 0.06;
  const auto shallow = ask(request);
  EXPECT_TRUE(shallow.success) << shallow.status.message;
  EXPECT_FALSE(shallow.penetrating);
  EXPECT_LE(shallow.depth_upper_bound, 0.06);
  EXPECT_GE(shallow.depth_upper_bound, 0.05 - 1e-15);
  request.threshold = 0.04;
  const auto deep = ask(request);
  EXPECT_TRUE(deep.penetrating);
  EXPECT_NEAR(deep.depth, 0.05, kTolerance);
}

TEST_F(PenetrationDepth, WithoutNamesIsThatOfTheDeepestPair) {
  PenetrationDepthRequest request;
  request.stamp = moveTo({0.0, 0.85, 0.0});  // 0.05 deep in the block's low cube
  const auto response = ask(request);
  EXPECT_NEAR(response.depth, 0.05, kTolerance);
  EXPECT_EQ(links(response.pair), (std::set<std::string>{"ball", "block"}));
}

// ---- query_pairs

using QueryPairs = AskedGantry;

QueryPairsRequest batch(std::uint8_t mode, const ros::Time& stamp) {
  QueryPairsRequest request;
  request.mode = mode;
  request.stamp = stamp;
  return request;
}

TEST_F(QueryPairs, AsksForTheClosestOfAllByDefault) {
  QueryPairsRequest request;
  request.stamp = moveTo({0.5, 0.0, 0.0});
  const auto response = ask(request);
  ASSERT_TRUE(response.success) << response.status.message;
  ASSERT_EQ(response.pairs.size(), 1u);
  EXPECT_NEAR(response.pairs[0].distance, 0.3, kTolerance);
  EXPECT_NEAR(response.minimum.distance, 0.3, kTolerance);
  EXPECT_EQ(response.pairs_total, 2u);
  EXPECT_EQ(response.pairs_total, response.pairs_unknown + response.pairs_at_rest + response.pairs_by_motion +
                                      response.pairs_by_bounds + response.pairs_computed);
}

TEST_F(QueryPairs, PerPairKeepsTheOrderOfTheRequest) {
  auto request = batch(QueryPairsRequest::PER_PAIR, moveTo({0.0, 0.6, 0.0}));
  request.a = {shape("ball"), shape("block", 2), shape("base")};
  request.b = {shape("base"), shape("ball"), shape("ball")};
  const auto response = ask(request);
  ASSERT_TRUE(response.success) << response.status.message;
  ASSERT_EQ(response.pairs.size(), 3u);
  EXPECT_NEAR(response.pairs[0].distance, 0.4, kTolerance);
  EXPECT_NEAR(response.pairs[1].distance, std::hypot(0.3, 0.4) - 0.1, kTolerance);
  EXPECT_NEAR(response.pairs[2].distance, 0.4, kTolerance);
  EXPECT_EQ(response.pairs[0].a.link, "ball");
  EXPECT_EQ(response.pairs[1].a.name, "high");
  expectNear(response.pairs[2].normal, 0.0, 1.0, 0.0);
  EXPECT_NEAR(response.minimum.distance, 0.4, kTolerance);
}

TEST_F(QueryPairs, ClosestComeSortedAndNoMoreThanAsked) {
  auto request = batch(QueryPairsRequest::K_CLOSEST, moveTo({0.0, 0.6, 0.0}));
  request.k = 5;
  const auto both = ask(request);
  ASSERT_EQ(both.pairs.size(), 2u);
  EXPECT_NEAR(both.pairs[0].distance, 0.2, kTolerance);
  EXPECT_NEAR(both.pairs[1].distance, 0.4, kTolerance);
  request.k = 1;
  EXPECT_EQ(ask(request).pairs.size(), 1u);
}

TEST_F(QueryPairs, BelowThresholdLeavesTheOthersOut) {
  auto request = batch(QueryPairsRequest::BELOW_THRESHOLD, moveTo({0.0, 0.6, 0.0}));
  request.threshold = 0.3;
  const auto response = ask(request);
  ASSERT_EQ(response.pairs.size(), 1u);
  EXPECT_NEAR(response.pairs[0].distance, 0.2, kTolerance);
  request.threshold = 0.0;
  const auto contacts = ask(request);
  EXPECT_TRUE(contacts.success);
  EXPECT_TRUE(contacts.pairs.empty());
}

TEST_F(QueryPairs, FirstFindsOneThatIsTooCloseOrNone) {
  auto request = batch(QueryPairsRequest::FIRST, moveTo({0.0, 0.6, 0.0}));
  request.threshold = 0.25;
  const auto found = ask(request);
  ASSERT_EQ(found.pairs.size(), 1u);
  EXPECT_LE(found.pairs[0].upper_bound, 0.25);
  request.threshold = 0.15;
  EXPECT_TRUE(ask(request).pairs.empty());
}

TEST_F(QueryPairs, OfAGroupAreThoseItMoves) {
  auto request = batch(QueryPairsRequest::PER_PAIR, moveTo({0.5, 0.0, 0.0}));
  request.group = "lifted";
  const auto response = ask(request);
  ASSERT_TRUE(response.success) << response.status.message;
  ASSERT_EQ(response.pairs.size(), 1u);
  EXPECT_EQ(links(response.pairs[0]), (std::set<std::string>{"ball", "block"}));
}

TEST_F(QueryPairs, MayLeaveThePenetrationOut) {
  auto request = batch(QueryPairsRequest::PER_PAIR, moveTo({0.15, 0.0, 0.0}));
  request.a = {shape("base")};
  request.b = {shape("ball")};
  request.skip_penetration = true;
  const auto response = ask(request);
  ASSERT_TRUE(response.success) << response.status.message;
  EXPECT_EQ(response.pairs[0].state, Proximity::PENETRATING);
  EXPECT_LE(response.pairs[0].upper_bound, 0.0);
}

TEST_F(QueryPairs, UnknownPairsLeaveTheKnownOnesStanding) {
  moveTo({0.5, 0.0, 0.0});
  const ros::Time stamp = gantry_.moveTo({Gantry::slide({0.5, 0.0, 0.0}), Gantry::ball({0.5, 0.0, 0.0})});
  const auto response = ask(batch(QueryPairsRequest::PER_PAIR, stamp));
  EXPECT_FALSE(response.success);
  EXPECT_EQ(response.status.code, QueryStatus::TF_EXTRAPOLATION);
  EXPECT_NE(response.status.message.find("'lift'"), std::string::npos) << response.status.message;
  ASSERT_EQ(response.pairs.size(), 2u);
  const std::size_t known = links(response.pairs[0]).count("base") ? 0 : 1;
  EXPECT_NEAR(response.pairs[known].distance, 0.3, kTolerance);
  EXPECT_TRUE(saysNothing(response.pairs[1 - known]));
  EXPECT_TRUE(saysNothing(response.minimum));
}

TEST_F(QueryPairs, RefusesTooMuch) {
  auto request = batch(QueryPairsRequest::PER_PAIR, moveTo({0.5, 0.0, 0.0}));
  request.a.assign(11, shape("ball"));  // max_batch is 10
  request.b.assign(11, shape("base"));
  const auto response = ask(request);
  EXPECT_EQ(response.status.code, QueryStatus::OVER_BUDGET);
  EXPECT_TRUE(response.pairs.empty());
}

}  // namespace proximity_server::node::queries_test
