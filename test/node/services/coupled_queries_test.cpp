#include "node/answers.h"
#include "node/asked_robot.h"
#include "node/services/queries.h"
#include "proximity_server/scene/files/file_value.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

// Questions about a gantry whose joints are coupled: 'x_axis + y_axis <= 1.5' and 'y_axis - lift <= 1'.

namespace proximity_server::node::coupled_queries_test {

bool has(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

class CoupledGantry : public testing::Test {
 protected:
  ros::Time moveTo(const GantryPosition& position) { return gantry_.moveTo(Gantry::all(position)); }

  AskedRobot gantry_{{robotText("gantry.urdf"), robotText("gantry.srdf")}, coupled()};

 private:
  static Config coupled() {
    Config config;
    config.joint_inequalities = scene::readYaml("- x_axis + y_axis <= 1.5\n- y_axis - lift <= 1", "");
    return config;
  }
};

sensor_msgs::JointState state(const std::vector<std::string>& names, const std::vector<double>& positions) {
  sensor_msgs::JointState result;
  result.name = names;
  result.position = positions;
  return result;
}

TEST_F(CoupledGantry, TellsTheStatesThatBreakAnInequality) {
  QueryConfigurationRequest request;
  request.states = {state({"x_axis", "y_axis", "lift"}, {1.0, 0.5, 0.0}),
                    state({"x_axis", "y_axis", "lift"}, {1.0, 0.75, 0.0})};
  const auto response = gantry_.ask(request);
  ASSERT_TRUE(response.success) << response.status.message;
  EXPECT_EQ(response.states.at(0).status.message, "");
  EXPECT_EQ(response.states.at(1).status.code, QueryStatus::OK);
  EXPECT_EQ(response.states.at(1).status.message, "'x_axis + y_axis <= 1.5' is broken by 0.25");
  EXPECT_EQ(response.status.message, "state 1: 'x_axis + y_axis <= 1.5' is broken by 0.25");
}

TEST_F(CoupledGantry, LooksUpTheJointsThatShareAnInequality) {
  QueryConfigurationRequest request;
  request.a = {shape("base")};
  request.b = {shape("ball")};  // the lift moves neither
  request.states = {state({"x_axis", "y_axis"}, {0.0, 0.75})};
  request.stamp = moveTo({0.0, 0.0, -0.5});
  const auto response = gantry_.ask(request);
  ASSERT_TRUE(response.success) << response.status.message;
  EXPECT_EQ(response.states.at(0).status.message, "'y_axis - lift <= 1' is broken by 0.25");
}

TEST_F(CoupledGantry, TellsTheFirstPointThatBreaksAnInequality) {
  auto request = between<QueryTrajectoryRequest>("base", "ball");
  request.trajectory.joint_names = {"x_axis", "y_axis"};
  request.missing_joints = QueryConfigurationRequest::ZERO;
  for (const double y : {0.0, 0.5, 1.25}) {
    trajectory_msgs::JointTrajectoryPoint point;
    point.positions = {1.0, y};
    point.time_from_start = ros::Duration(1.0 + y);
    request.trajectory.points.push_back(point);
  }
  const auto response = gantry_.ask(request);
  ASSERT_TRUE(response.success) << response.status.message;
  EXPECT_EQ(response.status.message, "point 2 is the first beyond a limit: 'x_axis + y_axis <= 1.5' is broken by 0.75");
  request.trajectory.points.pop_back();
  EXPECT_EQ(gantry_.ask(request).status.message, "");
}

TEST_F(CoupledGantry, TellsWhereASplineBreaksAnInequality) {
  // x(t) = 1 + t - t^2 / 2 and y = 0.25 + 0.5 t: the sum is 1.25 + 1.5 t - t^2 / 2, highest after 1.5 s, 2.375.
  auto request = between<QueryTrajectoryRequest>("base", "ball");
  request.trajectory.joint_names = {"x_axis", "y_axis"};
  request.missing_joints = QueryConfigurationRequest::FROM_TF;
  request.interpolation = QueryTrajectoryRequest::CUBIC;
  request.stamp = moveTo({0.0, 0.0, 0.5});
  for (const double t : {0.0, 2.0}) {
    trajectory_msgs::JointTrajectoryPoint point;
    point.positions = {1.0, 0.25 + 0.5 * t};
    point.velocities = {1.0 - t, 0.5};
    point.time_from_start = ros::Duration(t);
    request.trajectory.points.push_back(point);
  }
  const auto response = gantry_.ask(request);
  ASSERT_TRUE(response.success) << response.status.message;
  EXPECT_EQ(response.status.message,
            "segment 0 is the first beyond a limit: at 1.5 s 'x_axis + y_axis <= 1.5' is broken by 0.875");
  request.stamp = moveTo({0.0, 0.0, -0.25});
  for (auto& point : request.trajectory.points) point.positions[0] -= 1.0;
  EXPECT_EQ(gantry_.ask(request).status.message,
            "segment 0 is the first beyond a limit: at 2 s 'y_axis - lift <= 1' is broken by 0.5");
}

TEST_F(CoupledGantry, TellsWhenAMotionBreaksAnInequality) {
  auto request = between<FirstContactRequest>("base", "ball", moveTo({1.0, 0.25, 0.0}));
  request.horizon = 2.0;
  request.joints.name = {"y_axis"};
  request.joints.velocity = {0.5};
  const auto response = gantry_.ask(request);
  ASSERT_TRUE(response.success) << response.status.message;
  EXPECT_EQ(response.status.message, "'x_axis + y_axis <= 1.5' is broken from 0.5 s on");
  request.joints.velocity = {-0.5};
  EXPECT_EQ(gantry_.ask(request).status.message, "");
  request.stamp = moveTo({1.0, 0.75, 0.0});
  EXPECT_EQ(gantry_.ask(request).status.message, "'x_axis + y_axis <= 1.5' is broken by 0.25 at the start");
}

/// The error of a robot with this parameter.
std::string refusalOf(const scene::FileValue& inequalities) {
  Config config;
  config.joint_inequalities = inequalities;
  try {
    const Robot robot(robotText("gantry.urdf"), robotText("gantry.srdf"), config);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "";
}

TEST(JointInequalitiesParameter, IsRefusedByName) {
  EXPECT_EQ(refusalOf({std::string()}), "");
  EXPECT_EQ(refusalOf({std::string("cables.yaml")}), "parameter joint_inequalities is 'cables.yaml', no absolute path");
  EXPECT_TRUE(has(refusalOf({std::string("/nowhere/cables.yaml")}), "/nowhere/cables.yaml"));
  EXPECT_EQ(refusalOf({scene::FileValue::List{{std::string("x_axis + y_axes <= 1")}}}),
            "parameter joint_inequalities: [0]: 'x_axis + y_axes <= 1': there is no joint \"y_axes\" (did you mean "
            "\"y_axis\"?)");
  EXPECT_EQ(refusalOf({scene::FileValue::List{{std::string("x_axis >= 2.5")}}}),
            "parameter joint_inequalities: no positions of the joints within their limits obey 'x_axis >= 2.5'");
}

}  // namespace proximity_server::node::coupled_queries_test
