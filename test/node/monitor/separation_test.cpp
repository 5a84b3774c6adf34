// ~separation: the terms of scene::separation(), or a scale of 0 with a reason.
#include "node/monitor/separation.h"

#include "node/monitor/slider_robot.h"
#include "scene/files.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <vector>

namespace proximity_server::node::separation_test {

/// The sliders brake with 2 m/s^2. The right one is at 0.5.
class SlidersAndPeople : public MonitorOfSliders {
 protected:
  void SetUp() override {
    config_.max_deceleration.of_all = 2.0;
    TrackedSource people;
    people.name = "people";
    people.topic = "/people";
    people.radius = 0.1;
    people.intrusion = 0.1;
    people.uncertainty = 0.05;
    config_.tracked = {people};
    follow("");
    settings_.rate = 0.1;  // a search may take 2.5 s
    settings_.stop_latency = 0.1;
  }

  Separation ask(double velocity, const std::vector<std::optional<double>>& ages) {
    PoseSnapshot snapshot = withTheRightSphereAt(*robot_, 0.5);
    snapshot.age = ros::Duration(0.05);
    VelocitySnapshot velocities;
    velocities.velocities = {0.0, 0.0, velocity};
    monitor_.cycle(snapshot, velocities, settings_, frames_);
    return monitor_.separation(snapshot, velocities, settings_, frames_, ages);
  }
  static void expectUnknown(const Separation& found, int code, const std::string& named) {
    EXPECT_EQ(found.status.code, code);
    EXPECT_NE(found.status.message.find(named), std::string::npos) << found.status.message;
    EXPECT_EQ(found.scale, 0.0);
    EXPECT_TRUE(std::isnan(found.margin) && std::isnan(found.person_age));
  }
};

TEST_F(SlidersAndPeople, HasTheTermsOfTheFormula) {
  add(ballAt(standingAt(2.5, 0.0, 0.0), "people"));
  const Separation found = ask(1.0, {0.25});
  EXPECT_EQ(found.status.code, QueryStatus::OK) << found.status.message;
  EXPECT_EQ(found.source, "people");
  EXPECT_EQ(found.shape.link, "right");
  EXPECT_NEAR(found.distance, 1.8, 1e-8);
  EXPECT_NEAR(found.person_age, 0.2, 1e-12) << "of which the poses are 0.05 s old";
  EXPECT_NEAR(found.reaction_time, 0.15, 1e-12);
  EXPECT_NEAR(found.stopping_time, 0.5, 1e-12);
  EXPECT_NEAR(found.human_way, 2.0 * 0.85, 1e-9);
  EXPECT_NEAR(found.reaction_way, 0.15, 1e-6);
  EXPECT_NEAR(found.stopping_way, 0.25, 1e-3);
  EXPECT_NEAR(found.protective_distance, 1.7 + 0.4 + 0.15, 1e-3);
  EXPECT_NEAR(found.margin, found.distance - found.protective_distance, 1e-12);
  const double expected =
      (std::sqrt(1.15 * 1.15 + 0.95) - 1.15) / 0.5;  // 1.8 - 0.15 s - 0.25 s^2 = 0.15 + 2 (0.35 + 0.5 s)
  EXPECT_LE(found.scale, expected);
  EXPECT_NEAR(found.scale, expected, 1e-3);
  EXPECT_TRUE(found.complete);
}

// With pose_latency the age of the poses is in the uncertainty of the robot. The person has moved in it all the same.
TEST_F(SlidersAndPeople, PersonMovesDuringTheWholeAgeOfItsMessage) {
  config_.pose_latency = PoseLatency::Limit;
  follow("");
  add(ballAt(standingAt(2.5, 0.0, 0.0), "people"));
  const Separation found = ask(0.0, {0.25});
  EXPECT_EQ(found.status.code, QueryStatus::OK) << found.status.message;
  EXPECT_NEAR(found.reaction_time, 0.1, 1e-12);
  EXPECT_NEAR(found.human_way, 2.0 * (0.25 + 0.1), 1e-9);
  EXPECT_GT(found.robot_uncertainty, 0.0);
}

TEST_F(SlidersAndPeople, AreFreeWhereNobodyIs) {
  const Separation found = ask(1.0, {0.0});
  EXPECT_EQ(found.status.code, QueryStatus::OK) << found.status.message;
  EXPECT_EQ(found.scale, 1.0);
  EXPECT_EQ(found.source, "");
  EXPECT_TRUE(std::isnan(found.margin));
}

TEST_F(SlidersAndPeople, StandWhereNothingIsKnown) {
  expectUnknown(ask(1.0, {std::nullopt}), QueryStatus::TF_STALE, "people");
  expectUnknown(ask(std::numeric_limits<double>::quiet_NaN(), {0.0}), QueryStatus::TF_UNAVAILABLE, "velocity");
  config_.max_deceleration.of_all.reset();
  follow("");
  expectUnknown(ask(1.0, {0.0}), QueryStatus::INVALID_ARGUMENT, "max_deceleration");
  config_.tracked.clear();
  follow("");
  expectUnknown(ask(1.0, {}), QueryStatus::INVALID_ARGUMENT, "tracked is empty");
}

}  // namespace proximity_server::node::separation_test
