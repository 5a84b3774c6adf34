// Guaranteed distances in the answers of services. The joints of the gantry slide along the axes, so that an
// uncertainty counts in full along its axis.
#include "node/answers.h"
#include "node/asked_robot.h"
#include "node/object_messages.h"
#include "node/services/queries.h"
#include "scene/files.h"

#include <cmath>
#include <string>

namespace proximity_server::node::uncertain_queries_test {

class UncertainGantry : public AskedGantry {
 protected:
  ros::Time stamp() { return moveTo({0.5, 0.0, 0.0}); }  // base and ball are 0.3 m apart along x
  template <class Request>
  auto askWithin(const std::string& uncertainty) {
    auto request = between<Request>("base", "ball", stamp());
    request.uncertainty = uncertainty;
    return ask(request);
  }
};

TEST_F(UncertainGantry, GuaranteesTheLowerBoundWithoutUncertainty) {
  for (const char* exact : {"", "{}", "joint_uncertainty: 0"}) {
    const auto response = askWithin<MinimumDistanceRequest>(exact);
    ASSERT_TRUE(response.success) << response.status.message;
    EXPECT_EQ(response.pair.guaranteed, response.pair.lower_bound) << exact;
  }
}

TEST_F(UncertainGantry, GuaranteesTheDistanceWithinTheUncertaintyOfTheRequest) {
  for (const char* text : {"0.01", "joint_uncertainty: 0.01", "joint_uncertainty: {x_axis: 0.01}"}) {
    const auto response = askWithin<MinimumDistanceRequest>(text);
    ASSERT_TRUE(response.success) << response.status.message;
    EXPECT_NEAR(response.pair.distance, 0.3, kTolerance);
    EXPECT_NEAR(response.pair.guaranteed, 0.29, 1e-3) << text;
    EXPECT_LE(response.pair.guaranteed, 0.29) << text;
  }
  EXPECT_NEAR(askWithin<SeparationAxisRequest>("0.01").pair.guaranteed, 0.29, 1e-3);
  const Proximity apart = askWithin<PenetrationDepthRequest>("0.1").pair;  // only proven to be apart
  EXPECT_LE(apart.guaranteed, 0.2);
  EXPECT_GT(apart.guaranteed, 0.1);
}

TEST_F(UncertainGantry, GuaranteesTheDistanceOfAnObjectThatAFrameOfTfCarries) {
  moveTo({1.0, 0.0, 0.0});
  geometry_msgs::TransformStamped tray = Gantry::post({0.0, 0.0, 0.5});
  tray.child_frame_id = "tray";
  gantry_.publish({tray}, ros::Time::now());
  ASSERT_TRUE(ask(requestOf({addBallInFrame("part", "tray", poseAt(1.0, 0.0, 0.0))})).success);
  auto request = between<MinimumDistanceRequest>("ball", "part");
  request.uncertainty = "object_uncertainty: {part: 0.01}";
  const auto response = ask(request);
  ASSERT_TRUE(response.success) << response.status.message;
  EXPECT_NEAR(response.pair.distance, 0.3, kTolerance);
  EXPECT_NEAR(response.pair.guaranteed, 0.29, 1e-3);
}

TEST_F(UncertainGantry, GuaranteesEveryPairOfAList) {
  QueryPairsRequest request;
  request.stamp = stamp();
  request.mode = QueryPairsRequest::K_CLOSEST;
  request.k = 2;
  request.uncertainty = "0.01";
  const auto response = ask(request);
  ASSERT_TRUE(response.success) << response.status.message;
  ASSERT_EQ(response.pairs.size(), 2u);
  for (const Proximity& pair : response.pairs) {
    EXPECT_LT(pair.guaranteed, pair.lower_bound - 0.005);
    EXPECT_GT(pair.guaranteed, pair.lower_bound - 0.05);
  }
  EXPECT_EQ(response.minimum.guaranteed, response.pairs[0].guaranteed);
}

TEST_F(UncertainGantry, GuaranteesInEveryState) {
  QueryConfigurationRequest request;
  request.missing_joints = QueryConfigurationRequest::ZERO;
  request.uncertainty = "0.01";
  for (const double x : {0.5, 0.6}) {
    sensor_msgs::JointState state;
    state.name = {"x_axis"};
    state.position = {x};
    request.states.push_back(state);
  }
  const auto response = ask(request);
  ASSERT_TRUE(response.success) << response.status.message;
  EXPECT_NEAR(response.states[0].minimum.guaranteed, 0.29, 1e-3);
  EXPECT_NEAR(response.states[1].minimum.guaranteed, 0.39, 1e-3);
}

TEST(UncertaintyOfTheParameters, IsThatOfRequestsWithoutOne) {
  Config config;
  config.uncertainty.joint = {0.01};
  AskedRobot gantry({robotText("gantry.urdf"), robotText("gantry.srdf")}, config);
  auto request = between<MinimumDistanceRequest>("base", "ball", gantry.moveTo(Gantry::all({0.5, 0.0, 0.0})));
  EXPECT_NEAR(gantry.ask(request).pair.guaranteed, 0.29, 1e-3);
  request.uncertainty = "{}";
  EXPECT_NEAR(gantry.ask(request).pair.guaranteed, 0.3, kTolerance);
}

// Bounds of the scene tell without a deadline that the two do not overlap.
TEST(UncertaintyOfTheParameters, IsTakenCoarselyWhenTheTimeIsOver) {
  Config config;
  config.max_request_time = 1e-9;
  AskedRobot gantry({robotText("gantry.urdf"), robotText("gantry.srdf")}, config);
  auto request = between<PenetrationDepthRequest>("base", "ball", gantry.moveTo(Gantry::all({0.5, 0.0, 0.0})));
  request.uncertainty = "0.01";
  const auto response = gantry.ask(request);
  EXPECT_FALSE(response.success);
  EXPECT_EQ(response.status.code, QueryStatus::OVER_BUDGET);
  EXPECT_EQ(response.status.message, "the time was over: guaranteed distances are coarse, max_request_time is 1e-09 s");
  EXPECT_LE(response.pair.guaranteed, 0.29);
  EXPECT_GT(response.pair.guaranteed, 0.0);
}

TEST(UncertaintyOfTheParameters, IsRefusedByName) {
  Config config;
  config.uncertainty.joint = {scene::FileValue::Map{{"x_axs", {0.1}}}};
  const std::string refusal = scene::errorOf([&] {
    AskedRobot({robotText("gantry.urdf"), robotText("gantry.srdf")}, config);
  });
  EXPECT_EQ(refusal, "parameter: joint_uncertainty/x_axs: there is no joint \"x_axs\" (did you mean \"x_axis\"?)");
}

}  // namespace proximity_server::node::uncertain_queries_test
