// The topics and services of the node for controllers.
#include <proximity_server/Clearance.h>
#include <proximity_server/ConstraintRows.h>
#include <proximity_server/QueryConfiguration.h>
#include <proximity_server/QueryPairs.h>
#include "node/answers.h"
#include "node/gantry.h"
#include "node/joint_states.h"
#include "node/settings.h"

#include <std_msgs/Float64.h>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

// Every expected number is read off gantry.urdf: with the ball at (x, y, 0) the columns are lift, x_axis and y_axis.

namespace proximity_server::node::control_test {

const std::string kNode = "/proximity_server/";

void expectNear(const std::vector<double>& row, const std::vector<double>& expected) {
  ASSERT_EQ(row.size(), expected.size());
  for (std::size_t i = 0; i < row.size(); ++i) EXPECT_NEAR(row[i], expected[i], kTolerance) << i;
}

template <class Value>
void set(const std::string& name, Value value) {
  node::set(kNode, name, value);
}

class ControlTopics : public testing::Test {
 protected:
  static Gantry& gantry() { return connectedGantry(1); }
  void TearDown() override { gantry().release(); }

  const std::vector<std::string> columns_{"lift", "x_axis", "y_axis"};
};

// ---- gradients

TEST_F(ControlTopics, GivesTheGradientsWhileTheyAreAsked) {
  gantry().hold({0.5, 0.0, 0.0});
  set("gradients", true);
  Inbox<Clearance> inbox(ros::NodeHandle(), kNode + "clearance");
  const auto with = inbox.next([](const Clearance& message) {
    return !message.joint_names.empty() && std::abs(message.minimum.distance - 0.3) < kTolerance;
  });
  ASSERT_TRUE(with);
  EXPECT_EQ(with->joint_names, columns_);
  expectNear(with->joint_positions, {0.0, 0.5, 0.0});
  expectNear(with->minimum.gradient, {0.0, 1.0, 0.0});
  expectNear(with->self_minimum.gradient, {0.0, 1.0, 0.0});
  ASSERT_EQ(with->below_threshold.size(), 1u);
  expectNear(with->below_threshold[0].gradient, {0.0, 1.0, 0.0});

  set("gradients", false);
  const auto without = inbox.next([](const Clearance& message) { return message.joint_names.empty(); });
  ASSERT_TRUE(without);
  EXPECT_TRUE(without->minimum.gradient.empty());
  EXPECT_TRUE(without->joint_positions.empty());
}

TEST_F(ControlTopics, LeavesGradientsOutOfAnswersThatAreNotAskedForThem) {
  gantry().moveTo({0.5, 0.0, 0.0});
  const auto response = call<QueryPairsResponse>(kNode + "query_pairs", QueryPairsRequest());
  ASSERT_TRUE(response.success) << response.status.message;
  EXPECT_TRUE(response.joint_names.empty());
  EXPECT_TRUE(response.minimum.gradient.empty());
}

TEST_F(ControlTopics, GivesTheGradientsOfOtherStates) {
  QueryConfigurationRequest request;
  request.want_gradient = true;
  for (const double x : {0.5, -0.5}) {
    sensor_msgs::JointState state;
    state.name = columns_;
    state.position = {0.0, x, 0.0};
    request.states.push_back(state);
  }
  const auto response = call<QueryConfigurationResponse>(kNode + "query_configuration", request);
  ASSERT_TRUE(response.success) << response.status.message;
  EXPECT_EQ(response.joint_names, columns_);
  expectNear(response.states.at(0).minimum.gradient, {0.0, 1.0, 0.0});
  expectNear(response.states.at(1).minimum.gradient, {0.0, -1.0, 0.0});
  expectNear(response.states.at(1).pairs.at(0).gradient, {0.0, -1.0, 0.0});
}

// A bound is no point: there is nothing to take the derivative of.
TEST_F(ControlTopics, LeavesTheGradientOfAPairBeyondTheThresholdEmpty) {
  gantry().moveTo({0.9, 0.0, 0.0});
  QueryPairsRequest request;
  request.a = {shape("base")};
  request.b = {shape("ball")};
  request.mode = QueryPairsRequest::PER_PAIR;
  request.threshold = 0.1;
  request.want_gradient = true;
  const auto response = call<QueryPairsResponse>(kNode + "query_pairs", request);
  ASSERT_TRUE(response.success) << response.status.message;
  EXPECT_EQ(response.pairs.at(0).state, Proximity::BEYOND_THRESHOLD);
  EXPECT_TRUE(response.pairs.at(0).gradient.empty());
  EXPECT_EQ(response.joint_names, columns_);
}

// ---- constraints

TEST_F(ControlTopics, PublishesTheRowsOfAVelocityDamper) {
  gantry().hold({0.5, 0.0, 0.0});  // 0.3 m; the influence distance is 0.4, the gain 0.5
  Inbox<ConstraintRows> inbox(ros::NodeHandle(), kNode + "constraints");
  const auto rows = inbox.next([](const ConstraintRows& message) {
    return !message.distances.empty() && std::abs(message.distances[0] - 0.3) < kTolerance;
  });
  ASSERT_TRUE(rows);
  EXPECT_EQ(rows->status.code, QueryStatus::OK) << rows->status.message;
  EXPECT_EQ(rows->header.frame_id, "base");
  EXPECT_EQ(rows->joint_names, columns_);
  expectNear(rows->joint_positions, {0.0, 0.5, 0.0});
  ASSERT_EQ(rows->lower_bounds.size(), 8u);
  ASSERT_EQ(rows->matrix.size(), 24u);
  expectNear({rows->matrix.begin(), rows->matrix.begin() + 3}, {0.0, 1.0, 0.0});
  EXPECT_NEAR(rows->lower_bounds[0], -0.5 * 0.28 / 0.38, kTolerance);
  EXPECT_EQ((std::set<std::string>{rows->a[0].link, rows->b[0].link}), (std::set<std::string>{"base", "ball"}));
  for (std::size_t row = 1; row < 8; ++row)
    EXPECT_EQ(rows->lower_bounds[row], -std::numeric_limits<double>::infinity());
}

TEST_F(ControlTopics, ChangesTheRowsWithTheParameters) {
  gantry().hold({0.5, 0.0, 0.0});
  Inbox<ConstraintRows> inbox(ros::NodeHandle(), kNode + "constraints");
  const auto with = [&](std::size_t rows) {
    return inbox.next([&](const ConstraintRows& message) { return message.lower_bounds.size() == rows; });
  };
  ASSERT_TRUE(with(8));
  set("max_constraints", 2);
  ASSERT_TRUE(with(2));
  set("max_constraints", 8);
  set("damping_gain", 1.0);
  EXPECT_TRUE(inbox.next([](const ConstraintRows& message) {
    return message.lower_bounds.size() == 8 && std::abs(message.lower_bounds[0] + 0.28 / 0.38) < kTolerance;
  }));
  set("damping_gain", 0.5);
}

// Regression: velocities were asked for with the first subscriber only, so that it got 0 for some cycles.
TEST_F(ControlTopics, KnowTheVelocityScaleFromTheFirstMessageOfEachSubscriber) {
  gantry().hold({0.9, 0.0, 0.0});
  JointStates joint_states;
  joint_states.hold(slidingAt(0.1));
  int cycles = 0;
  Inbox<Clearance> inbox(ros::NodeHandle(), kNode + "clearance");
  ASSERT_TRUE(inbox.next([&](const Clearance&) { return ++cycles > 20; }));  // the node hears joint_states meanwhile
  for (int i = 0; i < 6; ++i) {
    Inbox<std_msgs::Float64> scales(ros::NodeHandle(), kNode + "collision_velocity_scale");
    const auto first = scales.next();
    ASSERT_TRUE(first) << i;
    EXPECT_EQ(first->data, 1.0) << i;
  }
}

// ---- the velocity scale: the age of the poses is part of the latency, so that the numbers are bounds only

class VelocityScaleTopic : public ControlTopics {
 protected:
  std::optional<double> next(const std::function<bool(double)>& accept) {
    const auto message = inbox_.next([&](const std_msgs::Float64& candidate) { return accept(candidate.data); });
    return message ? std::optional<double>(message->data) : std::nullopt;
  }

