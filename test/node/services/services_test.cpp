#include <proximity_server/Clearance.h>
#include <proximity_server/MinimumDistance.h>
#include <proximity_server/ModelInfo.h>
#include <proximity_server/PenetrationDepth.h>
#include <proximity_server/QueryPairs.h>
#include <proximity_server/SeparationAxis.h>
#include "node/answers.h"
#include "node/gantry.h"

#include <std_srvs/Trigger.h>

#include <array>
#include <limits>
#include <thread>

// Every expected number is read off gantry.urdf.

namespace proximity_server::node::services_test {

const std::string kNode = "/proximity_server/";

Gantry& gantry() { return connectedGantry(1); }

MinimumDistanceResponse ask(const MinimumDistanceRequest& request) {
  return call<MinimumDistanceResponse>(kNode + "minimum_distance", request);
}
SeparationAxisResponse ask(const SeparationAxisRequest& request) {
  return call<SeparationAxisResponse>(kNode + "separation_axis", request);
}
PenetrationDepthResponse ask(const PenetrationDepthRequest& request) {
  return call<PenetrationDepthResponse>(kNode + "penetration_depth", request);
}
QueryPairsResponse ask(const QueryPairsRequest& request) {
  return call<QueryPairsResponse>(kNode + "query_pairs", request);
}

void expectFailure(const MinimumDistanceResponse& response, int code, const std::string& named) {
  expectRefusal(response, code, named);
  EXPECT_TRUE(saysNothing(response.pair));
}

// ---- minimum_distance

TEST(MinimumDistance, OfBallAndBaseIsThatOfThePaper) {
  const ros::Time stamp = gantry().moveTo({0.5, 0.0, 0.0});
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

TEST(MinimumDistance, GivesThePointsInTheReferenceFrameAndInTheLinks) {
  const ros::Time stamp = gantry().moveTo({0.5, 0.0, 0.0});
  const auto response = ask(between<MinimumDistanceRequest>("base", "ball", stamp));
  ASSERT_TRUE(response.pair.points_valid);
  expectNear(response.pair.point_a, 0.1, 0.0, 0.0);
  expectNear(response.pair.point_b, 0.4, 0.0, 0.0);
  expectNear(response.pair.normal, 1.0, 0.0, 0.0);
  expectNear(response.pair.point_a_link, 0.1, 0.0, 0.0);
  expectNear(response.pair.point_b_link, 0.0, 0.1, 0.0);  // the ball's frame is turned by a quarter about z
}

TEST(MinimumDistance, KeepsTheOrderOfTheRequest) {
  const ros::Time stamp = gantry().moveTo({0.5, 0.0, 0.0});
  const auto response = ask(between<MinimumDistanceRequest>("ball", "base", stamp));
  EXPECT_EQ(response.pair.a.link, "ball");
  EXPECT_EQ(response.pair.b.link, "base");
  expectNear(response.pair.point_a, 0.4, 0.0, 0.0);
  expectNear(response.pair.normal, -1.0, 0.0, 0.0);
}

TEST(MinimumDistance, WithoutNamesIsThatOfTheClosestPair) {
  MinimumDistanceRequest request;
  request.stamp = gantry().moveTo({0.0, 0.6, 0.0});
  const auto response = ask(request);
  EXPECT_NEAR(response.pair.distance, 0.2, kTolerance);
  EXPECT_EQ(links(response.pair), (std::set<std::string>{"ball", "block"}));
}

TEST(MinimumDistance, OfOneNamePutsThatLinkFirst) {
  MinimumDistanceRequest request;
  request.a = shape("block");
  request.stamp = gantry().moveTo({0.0, 0.6, 0.0});
  const auto response = ask(request);
  EXPECT_NEAR(response.pair.distance, 0.2, kTolerance);
  EXPECT_EQ(response.pair.a.link, "block");
  EXPECT_EQ(response.pair.b.link, "ball");
  expectNear(response.pair.normal, 0.0, -1.0, 0.0);
}

TEST(MinimumDistance, NamesTheClosestShapeOfALink) {
  const ros::Time stamp = gantry().moveTo({0.5, 1.0, -0.5});
  const auto response = ask(between<MinimumDistanceRequest>("ball", "block", stamp));
  EXPECT_EQ(response.pair.b.index, 2u);
  EXPECT_EQ(response.pair.b.name, "high");
  EXPECT_NEAR(response.pair.distance, 0.3, kTolerance);
}

TEST(MinimumDistance, OfASingleShapeIgnoresTheOthersOfItsLink) {
  // From (0.5, 1, 0) to the high cube: 0.4 along x and 0.4 along z.
  auto request = between<MinimumDistanceRequest>("ball", "block", gantry().moveTo({0.5, 1.0, 0.0}));
  const double paper = std::hypot(0.4, 0.4) - 0.1;
  EXPECT_NEAR(ask(request).pair.distance, 0.3, kTolerance);
  request.b = shape("block", 2);
  EXPECT_NEAR(ask(request).pair.distance, paper, kTolerance);
  request.b = shape("block", 0, "high");
  EXPECT_NEAR(ask(request).pair.distance, paper, kTolerance);
}

TEST(MinimumDistance, OfTwoShapesOfOneLinkNeverChanges) {
  MinimumDistanceRequest request;
  request.a = shape("block", 1);
  request.b = shape("block", 2);
  request.stamp = gantry().moveTo({0.5, 0.0, 0.2});
  expectFailure(ask(request), QueryStatus::PAIR_EXCLUDED, "ignore_filter");
  request.ignore_filter = true;
  EXPECT_NEAR(ask(request).pair.distance, 0.3, kTolerance);
}

TEST(MinimumDistance, BeyondTheThresholdProvesOnlyThat) {
  auto request = between<MinimumDistanceRequest>("base", "ball", gantry().moveTo({0.5, 0.0, 0.0}));
  request.threshold = 0.1;
  const auto response = ask(request);
  EXPECT_TRUE(response.success);
  EXPECT_EQ(response.pair.state, Proximity::BEYOND_THRESHOLD);
  EXPECT_GT(response.pair.lower_bound, 0.1);
  EXPECT_LE(response.pair.lower_bound, 0.3 + 1e-15);
  EXPECT_EQ(response.pair.distance, response.pair.lower_bound);
}

TEST(MinimumDistance, OfNeighboursNeedsIgnoreFilter) {
  auto request = between<MinimumDistanceRequest>("base", "block", gantry().moveTo({0.5, 0.0, 0.0}));
  expectFailure(ask(request), QueryStatus::PAIR_EXCLUDED, "adjacent");
  request.ignore_filter = true;
  const auto response = ask(request);
  ASSERT_TRUE(response.success) << response.status.message;
  EXPECT_NEAR(response.pair.distance, 0.8, kTolerance);
  EXPECT_FALSE(response.pair.unique) << "the faces are parallel";
}

TEST(MinimumDistance, InOverlapIsMinusTheDepth) {
  const ros::Time stamp = gantry().moveTo({0.15, 0.0, 0.0});
  const auto response = ask(between<MinimumDistanceRequest>("base", "ball", stamp));
  EXPECT_EQ(response.pair.state, Proximity::PENETRATING);
  EXPECT_NEAR(response.pair.distance, -0.05, kTolerance);
  expectNear(response.pair.point_a, 0.1, 0.0, 0.0);
  expectNear(response.pair.point_b, 0.05, 0.0, 0.0);
  expectNear(response.pair.normal, 1.0, 0.0, 0.0);
}

// ---- bad requests

TEST(BadRequest, UnknownLinkIsAnsweredWithTheNearestName) {
  const ros::Time stamp = gantry().moveTo({0.5, 0.0, 0.0});
  const auto response = ask(between<MinimumDistanceRequest>("base", "bal", stamp));
  expectFailure(response, QueryStatus::UNKNOWN_LINK, "'bal'");
  EXPECT_NE(response.status.message.find("'ball'"), std::string::npos) << response.status.message;
}

TEST(BadRequest, LinkWithoutGeometryIsNamed) {
  const ros::Time stamp = gantry().moveTo({0.5, 0.0, 0.0});
  expectFailure(ask(between<MinimumDistanceRequest>("slide", "ball", stamp)), QueryStatus::NO_COLLISION_GEOMETRY,
                "'slide'");
}

TEST(BadRequest, ALinkWithItselfIsRefused) {
  const ros::Time stamp = gantry().moveTo({0.5, 0.0, 0.0});
  expectFailure(ask(between<MinimumDistanceRequest>("ball", "ball", stamp)), QueryStatus::INVALID_ARGUMENT, "'ball'");
}

TEST(BadRequest, ShapeThatDoesNotExistIsNamed) {
  auto request = between<MinimumDistanceRequest>("ball", "block", gantry().moveTo({0.5, 0.0, 0.0}));
  request.b = shape("block", 3);
  expectFailure(ask(request), QueryStatus::INVALID_ARGUMENT, "3");
  request.b = shape("block", 0, "hihg");
  expectFailure(ask(request), QueryStatus::INVALID_ARGUMENT, "'high'");
}

TEST(BadRequest, ThresholdThatIsNotFiniteIsNamed) {
  auto request = between<MinimumDistanceRequest>("base", "ball", gantry().moveTo({0.5, 0.0, 0.0}));
  request.threshold = std::numeric_limits<double>::quiet_NaN();
  expectFailure(ask(request), QueryStatus::INVALID_ARGUMENT, "threshold");
}

TEST(BadRequest, DoesNotDisturbTheMonitor) {
  Inbox<Clearance> clearance(ros::NodeHandle(), kNode + "clearance");
  const ros::Time stamp = gantry().moveTo({0.5, 0.0, 0.0});
  ASSERT_TRUE(clearance.next([&](const Clearance& message) { return message.header.stamp == stamp; }));
  ask(between<MinimumDistanceRequest>("no such link", "ball", stamp));
  clearance.clear();
  const auto after = clearance.next();
  ASSERT_TRUE(after);
  EXPECT_EQ(after->status.code, QueryStatus::OK);
  EXPECT_NEAR(after->minimum.distance, 0.3, kTolerance);
}

// ---- time

TEST(Stamp, ZeroMeansTheLatestTimeThatAllJointsShare) {
  const ros::Time common = gantry().moveTo({0.5, 0.0, 0.0});
  const ros::Time later = common + ros::Duration(0.1);
  gantry().publish(Gantry::slide({0.9, 0.0, 0.0}), later);
  gantry().publish(Gantry::ball({0.9, 0.0, 0.0}), later);

  // The block needs the lift, whose latest transform is that of `common`; waiting for `later` proves that it is there.
  ASSERT_TRUE(ask(between<MinimumDistanceRequest>("base", "ball", later)).success);
  const auto response = ask(between<MinimumDistanceRequest>("ball", "block", ros::Time()));
  EXPECT_EQ(response.header.stamp, common);
  EXPECT_NEAR(response.pair.distance, std::hypot(0.4, 0.9) - 0.1, kTolerance);
}

TEST(Stamp, OfThePastGivesThePoseOfThen) {
  const ros::Time then = gantry().moveTo({0.5, 0.0, 0.0});
  const ros::Time now = gantry().moveTo({0.7, 0.0, 0.0});
  EXPECT_NEAR(ask(between<MinimumDistanceRequest>("base", "ball", now)).pair.distance, 0.5, kTolerance);
  EXPECT_NEAR(ask(between<MinimumDistanceRequest>("base", "ball", then)).pair.distance, 0.3, kTolerance);
}

TEST(Stamp, OutsideOfWhatTfHoldsFailsAndNamesAJoint) {
  const ros::Time stamp = gantry().moveTo({0.5, 0.0, 0.0});
  for (const double offset : {-500.0, 500.0}) {
    const auto response = ask(between<MinimumDistanceRequest>("base", "ball", stamp + ros::Duration(offset)));
    expectFailure(response, QueryStatus::TF_EXTRAPOLATION, "_axis'");
  }
}

TEST(Stamp, OfAnotherEraFailsLikeAnyOther) {
  gantry().moveTo({0.5, 0.0, 0.0});
  for (const ros::Time& stamp : {ros::TIME_MIN, ros::TIME_MAX}) {
    expectFailure(ask(between<MinimumDistanceRequest>("base", "ball", stamp)), QueryStatus::TF_EXTRAPOLATION, "_axis'");
  }
}

TEST(Stamp, AFrameThatIsBrokenIsRefusedAndItsJointNamed) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double infinity = std::numeric_limits<double>::infinity();
  std::array<geometry_msgs::TransformStamped, 4> broken;
  broken.fill(Gantry::ball({0.5, 0.0, 0.0}));
  broken[0].transform.rotation.z = nan;
  broken[1].transform.rotation.w = 2.0;
  broken[2].transform.translation.x = nan;
  broken[3].transform.translation.x = infinity;
  ros::Time stamp = gantry().moveTo({0.5, 0.0, 0.0});
  for (const auto& transform : broken) {
    stamp += ros::Duration(0.01);
    gantry().publish(Gantry::slide({0.5, 0.0, 0.0}), stamp);
    gantry().publish(transform, stamp);
    const auto response = ask(between<MinimumDistanceRequest>("base", "ball", stamp));
    EXPECT_FALSE(response.success);
    EXPECT_NE(response.status.message.find("'y_axis'"), std::string::npos) << response.status.message;
    EXPECT_TRUE(saysNothing(response.pair));
  }
  EXPECT_TRUE(ask(between<MinimumDistanceRequest>("base", "ball", gantry().moveTo({0.5, 0.0, 0.0}))).success);
}

// ---- separation_axis

TEST(SeparationAxis, IsThatOfTheGap) {
  const auto response = ask(between<SeparationAxisRequest>("base", "ball", gantry().moveTo({0.5, 0.0, 0.0})));
  ASSERT_TRUE(response.success) << response.status.message;
  EXPECT_TRUE(response.separated);
  expectNear(response.axis, 1.0, 0.0, 0.0);
  EXPECT_NEAR(response.gap, 0.3, kTolerance);
  EXPECT_GT(response.plane_offset, 0.1);  // between the faces at 0.1 and 0.4
  EXPECT_LT(response.plane_offset, 0.4);
}

TEST(SeparationAxis, DeniesAGapWiderThanItIs) {
  auto request = between<SeparationAxisRequest>("base", "ball", gantry().moveTo({0.5, 0.0, 0.0}));
  request.margin = 0.31;
  const auto response = ask(request);
  EXPECT_TRUE(response.success);
  EXPECT_FALSE(response.separated);
  request.margin = 0.29;
  EXPECT_TRUE(ask(request).separated);
}

TEST(SeparationAxis, DoesNotExistInOverlap) {
  const auto response = ask(between<SeparationAxisRequest>("base", "ball", gantry().moveTo({0.15, 0.0, 0.0})));
  EXPECT_TRUE(response.success);
  EXPECT_FALSE(response.separated);
  EXPECT_TRUE(isNaN(response.axis));
  EXPECT_TRUE(std::isnan(response.gap) && std::isnan(response.plane_offset));
}

TEST(SeparationAxis, RefusesANegativeMargin) {
  auto request = between<SeparationAxisRequest>("base", "ball", gantry().moveTo({0.5, 0.0, 0.0}));
  request.margin = -0.1;
  EXPECT_EQ(ask(request).status.code, QueryStatus::INVALID_ARGUMENT);
}

// ---- penetration_depth

TEST(PenetrationDepth, IsTheShortestWayOut) {
  // The centre of the ball is 0.05 under the face at x = 0.1, so the ball must move by 0.05 + 0.1.
  const auto response = ask(between<PenetrationDepthRequest>("base", "ball", gantry().moveTo({0.05, 0.0, 0.0})));
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

TEST(PenetrationDepth, IsZeroApart) {
  const auto response = ask(between<PenetrationDepthRequest>("base", "ball", gantry().moveTo({0.5, 0.0, 0.0})));
  EXPECT_TRUE(response.success);
  EXPECT_FALSE(response.penetrating);
  EXPECT_EQ(response.depth, 0.0);
  EXPECT_EQ(response.depth_upper_bound, 0.0);
  EXPECT_TRUE(isNaN(response.direction));
}

TEST(PenetrationDepth, UpToTheThresholdIsOnlyBounded) {
  auto request = between<PenetrationDepthRequest>("base", "ball", gantry().moveTo({0.15, 0.0, 0.0}));  // 0.05 deep
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

TEST(PenetrationDepth, WithoutNamesIsThatOfTheDeepestPair) {
  PenetrationDepthRequest request;
  request.stamp = gantry().moveTo({0.0, 0.85, 0.0});  // 0.05 deep in the block's low cube
  const auto response = ask(request);
  EXPECT_NEAR(response.depth, 0.05, kTolerance);
  EXPECT_EQ(links(response.pair), (std::set<std::string>{"ball", "block"}));
}

// ---- query_pairs

QueryPairsRequest batch(std::uint8_t mode, const ros::Time& stamp) {
  QueryPairsRequest request;
  request.mode = mode;
  request.stamp = stamp;
  return request;
}

TEST(QueryPairs, AsksForTheClosestOfAllByDefault) {
  QueryPairsRequest request;
  request.stamp = gantry().moveTo({0.5, 0.0, 0.0});
  const auto response = ask(request);
  ASSERT_TRUE(response.success) << response.status.message;
  ASSERT_EQ(response.pairs.size(), 1u);
  EXPECT_NEAR(response.pairs[0].distance, 0.3, kTolerance);
  EXPECT_NEAR(response.minimum.distance, 0.3, kTolerance);
  EXPECT_EQ(response.pairs_total, 2u);
  EXPECT_EQ(response.pairs_total, response.pairs_unknown + response.pairs_at_rest + response.pairs_by_motion +
                                      response.pairs_by_bounds + response.pairs_computed);
}

TEST(QueryPairs, PerPairKeepsTheOrderOfTheRequest) {
  auto request = batch(QueryPairsRequest::PER_PAIR, gantry().moveTo({0.0, 0.6, 0.0}));
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

TEST(QueryPairs, ClosestComeSortedAndNoMoreThanAsked) {
  auto request = batch(QueryPairsRequest::K_CLOSEST, gantry().moveTo({0.0, 0.6, 0.0}));
  request.k = 5;
  const auto both = ask(request);
  ASSERT_EQ(both.pairs.size(), 2u);
  EXPECT_NEAR(both.pairs[0].distance, 0.2, kTolerance);
  EXPECT_NEAR(both.pairs[1].distance, 0.4, kTolerance);
  request.k = 1;
  EXPECT_EQ(ask(request).pairs.size(), 1u);
}

TEST(QueryPairs, BelowThresholdLeavesTheOthersOut) {
  auto request = batch(QueryPairsRequest::BELOW_THRESHOLD, gantry().moveTo({0.0, 0.6, 0.0}));
  request.threshold = 0.3;
  const auto response = ask(request);
  ASSERT_EQ(response.pairs.size(), 1u);
  EXPECT_NEAR(response.pairs[0].distance, 0.2, kTolerance);
  request.threshold = 0.0;
  const auto contacts = ask(request);
  EXPECT_TRUE(contacts.success);
  EXPECT_TRUE(contacts.pairs.empty());
}

TEST(QueryPairs, FirstFindsOneThatIsTooCloseOrNone) {
  auto request = batch(QueryPairsRequest::FIRST, gantry().moveTo({0.0, 0.6, 0.0}));
  request.threshold = 0.25;
  const auto found = ask(request);
  ASSERT_EQ(found.pairs.size(), 1u);
  EXPECT_LE(found.pairs[0].upper_bound, 0.25);
  request.threshold = 0.15;
  EXPECT_TRUE(ask(request).pairs.empty());
}

TEST(QueryPairs, OfAGroupAreThoseItMoves) {
  auto request = batch(QueryPairsRequest::PER_PAIR, gantry().moveTo({0.5, 0.0, 0.0}));
  request.group = "lifted";
  const auto response = ask(request);
  ASSERT_TRUE(response.success) << response.status.message;
  ASSERT_EQ(response.pairs.size(), 1u);
  EXPECT_EQ(links(response.pairs[0]), (std::set<std::string>{"ball", "block"}));
  request.group = "liftd";
  EXPECT_EQ(ask(request).status.code, QueryStatus::INVALID_ARGUMENT);
}

TEST(QueryPairs, MayLeaveThePenetrationOut) {
  auto request = batch(QueryPairsRequest::PER_PAIR, gantry().moveTo({0.15, 0.0, 0.0}));
  request.a = {shape("base")};
  request.b = {shape("ball")};
  request.skip_penetration = true;
  const auto response = ask(request);
  ASSERT_TRUE(response.success) << response.status.message;
  EXPECT_EQ(response.pairs[0].state, Proximity::PENETRATING);
  EXPECT_LE(response.pairs[0].upper_bound, 0.0);
}

TEST(QueryPairs, UnknownPairsLeaveTheKnownOnesStanding) {
  const ros::Time stamp = gantry().moveTo({0.5, 0.0, 0.0}) + ros::Duration(0.01);
  gantry().publish(Gantry::slide({0.5, 0.0, 0.0}), stamp);
  gantry().publish(Gantry::ball({0.5, 0.0, 0.0}), stamp);
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

TEST(QueryPairs, RefusesListsOfDifferentLengthsAndTooMuch) {
  auto request = batch(QueryPairsRequest::PER_PAIR, gantry().moveTo({0.5, 0.0, 0.0}));
  request.a = {shape("ball"), shape("ball")};
  request.b = {shape("base")};
  EXPECT_EQ(ask(request).status.code, QueryStatus::INVALID_ARGUMENT);
  request.a.assign(11, shape("ball"));  // max_batch is 10
  request.b.assign(11, shape("base"));
  const auto response = ask(request);
  EXPECT_EQ(response.status.code, QueryStatus::OVER_BUDGET);
  EXPECT_TRUE(response.pairs.empty());
}

// ---- several clients

// Regression: of two requests at the same moment the one that had read the clock first could be overtaken, took that
// for a jump back of the clock, and all transforms were forgotten.
TEST(Clients, AtOnceEachGetTheirOwnAnswer) {
  const std::array<ros::Time, 2> stamps = {gantry().moveTo({0.5, 0.0, 0.0}), gantry().moveTo({0.7, 0.0, 0.0})};
  const std::array<double, 2> distances = {0.3, 0.5};
  const auto client = [&](std::size_t i) {
    for (int n = 0; n < 1000; ++n) {
      const auto response = ask(between<MinimumDistanceRequest>("base", "ball", stamps[i]));
      EXPECT_TRUE(response.success) << response.status.message;
      EXPECT_NEAR(response.pair.distance, distances[i], kTolerance);
    }
  };
  std::thread first(client, 0), second(client, 1);
  first.join();
  second.join();
}

// ---- reload

// reload_under_load_test replaces the model while clients ask.

/// Another robot_description as long as it lives.
class OtherRobot {
 public:
  explicit OtherRobot(const std::string& urdf) {
    ros::param::get("/robot_description", before_);
    ros::param::set("/robot_description", urdf);
  }
  ~OtherRobot() {
    ros::param::set("/robot_description", before_);
    EXPECT_TRUE(reload().success);
  }

  static std_srvs::TriggerResponse reload() {
    return call<std_srvs::TriggerResponse>(kNode + "reload", std_srvs::TriggerRequest());
  }

 private:
  std::string before_;
};

std::string gantryWith(const std::string& radius) {
  std::string urdf;
  ros::param::get("/robot_description", urdf);
  const std::string old = "radius=\"0.1\"";
  urdf.replace(urdf.find(old), old.size(), "radius=\"" + radius + "\"");
  return urdf;
}

/// The services answer so at once, and the monitor after two cycles, with the ball at (0.5, 0, 0).
void expectDistance(double distance) {
  Inbox<Clearance> inbox(ros::NodeHandle(), kNode + "clearance");
  ASSERT_TRUE(inbox.next());
  inbox.clear();
  const ros::Time stamp = gantry().moveTo({0.5, 0.0, 0.0});
  EXPECT_NEAR(ask(between<MinimumDistanceRequest>("base", "ball", stamp)).pair.distance, distance, kTolerance);
  ASSERT_TRUE(inbox.next() && inbox.next());
  const auto message = inbox.next();
  ASSERT_TRUE(message);
  EXPECT_NEAR(message->minimum.distance, distance, kTolerance);
}

TEST(Reload, TakesTheNewModel) {
  const OtherRobot robot(gantryWith("0.15"));
  const auto reloaded = OtherRobot::reload();
  ASSERT_TRUE(reloaded.success) << reloaded.message;
  expectDistance(0.25);
}

TEST(Reload, OfABrokenModelKeepsTheOldOneAndSaysWhy) {
  const OtherRobot robot(gantryWith("-1"));
  const auto reloaded = OtherRobot::reload();
  EXPECT_FALSE(reloaded.success);
  EXPECT_NE(reloaded.message.find("ball"), std::string::npos) << reloaded.message;
  expectDistance(0.3);
}

TEST(Reload, AnnouncesTheModelToThoseWhoComeLater) {
  Inbox<ModelInfo> inbox(ros::NodeHandle(), kNode + "model_info");
  const auto info = inbox.next();
  ASSERT_TRUE(info);
  EXPECT_EQ(info->robot, "gantry");
  EXPECT_EQ(info->header.frame_id, "base");
  EXPECT_EQ(info->links.size(), 5u);
  EXPECT_EQ(info->pairs.size(), 3u);
  EXPECT_EQ(info->pairs_checked, 2u);
  for (const PairInfo& pair : info->pairs) {
    const bool neighbours = pair.link_a != "ball" && pair.link_b != "ball";
    EXPECT_EQ(pair.checked, !neighbours) << pair.link_a << " " << pair.link_b << ": " << pair.reason;
  }
}

}  // namespace proximity_server::node::services_test
