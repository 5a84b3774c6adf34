#include "node/answers.h"
#include "node/asked_robot.h"
#include "node/services/queries.h"

#include <set>
#include <string>
#include <vector>

// Questions about states that the request names. Every expected number is read off gantry.urdf and followers.urdf.

namespace proximity_server::node::configuration_query_test {

sensor_msgs::JointState state(const std::vector<std::string>& names, const std::vector<double>& positions) {
  sensor_msgs::JointState result;
  result.name = names;
  result.position = positions;
  return result;
}

sensor_msgs::JointState gantryAt(const GantryPosition& position) {
  return state({"x_axis", "y_axis", "lift"}, {position.x, position.y, position.z});
}

QueryConfigurationRequest asking(const std::vector<sensor_msgs::JointState>& states, const ros::Time& stamp = {}) {
  QueryConfigurationRequest request;
  request.states = states;
  request.stamp = stamp;
  return request;
}

QueryConfigurationRequest between(const std::string& a, const std::string& b, const sensor_msgs::JointState& state) {
  QueryConfigurationRequest request = asking({state});
  request.a = {shape(a)};
  request.b = {shape(b)};
  return request;
}

using QueryConfiguration = AskedGantry;

TEST_F(QueryConfiguration, AnswersForAStateInWhichTheRobotIsNot) {
  moveTo({0.5, 0.0, 0.0});
  const auto response = ask(asking({gantryAt({0.9, 0.0, -1.0})}));
  ASSERT_TRUE(response.success) << response.status.message;
  EXPECT_EQ(response.header.frame_id, "base");
  ASSERT_EQ(response.states.size(), 1u);
  const StateProximity& answer = response.states[0];
  EXPECT_EQ(answer.status.code, QueryStatus::OK);
  EXPECT_NEAR(answer.minimum.distance, 0.7, kTolerance);
  EXPECT_EQ(links(answer.minimum), (std::set<std::string>{"base", "ball"}));
  ASSERT_EQ(answer.pairs.size(), 1u);
  EXPECT_EQ(answer.pairs_total, 2u);
}

TEST_F(QueryConfiguration, GivesThePointsOfThatState) {
  const auto response = ask(between("base", "ball", gantryAt({0.9, 0.0, 0.0})));
  ASSERT_TRUE(response.success) << response.status.message;
  const Proximity& pair = response.states[0].minimum;
  expectNear(pair.point_a, 0.1, 0.0, 0.0);
  expectNear(pair.point_b, 0.8, 0.0, 0.0);
  expectNear(pair.normal, 1.0, 0.0, 0.0);
  expectNear(pair.point_b_link, 0.0, 0.1, 0.0);  // the ball's frame is turned by a quarter about z
}

TEST_F(QueryConfiguration, AnswersManyStatesInTheirOrder) {
  const auto response = ask(asking({gantryAt({0.5, 0.0, 0.0}), gantryAt({0.15, 0.0, 0.0}), gantryAt({0.0, 0.6, 0.0})}));
  ASSERT_TRUE(response.success) << response.status.message;
  ASSERT_EQ(response.states.size(), 3u);
  EXPECT_NEAR(response.states[0].minimum.distance, 0.3, kTolerance);
  EXPECT_NEAR(response.states[1].minimum.distance, -0.05, kTolerance);
  EXPECT_EQ(response.states[1].minimum.state, Proximity::PENETRATING);
  EXPECT_NEAR(response.states[2].minimum.distance, 0.2, kTolerance);
}

TEST_F(QueryConfiguration, TakesTheOptionsOfQueryPairs) {
  auto request = asking({gantryAt({0.0, 0.6, 0.0})});
  request.mode = QueryConfigurationRequest::K_CLOSEST;
  request.k = 2;
  const auto closest = ask(request);
  ASSERT_EQ(closest.states.at(0).pairs.size(), 2u);
  EXPECT_NEAR(closest.states[0].pairs[1].distance, 0.4, kTolerance);

  request.mode = QueryConfigurationRequest::BELOW_THRESHOLD;
  request.threshold = 0.3;
  EXPECT_EQ(ask(request).states.at(0).pairs.size(), 1u);
  request.mode = QueryConfigurationRequest::FIRST;
  request.threshold = 0.15;
  EXPECT_TRUE(ask(request).states.at(0).pairs.empty());
  request.mode = QueryConfigurationRequest::PER_PAIR;
  request.threshold = 0.0;
  request.group = "lifted";
  EXPECT_EQ(ask(request).states.at(0).pairs.size(), 1u);
}

TEST_F(QueryConfiguration, GivesTheGradientInEachState) {
  auto request = asking({gantryAt({0.5, 0.0, -1.0}), gantryAt({0.0, 0.6, 0.0})});
  request.want_gradient = true;
  const auto response = ask(request);
  ASSERT_TRUE(response.success) << response.status.message;
  EXPECT_EQ(response.joint_names, (std::vector<std::string>{"lift", "x_axis", "y_axis"}));
  const double along_x[] = {0.0, 1.0, 0.0}, along_y[] = {0.0, 0.0, -1.0};
  ASSERT_EQ(response.states.at(0).minimum.gradient.size(), 3u);
  ASSERT_EQ(response.states.at(1).minimum.gradient.size(), 3u);
  for (int i = 0; i < 3; ++i) {
    EXPECT_NEAR(response.states[0].minimum.gradient[i], along_x[i], kTolerance) << i;
    EXPECT_NEAR(response.states[1].minimum.gradient[i], along_y[i], kTolerance) << i;
  }
}

TEST_F(QueryConfiguration, SaysInTheStateOfNowWhatQueryPairsSays) {
  QueryPairsRequest now;
  now.stamp = moveTo({0.3, 0.4, 0.1});
  now.mode = QueryPairsRequest::PER_PAIR;
  auto request = asking({state({}, {})}, now.stamp);
  request.mode = QueryConfigurationRequest::PER_PAIR;
  const auto expected = ask(now);
  const auto response = ask(request);
  ASSERT_TRUE(response.success) << response.status.message;
  EXPECT_EQ(response.header.stamp, now.stamp);
  ASSERT_EQ(response.states.at(0).pairs.size(), expected.pairs.size());
  for (std::size_t i = 0; i < expected.pairs.size(); ++i) {
    EXPECT_EQ(response.states[0].pairs[i].a.link, expected.pairs[i].a.link);
    EXPECT_EQ(response.states[0].pairs[i].distance, expected.pairs[i].distance);
  }
}

// ---- free motions

class FreeMotionQuery : public AskedGantry {
 protected:
  /// Asks in two states, in which base and ball are 0.3 and 0.7 m apart and the block is farther from the ball.
  static QueryConfigurationRequest asking() {
    auto request = configuration_query_test::asking({gantryAt({0.5, 0.0, -1.0}), gantryAt({0.9, 0.0, -1.0})});
    request.free_motion_distance = 0.15;
    request.want_free_motion = true;
    return request;
  }
};

TEST_F(FreeMotionQuery, TellsHowFarEachJointCanMoveAlone) {
  const auto response = ask(asking());
  ASSERT_TRUE(response.success) << response.status.message;
  EXPECT_EQ(response.joint_names, (std::vector<std::string>{"lift", "x_axis", "y_axis"}));
  ASSERT_EQ(response.free_motion.size(), 6u);
  // Pairs farther apart than 0.35 m share the bound of 0.2 m, also in the second state.
  const double expected[] = {0.2, 0.15, 0.15, 0.2, 0.2, 0.2};
  for (std::size_t i = 0; i < 6; ++i) {
    EXPECT_NEAR(response.free_motion[i], expected[i], kTolerance) << i;
    EXPECT_LE(response.free_motion[i], expected[i]) << i;
  }
  EXPECT_TRUE(response.free_scale.empty());
  EXPECT_NEAR(response.states.at(0).minimum.distance, 0.3, kTolerance);
}

TEST_F(FreeMotionQuery, TellsHowMuchOfAMotionIsFree) {
  auto request = asking();
  request.motion = state({"lift", "x_axis"}, {-0.05, -0.3});
  const auto response = ask(request);
  ASSERT_EQ(response.free_scale.size(), 2u) << response.status.message;
  EXPECT_NEAR(response.free_scale[0], 0.15 / 0.3, kTolerance);  // the lift moves neither base nor ball
  EXPECT_NEAR(response.free_scale[1], 0.2 / 0.35, kTolerance);
}

TEST_F(FreeMotionQuery, IsEmptyWhereItIsNotWanted) {
  auto request = asking();
  request.want_free_motion = false;
  const auto response = ask(request);
  EXPECT_TRUE(response.free_motion.empty());
  EXPECT_TRUE(response.joint_names.empty());
}

TEST_F(FreeMotionQuery, IsNoughtWhereAPoseIsMissing) {
  auto request = asking();
  request.states = {state({"x_axis"}, {0.5})};
  const auto response = ask(request);
  EXPECT_EQ(response.status.code, QueryStatus::TF_UNAVAILABLE);
  EXPECT_EQ(response.free_motion, std::vector<double>(3, 0.0));
}

// ---- joints that are not named

using MissingJoints = AskedGantry;

TEST_F(MissingJoints, StandAsInTf) {
  const ros::Time stamp = moveTo({0.0, 0.6, 0.0});
  const auto response = ask(asking({state({"lift"}, {-0.5}), state({"x_axis"}, {0.3})}, stamp));
  ASSERT_TRUE(response.success) << response.status.message;
  EXPECT_EQ(response.header.stamp, stamp);
  EXPECT_NEAR(response.states.at(0).minimum.distance, 0.2, kTolerance);  // to the high cube, now at z = 0
  EXPECT_NEAR(response.states.at(1).minimum.distance, std::hypot(0.2, 0.3) - 0.1, kTolerance);
}

TEST_F(MissingJoints, StandAtZeroWhereThatIsAsked) {
  moveTo({0.0, 0.6, 0.0});
  auto request = asking({state({"x_axis"}, {0.3})});
  request.missing_joints = QueryConfigurationRequest::ZERO;
  const auto response = ask(request);
  ASSERT_TRUE(response.success) << response.status.message;
  EXPECT_TRUE(response.header.stamp.isZero());
  EXPECT_NEAR(response.states.at(0).minimum.distance, 0.1, kTolerance);
}

// Nobody publishes a transform here and in the next test.
TEST_F(MissingJoints, MatterOnlyWhereTheAskedPairsNeedThem) {
  const auto response = ask(between("base", "ball", state({"x_axis", "y_axis"}, {0.5, 0.0})));
  ASSERT_TRUE(response.success) << response.status.message;
  EXPECT_TRUE(response.header.stamp.isZero());
  EXPECT_NEAR(response.states.at(0).minimum.distance, 0.3, kTolerance);
}

TEST_F(MissingJoints, WithoutTfLeaveTheCompleteStatesStanding) {
  const auto response = ask(asking({gantryAt({0.5, 0.0, 0.0}), state({"x_axis", "lift"}, {0.5, 0.0})}));
  expectRefusal(response, QueryStatus::TF_UNAVAILABLE, "state 1");
  EXPECT_NE(response.status.message.find("'y_axis'"), std::string::npos) << response.status.message;
  ASSERT_EQ(response.states.size(), 2u);
  EXPECT_EQ(response.states[0].status.code, QueryStatus::OK);
  EXPECT_NEAR(response.states[0].minimum.distance, 0.3, kTolerance);
  EXPECT_EQ(response.states[1].status.code, QueryStatus::TF_UNAVAILABLE);
  EXPECT_EQ(response.states[1].pairs_unknown, 2u);
  EXPECT_TRUE(saysNothing(response.states[1].minimum));
}

// ---- frames

class InTheFrameOfTheBall : public AskedGantry {
 protected:
  InTheFrameOfTheBall() : AskedGantry("ball") {}
};

TEST_F(InTheFrameOfTheBall, AnswersMoveWithTheState) {
  for (const double x : {0.5, 0.9}) {
    const auto response = ask(between("base", "ball", gantryAt({x, 0.0, 0.0})));
    ASSERT_TRUE(response.success) << response.status.message;
    EXPECT_EQ(response.header.frame_id, "ball");
    const Proximity& pair = response.states.at(0).minimum;
    expectNear(pair.point_b, 0.0, 0.1, 0.0);  // towards the base is +y in the turned frame
    expectNear(pair.point_a, 0.0, x - 0.1, 0.0);
    expectNear(pair.point_a_link, 0.1, 0.0, 0.0);
  }
}

class InTheWorld : public AskedGantry {
 protected:
  InTheWorld() : AskedGantry("world") {}
};

TEST_F(InTheWorld, AnswersNeedTheTransformOfTheRoot) {
  const auto request = between("base", "ball", gantryAt({0.5, 0.0, 0.0}));
  const auto without = ask(request);
  expectRefusal(without, QueryStatus::TF_UNAVAILABLE, "'world'");
  ASSERT_EQ(without.states.size(), 1u);
  EXPECT_TRUE(saysNothing(without.states[0].minimum));

  geometry_msgs::TransformStamped base = Gantry::slide({0.0, 0.0, 0.0});
  base.header.frame_id = "world";
  base.child_frame_id = "base";
  base.transform.translation.z = 2.0;
  const ros::Time stamp = gantry_.moveTo({base});
  const auto with = ask(request);
  ASSERT_TRUE(with.success) << with.status.message;
  EXPECT_EQ(with.header.frame_id, "world");
  EXPECT_EQ(with.header.stamp, stamp);
  expectNear(with.states.at(0).minimum.point_b, 0.4, 0.0, 2.0);
}

// ---- joints that a state cannot set

class Followers : public testing::Test {
 protected:
  QueryConfigurationResponse ask(QueryConfigurationRequest request) {
    request.ignore_filter = true;  // all are neighbours of the base
    return robot_.ask(request);
  }