  Inbox<std_msgs::Float64> inbox_{ros::NodeHandle(), kNode + "collision_velocity_scale"};
  JointStates joint_states_;
};

TEST_F(VelocityScaleTopic, IsZeroBeforeAnybodyTellsTheVelocities) {
  gantry().hold({0.5, 0.0, 0.0});
  EXPECT_TRUE(next([](double scale) { return scale == 0.0; }));
}

// 0.28 m at 1 m/s: the latency is at least 0.1 s, and the brakes take 0.25 s^2 m.
TEST_F(VelocityScaleTopic, SlowsTheApproachButNotTheRetreat) {
  gantry().hold({0.5, 0.0, 0.0});
  joint_states_.hold(slidingAt(-1.0));
  const double without_age = (-0.1 + std::sqrt(0.01 + 0.28)) / 0.5;
  const auto slowed = next([](double scale) { return scale > 0.5; });
  ASSERT_TRUE(slowed);
  EXPECT_LE(*slowed, without_age + 1e-9);
  joint_states_.hold(slidingAt(1.0));
  EXPECT_TRUE(next([](double scale) { return scale == 1.0; }));
}

TEST_F(VelocityScaleTopic, IsZeroWithoutTransformsAndWithoutVelocities) {
  gantry().hold({0.9, 0.0, 0.0});
  joint_states_.hold(slidingAt(0.1));
  ASSERT_TRUE(next([](double scale) { return scale == 1.0; }));
  joint_states_.release();
  ASSERT_TRUE(next([](double scale) { return scale == 0.0; }));
  joint_states_.hold(slidingAt(0.1));
  ASSERT_TRUE(next([](double scale) { return scale == 1.0; }));
  gantry().release();
  ASSERT_TRUE(next([](double scale) { return scale == 0.0; }));
}

}  // namespace proximity_server::node::control_test
