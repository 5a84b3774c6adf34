#include "node/answers/conversions.h"

#include "proximity_server/QueryStatus.h"
#include "proximity_server/scene/loading/load_robot_model.h"
#include "proximity_server/scene/model/kinematics.h"
#include "robots/urdf.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>

namespace proximity_server::node::conversions_test {

using namespace narrowphase;
using namespace scene;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

using namespace robots;

/// Two links side by side, 1 m apart along x; that of "right" is turned by a quarter about z.
RobotModel twoLinks() {
  const std::string left = R"(<collision name="shell"><geometry><sphere radius="0.1"/></geometry></collision>)";
  return loadRobotModel(
      urdfOf(link("left", left) + link("right", ball("0.1")) + slider("slide", "left", "right", "1 0 0")),
      packageResolver({}));
}

BodyPoses poses() {
  Eigen::Isometry3d right = Eigen::Isometry3d::Identity();
  right.translation().x() = 1.0;
  right.linear() << 0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0;
  return {Eigen::Isometry3d::Identity(), right};
}

PairProximity pairWith(Status status, double lower, double upper) {
  PairProximity pair;
  const RobotModel robot = twoLinks();
  pair.asked = {{robot.findLink("left")}, {robot.findLink("right")}};
  pair.collision_a = pair.collision_b = 1;
  pair.result.status = status;
  pair.result.lower_bound = lower;
  pair.result.upper_bound = upper;
  pair.result.distance = 0.5 * (lower + upper);
  return pair;
}

Proximity message(const PairProximity& pair, double threshold = kInfinity) {
  Question question;
  question.threshold = threshold;
  return toMessage(twoLinks(), poses(), pair, question);
}

TEST(Conversions, StateIsWhatTheBoundsProve) {
  const struct {
    Status status;
    double lower, upper;
    int state;
  } rows[] = {
      {Status::Converged, 0.1, 0.1, Proximity::SEPARATED},
      {Status::Converged, 0.0, 0.0, Proximity::TOUCHING},
      {Status::Converged, -1e-10, 1e-10, Proximity::TOUCHING},
      {Status::Converged, -0.1, -0.1, Proximity::PENETRATING},
      {Status::IterationLimit, 0.1, 0.3, Proximity::SEPARATED},
      {Status::IterationLimit, -0.3, -0.1, Proximity::PENETRATING},
      {Status::IterationLimit, -0.1, 0.1, Proximity::UNKNOWN},
      {Status::Degenerate, -0.1, 0.1, Proximity::UNKNOWN},
      {Status::Threshold, -0.1, 0.0, Proximity::PENETRATING},
      {Status::Unknown, -kInfinity, kInfinity, Proximity::UNKNOWN},
  };
  for (const auto& row : rows) {
    EXPECT_EQ(message(pairWith(row.status, row.lower, row.upper)).state, row.state) << row.lower << " " << row.upper;
  }
}

TEST(Conversions, BeyondTheThresholdTheDistanceIsTheLowerBound) {
  const Proximity beyond = message(pairWith(Status::Threshold, 0.2, 0.6), 0.1);
  EXPECT_EQ(beyond.state, Proximity::BEYOND_THRESHOLD);
  EXPECT_EQ(beyond.distance, 0.2);
  EXPECT_EQ(beyond.upper_bound, 0.6);
}

TEST(Conversions, WhatIsUnknownHasNoNumber) {
  const Proximity unknown = message(PairProximity{{{0}, {1}}, 0, 0, {}, Representation::Exact});
  for (const double number : {unknown.distance, unknown.lower_bound, unknown.upper_bound, unknown.point_a.x,
                              unknown.point_b.y, unknown.normal.z, unknown.point_a_link.x, unknown.point_b_link.x}) {
    EXPECT_TRUE(std::isnan(number));
  }
  EXPECT_FALSE(unknown.points_valid);
  EXPECT_FALSE(unknown.a.link.empty());
}

TEST(Conversions, PointsAreGivenInTheFramesOfTheirLinks) {
  PairProximity pair = pairWith(Status::Converged, 0.8, 0.8);
  pair.result.point_a = {0.1, 0.0, 0.0};
  pair.result.point_b = {0.9, 0.0, 0.0};
  pair.result.has_points = true;
  const Proximity with_points = message(pair);
  EXPECT_EQ(with_points.point_a_link.x, 0.1);
  EXPECT_NEAR(with_points.point_b_link.x, 0.0, 1e-15);
  EXPECT_NEAR(with_points.point_b_link.y, 0.1, 1e-15);  // 1 - 0.9, towards -x of the common frame
}

TEST(Conversions, NamesTheClosestShape) {
  const Proximity named = message(pairWith(Status::Converged, 0.8, 0.8));
  EXPECT_EQ(named.a.link, "left");
  EXPECT_EQ(named.a.index, 1u);
  EXPECT_EQ(named.a.name, "shell");
}

TEST(Conversions, WideBoundsAreNotConverged) {
  EXPECT_EQ(statusCode(pairWith(Status::Converged, 0.1, 0.1).result), QueryStatus::OK);
  EXPECT_EQ(statusCode(pairWith(Status::Threshold, 0.1, 0.3).result), QueryStatus::OK);
  EXPECT_EQ(statusCode(pairWith(Status::IterationLimit, 0.1, 0.3).result), QueryStatus::NOT_CONVERGED);
  EXPECT_EQ(statusCode(pairWith(Status::Degenerate, 0.1, 0.3).result), QueryStatus::NOT_CONVERGED);
}

}  // namespace proximity_server::node::conversions_test