  AskedRobot robot_{{robotText("followers.urdf"), ""}};
};

TEST_F(Followers, StandWhereTheirLeaderPutsThemWhateverTheStateSays) {
  auto request = between("base", "shadow", state({"follow", "lead"}, {7.0, 0.1}));
  const auto response = ask(request);
  ASSERT_TRUE(response.success) << response.status.message;
  EXPECT_NEAR(response.states.at(0).minimum.distance, 0.5, kTolerance);  // at y = 0.7

  request.states = {state({"follow"}, {7.0})};
  request.missing_joints = QueryConfigurationRequest::ZERO;
  EXPECT_NEAR(ask(request).states.at(0).minimum.distance, 0.3, kTolerance);  // at y = 0.5
}

TEST_F(Followers, WithoutAPositionOfTheirLeaderNeedTf) {
  const auto response = ask(between("base", "shadow", state({"follow"}, {7.0})));
  expectRefusal(response, QueryStatus::TF_UNAVAILABLE, "'follow'");
}

using FloatingJoint = Followers;

TEST_F(FloatingJoint, StandsAsInTfOrAtItsOrigin) {
  auto request = between("base", "drone", state({"lead"}, {0.5}));
  request.missing_joints = QueryConfigurationRequest::ZERO;
  EXPECT_NEAR(ask(request).states.at(0).minimum.distance, 2.8, kTolerance);

  geometry_msgs::TransformStamped drone = Gantry::post({0.0, 0.0, 1.0});
  drone.child_frame_id = "drone";
  request.missing_joints = QueryConfigurationRequest::FROM_TF;
  robot_.moveTo({drone});
  const auto response = ask(request);
  ASSERT_TRUE(response.success) << response.status.message;
  EXPECT_NEAR(response.states.at(0).minimum.distance, 0.8, kTolerance);
}

TEST_F(FloatingJoint, HasNotOnePosition) {
  expectRefusal(ask(asking({state({"flight"}, {0.0})})), QueryStatus::INVALID_ARGUMENT, "'flight'");
}

// ---- max_batch, which is 10; 2 pairs are checked

class MaxBatch : public AskedGantry {
 protected:
  void expectMostStates(QueryConfigurationRequest request, std::size_t most, const std::string& refusal) {
    request.states.assign(most, gantryAt({0.5, 0.0, 0.0}));
    const auto within = ask(request);
    EXPECT_TRUE(within.success) << within.status.message;
    EXPECT_EQ(within.states.size(), most);
    request.states.push_back(request.states.front());
    const auto beyond = ask(request);
    expectRefusal(beyond, QueryStatus::OVER_BUDGET, refusal);
    EXPECT_TRUE(beyond.states.empty());
  }
};

QueryConfigurationRequest inMode(std::uint8_t mode, std::uint32_t k = 0) {
  QueryConfigurationRequest request;
  request.mode = mode;
  request.k = k;
  return request;
}

TEST_F(MaxBatch, BoundsTheStatesWhereEachReturnsOnePair) {
  const std::string refusal = "states: 11 returned pairs (up to 1 in each of 11 states), max_batch is 10";
  expectMostStates(inMode(QueryConfigurationRequest::MINIMUM), 10, refusal);
  expectMostStates(inMode(QueryConfigurationRequest::FIRST), 10, refusal);
  expectMostStates(inMode(QueryConfigurationRequest::K_CLOSEST, 1), 10, refusal);
}

TEST_F(MaxBatch, BoundsAllPairsOfAllStatesWhereEachMayBeReturned) {
  const std::string refusal = "states: 12 returned pairs (up to 2 in each of 6 states), max_batch is 10";
  expectMostStates(inMode(QueryConfigurationRequest::PER_PAIR), 5, refusal);
  expectMostStates(inMode(QueryConfigurationRequest::BELOW_THRESHOLD), 5, refusal);
  expectMostStates(inMode(QueryConfigurationRequest::K_CLOSEST, 4'000'000'000), 5, refusal);
}

TEST_F(MaxBatch, BoundsThePairsOfEachStateInEveryMode) {
  QueryConfigurationRequest request = asking({gantryAt({0.5, 0.0, 0.0})});
  request.a.assign(11, shape("base"));
  request.b.assign(11, shape("ball"));
  expectRefusal(ask(request), QueryStatus::OVER_BUDGET, "a: 11 entries, max_batch is 10");
}

}  // namespace proximity_server::node::configuration_query_test
