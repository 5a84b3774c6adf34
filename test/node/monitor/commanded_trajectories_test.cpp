// The lookahead along the splines of controllers, on the sliders.
#include "node/monitor/commanded_trajectories.h"

#include "allocations.h"
#include "node/monitor/slider_robot.h"
#include "node/robot/load_config.h"
#include "proximity_server/scene/files/file_value.h"
#include "proximity_server/scene/model/names.h"
#include "scene/files.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>
#include <map>
#include <random>
#include <string>
#include <thread>
#include <vector>

namespace proximity_server::node::commanded_trajectories_test {

using trajectory_msgs::JointTrajectory;

/// A point of a trajectory of one joint; NaN: the point has no velocity, or no acceleration.
struct Knot {
  double time, position;
  double velocity = std::numeric_limits<double>::quiet_NaN();
  double acceleration = std::numeric_limits<double>::quiet_NaN();
};

JointTrajectory trajectoryOf(const std::string& joint, const std::vector<Knot>& knots) {
  JointTrajectory trajectory;
  trajectory.joint_names = {joint};
  for (const Knot& knot : knots) {
    trajectory_msgs::JointTrajectoryPoint point;
    point.time_from_start = ros::Duration(knot.time);
    point.positions = {knot.position};
    if (!std::isnan(knot.velocity)) point.velocities = {knot.velocity};
    if (!std::isnan(knot.acceleration)) point.accelerations = {knot.acceleration};
    trajectory.points.push_back(point);
  }
  return trajectory;
}

ros::Time at(double time) { return ros::Time(1000.0) + ros::Duration(time); }

class Commanded : public MonitorOfSliders {
 protected:
  void SetUp() override {
    ros::Time::init();  // for warnings
    settings_.lookahead = 2.0;
    settings_.rate = 0.1;  // a search may take 2.5 s
    config_.tracking_error = {0.0, {}};
    use(kSliders);
  }

  void use(const std::string& urdf) {
    robot_ = std::make_shared<const Robot>(urdf, "", config_);
    monitor_.follow(robot_);
    commands_.follow(robot_, {{"/arm", 0}, {"/gripper", 0}});
  }

  void command(double time, const std::string& topic, const JointTrajectory& trajectory) {
    EXPECT_EQ(commands_.take(topic, trajectory, at(time)), "");
  }

  using Three = std::array<double, 3>;  // of left, middle and right

  Lookahead ahead(double time, const Three& positions, const Three& velocities = {}, double now = 0.0) {
    PoseSnapshot poses;
    poses.stamp = at(time);
    poses.poses =
        scene::forwardKinematics(robot_->robotModel(), std::vector<double>(positions.begin(), positions.end()));
    VelocitySnapshot moving;
    moving.velocities.assign(velocities.begin(), velocities.end());
    moving.stamps.assign(3, poses.stamp);
    const long before = allocations();
    const CommandedMotion& motion = commands_.lookUp(monitor_.joints(), poses, moving, at(std::max(time, now)));
    const Clearance& clearance = monitor_.cycle(poses, moving, settings_, {}, motion);
    allocated_ = allocations() - before;
    return clearance.lookahead;
  }

  long allocated_ = 0;  ///< in the last cycle
  CommandedTrajectories commands_;
};

/// The middle sphere stops for no point: between its points, at -0.7, it goes to -0.95. The left one is at -1. They are
/// 0.02 m apart at -0.78.
const std::vector<Knot> kOvershoot{{1.0, -0.7, -1.0}, {2.0, -0.7, 1.0}};
const double kContactOfOvershoot = 1.0 + 0.5 * (1.0 - std::sqrt(1.0 - 4.0 * 0.08));
double positionIn(const std::vector<Knot>& knots, double time) {
  Knot from{0.0, 0.0, 0.0};
  for (const Knot& to : knots) {
    const double length = to.time - from.time, u = (time - from.time) / length;
    if (u <= 1.0) {
      const double way = to.position - from.position, v = length * from.velocity, w = length * to.velocity;
      return from.position + u * (v + u * (3.0 * way - 2.0 * v - w + u * (v + w - 2.0 * way)));
    }
    from = to;
  }
  return from.position;
}

double velocityIn(const std::vector<Knot>& knots, double time) {
  return (positionIn(knots, time + 1e-6) - positionIn(knots, time - 1e-6)) / 2e-6;
}

TEST_F(Commanded, SeesTheContactOfASplineThatOvershootsItsPoints) {
  EXPECT_EQ(ahead(-0.01, {-1.0, 0.0, 0.5}).state, Lookahead::FREE);
  command(0.0, "/arm", trajectoryOf("to_middle", kOvershoot));
  const Lookahead lookahead = ahead(0.0, {-1.0, 0.0, 0.5});
  EXPECT_EQ(lookahead.status.code, QueryStatus::OK) << lookahead.status.message;
  EXPECT_EQ(lookahead.status.message, "along the trajectory of /arm or with the velocities, with a delay of 0 s");
  ASSERT_EQ(lookahead.state, Lookahead::CONTACT);
  EXPECT_NEAR(lookahead.time_to_contact, kContactOfOvershoot, 1e-3);
  EXPECT_LE(lookahead.time_free, kContactOfOvershoot);
  EXPECT_GT(lookahead.time_free, kContactOfOvershoot - scene::SplineDelays::kLargestLead - 1e-3);
  EXPECT_EQ(lookahead.pair.a.link, "left");
  EXPECT_EQ(lookahead.pair.b.link, "middle");
  EXPECT_EQ(lookahead.pair_contact_distance, 0.02);
  // With the same points and no velocities the controller goes straight from one to the next.
  use(kSliders);
  command(0.0, "/arm", trajectoryOf("to_middle", {{1.0, -0.7}, {2.0, -0.7}}));
  EXPECT_EQ(ahead(0.0, {-1.0, 0.0, 0.5}).state, Lookahead::FREE);
}

TEST_F(Commanded, AllocatesNothingWhileTheSameJointsFollow) {
  std::vector<Knot> knots;  // to and fro, each second the same
  for (int i = 1; i <= 10; ++i) knots.push_back({0.5 * i, i % 2 == 0 ? 0.0 : 0.1, 0.0});
  command(0.0, "/arm", trajectoryOf("to_middle", knots));
  for (int i = 0; i < 60; ++i) {
    const double time = 0.05 * i;
    const Lookahead lookahead =
        ahead(time, {-1.0, positionIn(knots, time), 0.5}, {0.0, i == 0 ? 0.0 : velocityIn(knots, time), 0.0});
    if (i < 30) continue;
    EXPECT_EQ(lookahead.state, Lookahead::FREE) << lookahead.status.message;
    EXPECT_EQ(allocated_, 0) << time << ": " << lookahead.status.message;
  }
}

// The spline goes to -12 between its points, which are within the limits of 9.
TEST_F(Commanded, NamesTheJointThatASplineTakesBeyondItsLimit) {
  const std::vector<Knot> knots{{1.0, 0.0, 81.0}};
  command(0.0, "/arm", trajectoryOf("to_middle", knots));
  EXPECT_EQ(ahead(0.0, {-1.0, 0.0, 0.5}).status.message,
            "along the trajectory of /arm or with the velocities, with a delay of 0 s, where in 0.667 s joint "
            "'to_middle' goes to -12, and its lower limit is -9");
  const std::string message = ahead(0.9, {-1.0, positionIn(knots, 0.9), 0.5}).status.message;
  EXPECT_EQ(message.find("limit"), std::string::npos) << message;
}

TEST_F(Commanded, NamesTheInequalityThatASplineBreaks) {
  config_.joint_inequalities = scene::readYaml("- to_right - to_middle <= 1.4", "");
  use(kSliders);
  command(0.0, "/arm", trajectoryOf("to_middle", kOvershoot));
  const std::string message = ahead(0.0, {-2.0, 0.0, 0.5}).status.message;
  EXPECT_NE(message.find("after 1.5 s 'to_right - to_middle <= 1.4' is broken by 0.05"), std::string::npos) << message;
  EXPECT_EQ(ahead(0.0, {-2.0, 0.0, 0.4}).status.message.find("broken"), std::string::npos) << "the right one rests";
}

TEST_F(Commanded, TakesQuinticsOfPointsWithAccelerations) {
  // From rest at -0.5 with -8 m/s^2 to rest with 8: p = -0.5 - 4 u^2 (1 - u)^3 + 4 u^3 (1 - u)^2, lowest at 0.276.
  command(0.0, "/arm", trajectoryOf("to_middle", {{1.0, -0.5, 0.0, -8.0}, {2.0, -0.5, 0.0, 8.0}}));
  const double u = 0.5 * (1.0 - std::sqrt(0.2));
  const double lowest = -0.5 - 4.0 * u * u * std::pow(1.0 - u, 3) + 4.0 * std::pow(u, 3) * std::pow(1.0 - u, 2);
  const double gap = lowest + 1.0 - 0.2;
  settings_.stop_distance = gap - 1e-3;
  EXPECT_EQ(ahead(0.0, {-1.0, 0.0, 0.5}).state, Lookahead::FREE);
  settings_.stop_distance = gap + 1e-3;
  const Lookahead lookahead = ahead(0.0, {-1.0, 0.0, 0.5});
  EXPECT_EQ(lookahead.state, Lookahead::CONTACT);
  EXPECT_NEAR(lookahead.time_to_contact, 1.0 + u, 0.1);
}

TEST_F(Commanded, FindsTheDelayWithWhichTheRobotFollows) {
  for (const double delay : {0.02, 0.08, -0.02}) {
    use(kSliders);
    command(0.0, "/arm", trajectoryOf("to_middle", kOvershoot));
    ahead(0.0, {-1.0, 0.0, 0.5});
    for (double time = 0.2; time < 1.0; time += 0.1) {
      const Lookahead lookahead = ahead(time, {-1.0, positionIn(kOvershoot, time - delay), 0.5},
                                        {0.0, velocityIn(kOvershoot, time - delay), 0.0});
      ASSERT_EQ(lookahead.state, Lookahead::CONTACT) << lookahead.status.message;
      EXPECT_EQ(lookahead.status.message.find(time < 0.35 ? "along" : "along the trajectory of /arm, with a delay"), 0U)
          << delay << " at " << time << ": " << lookahead.status.message;
      EXPECT_NEAR(lookahead.time_to_contact, kContactOfOvershoot + delay - time, 2e-3) << delay << " at " << time;
    }
  }
}

TEST_F(Commanded, TakesTheVelocitiesIfAJointIsOffItsTrajectory) {
  command(0.0, "/arm", trajectoryOf("to_middle", kOvershoot));
  ahead(0.0, {-1.0, 0.0, 0.5});
  const Lookahead lookahead = ahead(0.5, {-1.0, 0.25, 0.5});
  EXPECT_EQ(lookahead.state, Lookahead::FREE) << "its velocity is 0";
  // It would be at -0.15 after 0.4 s, with the largest delay.
  EXPECT_EQ(lookahead.status.message, "joint 'to_middle' is 0.4 m off the trajectory of /arm: velocities are taken");
  EXPECT_EQ(ahead(0.6, {-1.0, positionIn(kOvershoot, 0.6), 0.5}).state, Lookahead::CONTACT) << "it is there again";
}

TEST_F(Commanded, ProvesWhatLiesWithinTheTrackingError) {
  const auto contact = [&](double error) {
    config_.tracking_error = {std::nullopt, {{"to_middle", error}}};
    use(kSliders);
    command(0.0, "/arm", trajectoryOf("to_middle", {{2.0, -1.0}}));
    ahead(0.0, {-1.0, 0.0, 0.5});
    return ahead(0.5, {-1.0, -0.25 + error, 0.5});
  };
  // It is at the stop distance at -0.78; the tube may be there earlier.
  for (const double error : {0.001, 0.01, 0.03}) {
    const Lookahead lookahead = contact(error);
    ASSERT_EQ(lookahead.state, Lookahead::CONTACT) << lookahead.status.message;
    EXPECT_LE(lookahead.time_free, (0.53 - error) / 0.5 + 0.1) << "the delay is at most 0.1 s";
    EXPECT_LE(lookahead.time_free, lookahead.time_to_contact);
  }
}

TEST_F(Commanded, TakesTheVelocitiesAfterTheEnd) {
  command(0.0, "/arm", trajectoryOf("to_middle", {{1.0, -0.5}}));
  EXPECT_EQ(ahead(0.0, {-1.0, 0.0, 0.5}).state, Lookahead::FREE) << "it rests at -0.5 in the end";
  EXPECT_NE(ahead(0.9, {-1.0, -0.45, 0.5}, {0.0, -0.5, 0.0}).status.message, "");
  const Lookahead lookahead = ahead(1.01, {-1.0, -0.5, 0.5}, {0.0, -0.5, 0.0});
  EXPECT_EQ(lookahead.status.message, "");
  EXPECT_NEAR(lookahead.time_to_contact, 0.28 / 0.5, 1e-5);
}

TEST_F(Commanded, MovesTheJointsOfSeveralControllersAtOnce) {
  command(0.0, "/arm", trajectoryOf("to_middle", {{1.0, 0.2}}));
  command(0.0, "/gripper", trajectoryOf("to_right", {{0.5, 0.4}, {1.0, 0.35}}));
  const Lookahead lookahead = ahead(0.0, {-1.0, 0.0, 0.5});
  ASSERT_EQ(lookahead.state, Lookahead::CONTACT) << lookahead.status.message;
  // One of them may be 0.12 s later than the other, so long as both rest.
  EXPECT_NEAR(lookahead.time_to_contact, 0.5 + 0.08 / 0.3, 0.12);
  EXPECT_LE(lookahead.time_free, 0.5 + 0.08 / 0.3);
  EXPECT_EQ(lookahead.pair.b.link, "right");
  EXPECT_EQ(lookahead.status.message,
            "along the trajectory of /arm or with the velocities, with a delay of 0 s and of /gripper or with the "
            "velocities, with a delay of 0 s");
}

TEST_F(Commanded, StopsOtherJointsAtTheirLimits) {
  using namespace robots;
  const std::string limited = kSliders;
  std::string urdf = limited;
  const std::string wide = "lower='-9' upper='9'";
  urdf.replace(urdf.find(wide), wide.size(), "lower='-9' upper='-0.8'");  // of the left slider
  const JointTrajectory away = trajectoryOf("to_middle", {{2.0, 0.05}});
  command(0.0, "/arm", away);
  EXPECT_EQ(ahead(0.0, {-1.0, 0.0, 0.5}, {0.5, 0.0, 0.0}).state, Lookahead::CONTACT);
  use(urdf);
  command(0.0, "/arm", away);
  const Lookahead lookahead = ahead(0.0, {-1.0, 0.0, 0.5}, {0.5, 0.0, 0.0});
  EXPECT_EQ(lookahead.state, Lookahead::FREE) << lookahead.status.message;
  EXPECT_EQ(lookahead.time_free, 2.0);
  EXPECT_EQ(lookahead.joints_at_limit, std::vector<std::string>{"to_left"});
  ASSERT_EQ(lookahead.limit_times.size(), 1U);
  EXPECT_NEAR(lookahead.limit_times[0], 0.4, 1e-9);
}

TEST_F(Commanded, IsReplacedByTheNextTrajectoryWhileTheRobotFollowsLate) {
  constexpr double kDelay = 0.03;
  const auto middle = [](double time) { return positionIn(kOvershoot, time); };
  command(0.0, "/arm", trajectoryOf("to_middle", kOvershoot));
  ahead(0.0, {-1.0, 0.0, 0.5});
  ahead(0.9, {-1.0, middle(0.9 - kDelay), 0.5}, {0.0, -1.0, 0.0});
  // A cubic from where the first one is at 0.9 s, which turns back in time.
  command(0.9, "/arm", trajectoryOf("to_middle", {{0.3, -0.6, 0.5}, {1.0, 0.0, 0.0}}));
  for (const double time : {0.91, 0.92, 0.929}) {  // the robot is still on the first one
    const Lookahead lookahead = ahead(time, {-1.0, middle(time - kDelay), 0.5}, {0.0, -1.0, 0.0});
    EXPECT_EQ(lookahead.status.message.find("along the trajectory of /arm or the one before it"), 0U)
        << lookahead.status.message;
    EXPECT_EQ(lookahead.state, Lookahead::CONTACT) << "the controller may have refused the other one";
  }
}

TEST_F(Commanded, IsReplacedForTheJointsOfTheNextTrajectoryOnly) {
  JointTrajectory both = trajectoryOf("to_middle", {{2.0, -0.1}});
  both.joint_names.push_back("to_right");
  both.points[0].positions.push_back(0.6);
  command(0.0, "/arm", both);
  EXPECT_EQ(ahead(0.0, {-1.0, 0.0, 0.5}).state, Lookahead::FREE);
  command(0.0, "/gripper", trajectoryOf("to_right", {{1.0, 0.1}}));
  const Lookahead lookahead = ahead(0.0, {-1.0, 0.0, 0.5});
  EXPECT_EQ(lookahead.state, Lookahead::CONTACT);
  EXPECT_NE(lookahead.status.message.find("/arm"), std::string::npos);
  EXPECT_NE(lookahead.status.message.find("/gripper"), std::string::npos);
}

TEST_F(Commanded, IsEndedByATrajectoryWithoutPoints) {
  const auto message = [&](const std::string& topic, const std::vector<std::string>& joints) {
    use(kSliders);
    command(0.0, "/arm", trajectoryOf("to_middle", kOvershoot));
    ahead(0.0, {-1.0, 0.0, 0.5});
    JointTrajectory nothing;
    nothing.joint_names = joints;
    command(0.0, topic, nothing);
    ahead(0.0, {-1.0, 0.0, 0.5});
    return ahead(0.3, {-1.0, 0.0, 0.5}).status.message;
  };
  EXPECT_EQ(message("/arm", {}), "");
  EXPECT_EQ(message("/gripper", {"to_middle"}), "");
  EXPECT_NE(message("/gripper", {}), "") << "it commanded nothing";
  EXPECT_NE(message("/gripper", {"to_right"}), "");
}

TEST_F(Commanded, BeginsAtItsStamp) {
  JointTrajectory later = trajectoryOf("to_middle", kOvershoot);
  later.header.stamp = at(0.5);
  command(0.0, "/arm", trajectoryOf("to_middle", {{2.0, 0.0}}));
  command(0.0, "/gripper", later);
  for (const double time : {0.0, 0.5}) {
    const Lookahead lookahead = ahead(time, {-1.0, 0.0, 0.5});
    ASSERT_EQ(lookahead.state, Lookahead::CONTACT);
    EXPECT_NEAR(lookahead.time_to_contact, 0.5 + kContactOfOvershoot - time, 1e-3);
  }

  JointTrajectory earlier = trajectoryOf("to_middle", {{0.5, 5.0}, {1.0, 0.0}, {2.0, -1.0}});
  earlier.header.stamp = at(-1.5);  // two of its points are past
  use(kSliders);
  command(0.0, "/arm", earlier);
  EXPECT_NEAR(ahead(0.0, {-1.0, 0.0, 0.5}).time_to_contact, 0.5 * 0.78, 1e-3);
}

TEST_F(Commanded, BeginsAfterOldPosesWithTheirVelocities) {
  command(0.0, "/arm", trajectoryOf("to_middle", {{1.0, -0.9}}));
  const Lookahead lookahead = ahead(-0.05, {-1.0, -0.1, 5.0}, {0.0, 2.0, 0.0}, /*now=*/0.0);
  ASSERT_EQ(lookahead.state, Lookahead::CONTACT) << lookahead.status.message;
  // From 0 at 0, or as far from there as it goes in the time by which the controller may be earlier or later.
  EXPECT_NEAR(lookahead.time_to_contact, 0.05 + 0.78 / 0.9, 2.0 * scene::SplineDelays::kLargestLead / 0.9 + 1e-3);
}

TEST_F(Commanded, RefusesWhatTheControllerRefusesAndKeepsTheTrajectoryBefore) {
  command(0.0, "/arm", trajectoryOf("to_middle", kOvershoot));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  JointTrajectory no_names = trajectoryOf("to_middle", {{1.0, 0.0}}), sizes = no_names, not_a_number = no_names;
  no_names.joint_names.clear();
  no_names.points[0].positions.clear();
  sizes.points[0].velocities = {1.0, 2.0};
  not_a_number.points[0].accelerations = {nan};
  const std::vector<std::pair<JointTrajectory, std::string>> refused{
      {trajectoryOf("to_midle", {{1.0, 0.0}}), "trajectory: there is no joint 'to_midle': did you mean 'to_middle'?"},
      {trajectoryOf("to_middle", {{1.0, 0.0}, {1.0, 0.1}}),
       "point 1: its time_from_start is not later than that of the point before"},
      {trajectoryOf("to_middle", {{1.0, 0.0}, {2.0, nan}}), "point 1: the position of joint 'to_middle' is not finite"},
      {sizes, "point 0: one velocity too many for 1 joints, after that of joint 'to_middle'"},
      {not_a_number, "point 0: the acceleration of joint 'to_middle' is not finite"},
      {no_names, "the trajectory names no joints"}};
  for (const auto& [trajectory, problem] : refused) EXPECT_EQ(commands_.take("/arm", trajectory, at(0.0)), problem);
  EXPECT_EQ(ahead(0.0, {-1.0, 0.0, 0.5}).state, Lookahead::CONTACT);
  // It is past, or too fast for numbers: that is found when it begins.
  JointTrajectory past = trajectoryOf("to_middle", {{1.0, 0.0}});
  past.header.stamp = at(-5.0);
  command(0.0, "/arm", past);
  EXPECT_EQ(ahead(0.0, {-1.0, 0.0, 0.5}).state, Lookahead::CONTACT);
  command(0.0, "/arm", trajectoryOf("to_middle", {{1.0, 1e308, 1e308}, {2.0, -1e308, 1e308}}));
  EXPECT_EQ(ahead(0.0, {-1.0, 0.0, 0.5}).state, Lookahead::CONTACT);
}

TEST_F(Commanded, ForgetsAllIfTheClockJumpsBackOrTheRobotIsLoadedAgain) {
  command(0.0, "/arm", trajectoryOf("to_middle", kOvershoot));
  EXPECT_EQ(ahead(0.0, {-1.0, 0.0, 0.5}).state, Lookahead::CONTACT);
  EXPECT_EQ(ahead(-100.0, {-1.0, 0.0, 0.5}, {}, -100.0).status.message, "");
  command(0.0, "/arm", trajectoryOf("to_middle", kOvershoot));
  EXPECT_EQ(ahead(0.0, {-1.0, 0.0, 0.5}).state, Lookahead::CONTACT);
  use(kSliders);
  EXPECT_EQ(ahead(0.0, {-1.0, 0.0, 0.5}).status.message, "");
}

TEST_F(Commanded, CarriesAndMeetsObjects) {
  scene::Attached held{"middle"};
  held.link_T_object.translation().x() = -0.2;
  add(ballAt(held, "held"));
  add(ballAt(standingAt(-0.7, 0.0, 0.0)));
  command(0.0, "/arm", trajectoryOf("to_middle", {{1.0, -0.5}}));
  const Lookahead lookahead = ahead(0.0, {-1.5, 0.0, 0.5});
  ASSERT_EQ(lookahead.state, Lookahead::CONTACT) << lookahead.status.message;
  EXPECT_NEAR(lookahead.time_to_contact, (0.3 - 0.02) / 0.5, 1e-3);
}

TEST_F(Commanded, IsUnknownFromWhereTheTimeOfTheSearchEnds) {
  settings_.rate = 1e9;
  command(0.0, "/arm", trajectoryOf("to_middle", kOvershoot));
  const Lookahead lookahead = ahead(0.0, {-1.0, 0.0, 0.5});
  EXPECT_EQ(lookahead.state, Lookahead::UNKNOWN);
  EXPECT_EQ(lookahead.status.code, QueryStatus::OVER_BUDGET);
  EXPECT_LT(lookahead.time_free, kContactOfOvershoot);
}

// The middle sphere swings to the right one, at -2 m/s its trajectory leads to the left; at 0 the two cross.
TEST_F(Commanded, IsNotFollowedByARobotThatCrossesIt) {
  config_.tracking_error = {0.01, {}};
  use(kSliders);
  settings_.lookahead = 0.5;
  command(-0.3, "/arm", trajectoryOf("to_middle", {{0.3, 0.0, -0.1}, {2.0, -0.3, 0.0}}));
  for (double time = -0.3; time < 0.1; time += 0.01) {
    const Lookahead lookahead = ahead(time, {-1.0, 2.0 * time, 0.5}, {0.0, 2.0, 0.0});
    ASSERT_EQ(lookahead.state, Lookahead::CONTACT) << time << ": " << lookahead.status.message;
    EXPECT_NEAR(lookahead.time_to_contact, 0.14 - time, 1e-3) << lookahead.status.message;
  }
}

// With both, the contact is that of the velocity, or that of the spline, whichever is the earlier one.
TEST_F(Commanded, IsTheEarlierContactWhereBothArePossible) {
  command(0.0, "/arm", trajectoryOf("to_middle", {{1.0, -1.0}}));
  EXPECT_NEAR(ahead(0.0, {-1.0, 0.0, 0.5}, {0.0, 0.2, 0.0}).time_to_contact, 0.78, 0.01);
  use(kSliders);
  command(0.0, "/arm", trajectoryOf("to_middle", {{1.0, -1.0}}));
  EXPECT_NEAR(ahead(0.0, {-1.0, 0.0, 0.5}, {0.0, 2.0, 0.0}).time_to_contact, 0.14, 1e-3);
}

// A joint that is off its trajectory leaves those of other controllers on theirs.
TEST_F(Commanded, OfOneControllerIsFollowedWhileAnotherIsOff) {
  command(0.0, "/arm", trajectoryOf("to_middle", kOvershoot));
  command(0.0, "/gripper", trajectoryOf("to_right", {{1.0, 0.8}}));
  Lookahead lookahead;
  for (double time = 0.0; time < 0.55; time += 0.1)
    lookahead =
        ahead(time, {-1.0, positionIn(kOvershoot, time), 0.5}, {0.0, velocityIn(kOvershoot, std::max(time, 1e-3))});
  EXPECT_EQ(lookahead.state, Lookahead::CONTACT);
  EXPECT_EQ(lookahead.status.message.find("along the trajectory of /arm, with a delay of "), 0U);
  EXPECT_NE(lookahead.status.message.find("off the trajectory of /gripper: velocities are taken"), std::string::npos);
}

// The controller holds the end of the trajectory before, and does so on if it refuses the next one. Once it follows this
// one, it follows the one after that, or goes on.
TEST_F(Commanded, IsFollowedFromItsFirstCycleAfterAnotherOne) {
  command(0.0, "/arm", trajectoryOf("to_middle", {{0.5, -0.1}}));
  ahead(0.0, {-1.0, 0.0, 0.5});
  for (const double time : {0.7, 0.8, 0.9}) EXPECT_EQ(ahead(time, {-1.0, -0.1, 0.5}).status.message, "");
  command(1.0, "/arm", trajectoryOf("to_middle", {{2.0, 0.1}}));
  const auto begins = [&](double time, const std::string& text) {
    const std::string message = ahead(time, {-1.0, -0.1 + 0.1 * (time - 1.0), 0.5}, {0.0, 0.1, 0.0}).status.message;
    EXPECT_EQ(message.find(text + ", with a delay of "), 0U) << time << ": " << message;
  };
  begins(1.0, "along the trajectory of /arm or with the velocities");
  for (const double time : {1.1, 1.2}) ahead(time, {-1.0, -0.1 + 0.1 * (time - 1.0), 0.5}, {0.0, 0.1, 0.0});
  begins(1.3, "along the trajectory of /arm");
  JointTrajectory with_stamp = trajectoryOf("to_middle", {{2.0, 0.1}});
  with_stamp.header.stamp = at(2.0);
  command(1.3, "/arm", with_stamp);
  begins(1.4, "along the trajectory of /arm or the one before it");
}

// Once it has ended, somebody else may move the robot.
TEST_F(Commanded, IsForgottenWhenTheRobotLeavesItsEnd) {
  command(0.0, "/arm", trajectoryOf("to_middle", {{0.5, -0.1}}));
  ahead(0.0, {-1.0, 0.0, 0.5});
  ahead(0.8, {-1.0, -0.1, 0.5});
  ahead(0.9, {-1.0, -0.2, 0.5});
  ahead(1.0, {-1.0, -0.1, 0.5});
  command(1.1, "/arm", trajectoryOf("to_middle", {{2.0, 0.1}}));
  EXPECT_EQ(ahead(1.1, {-1.0, -0.1, 0.5}).status.message,
            "along the trajectory of /arm or with the velocities, with a delay of 0 s");
}

// The middle sphere goes on towards the left one, although it was told to go back.
TEST_F(Commanded, CountsBesideTheNextOneThatTheControllerMayRefuse) {
  const auto cycle = [&](double time, double position, double velocity) {
    return ahead(time, {-1.0, position, 0.5}, {0.0, velocity, 0.0});
  };
  const auto begin = [&] {
    use(kSliders);
    command(0.0, "/arm", trajectoryOf("to_middle", {{2.0, -0.9}}));
    for (double time = 0.0; time < 0.395; time += 0.02) cycle(time, -0.45 * time, -0.45);
    command(0.4, "/arm", trajectoryOf("to_middle", {{1.0, 0.0}}));
  };
  begin();
  const Lookahead first = cycle(0.4, -0.18, -0.45);
  EXPECT_EQ(first.state, Lookahead::CONTACT);
  EXPECT_EQ(first.status.message.find("along the trajectory of /arm or the one before it, with"), 0U)
      << first.status.message;
  for (double time = 0.42; time < 1.0; time += 0.02)
    EXPECT_EQ(cycle(time, -0.45 * time, -0.45).state, Lookahead::CONTACT) << "refused, at " << time;
  begin();
  Lookahead last;
  for (double time = 0.4; time < 1.0; time += 0.02) last = cycle(time, -0.18 + 0.18 * (time - 0.4), 0.18);
  EXPECT_EQ(last.state, Lookahead::FREE) << "taken";
  EXPECT_EQ(last.status.message.find("along the trajectory of /arm, with a delay"), 0U) << last.status.message;
}

// It rests for a second before it goes on. A cancel may name another goal.
TEST_F(Commanded, CountsAfterACancelWhileTheRobotAgrees) {
  command(0.0, "/arm", trajectoryOf("to_middle", {{1.0, 0.0}, {2.0, -0.9}}));
  for (double time = 0.0; time < 0.395; time += 0.02) ahead(time, {-1.0, 0.0, 0.5});
  command(0.4, "/arm", JointTrajectory());
  for (double time = 0.4; time < 0.9; time += 0.02) {
    const Lookahead lookahead = ahead(time, {-1.0, 0.0, 0.5});
    EXPECT_EQ(lookahead.state, Lookahead::CONTACT) << time;
    const bool is_alone = lookahead.status.message.find("velocities") == std::string::npos;
    EXPECT_TRUE(time < 0.5 ? !is_alone : time < 0.61 || is_alone) << time << ": " << lookahead.status.message;
  }
}

// Each of three joints may follow the last of its commands, one of two before, or none: 64 ways and more.
TEST_F(Commanded, IsUnknownIfThereAreTooManyWaysToFollow) {
  const Three rest{-1.0, 0.0, 0.5};
  for (const double time : {0.0, 0.02, 0.04}) {
    ahead(time, rest);
    for (const auto& [name, position] : {std::pair{"to_left", -1.0}, {"to_middle", 0.0}, {"to_right", 0.5}})
      command(time, "/arm", trajectoryOf(name, {{1.0, position}}));
  }
  const Lookahead lookahead = ahead(0.06, rest);
  EXPECT_EQ(lookahead.state, Lookahead::UNKNOWN);
  EXPECT_EQ(lookahead.status.code, QueryStatus::OVER_BUDGET);
  EXPECT_EQ(lookahead.status.message.find("joints may follow their trajectories in more than 32 ways"), 0U)
      << lookahead.status.message;
  for (double time = 0.08; time < 0.5; time += 0.02) ahead(time, rest);
  EXPECT_EQ(ahead(0.5, rest).state, Lookahead::FREE);
}

// --- joints that turn

/// A bar of 1 m that turns about the origin, and a ball that stands beside its way.
const std::string kBar = robots::urdfOf(
    robots::link("base", robots::ball("0.1", "0 1 0")) + robots::link("bar", robots::ball("0.1", "1 0 0")) +
    robots::joint("turn", "revolute", "base", "bar", robots::axis("0 0 1") + robots::limits("-7", "7")));

class CommandedTurn : public Commanded {
 protected:
  void SetUp() override {
    Commanded::SetUp();
    config_.filter.only_pairs = {{"base", "bar"}};
    use(kBar);
  }
  Lookahead aheadAt(double time, double angle, std::optional<double> stated = std::nullopt) {
    PoseSnapshot poses;
    poses.stamp = at(time);
    poses.poses = scene::forwardKinematics(robot_->robotModel(), std::vector<double>{angle});
    poses.stated = {stated};
    VelocitySnapshot moving;
    moving.velocities = {0.0};
    moving.stamps = {poses.stamp};
    const CommandedMotion motion = commands_.lookUp(monitor_.joints(), poses, moving, at(time));
    return monitor_.cycle(poses, moving, settings_, {}, motion).lookahead;
  }
};

// At -4.5 rad the bar stands as at 1.78, and goes to -3 away from the ball, which is at 1.57 and at -4.71.
TEST_F(CommandedTurn, TakesTheTurnOfJointStates) {
  settings_.stop_distance = 0.001;
  command(0.0, "/arm", trajectoryOf("turn", {{1.0, -3.0}}));
  EXPECT_EQ(aheadAt(0.0, -4.5, -4.5).state, Lookahead::FREE);
  use(kBar);
  command(0.0, "/arm", trajectoryOf("turn", {{1.0, -3.0}}));
  EXPECT_EQ(aheadAt(0.0, -4.5).state, Lookahead::FREE) << "the turn nearest to the first point";
  use(kBar);
  command(0.0, "/arm", trajectoryOf("turn", {{1.0, -3.0}}));
  const double other = -4.5 + 2.0 * 3.14159265358979323846;
  EXPECT_EQ(aheadAt(0.0, other, other).state, Lookahead::CONTACT) << "the long way";
}

// --- several robots

TEST(CommandedRobots, NameTheirJointsAsTheModelOrAsTheirUrdf) {
  const std::string arm = robots::onRail({{"a", robots::ball("0.1")}, {"b", robots::ball("0.1", "3 0 0")}});
  XmlRpc::XmlRpcValue values;
  for (const std::string name : {"left", "right"}) {
    values["robots"][name]["description"] = "/" + name;
    values["robots"][name]["tf_prefix"] = name;
    values["robots"][name]["trajectories"][0] = "/" + name + "/command";
  }
  values["trajectories"][0] = "/command";
  const Config config = configFrom(values, "/node");
  const auto robot = std::make_shared<const Robot>(std::vector<RobotTexts>{{arm, ""}, {arm, ""}}, config);
  EXPECT_EQ(robot->sources()[1].trajectories, std::vector<std::string>{"/right/command"});
  EXPECT_EQ(config.trajectories, std::vector<std::string>{"/command"});
  CommandedTrajectories commands;
  PoseSnapshot poses;
  poses.stamp = at(0.0);
  poses.poses = scene::forwardKinematics(robot->robotModel(), std::vector<double>(4, 0.0));
  VelocitySnapshot moving;
  moving.velocities.assign(4, 0.0);
  moving.stamps.assign(4, poses.stamp);
  const auto followed = [&](const std::string& topic, const std::string& joint) {
    commands.follow(nullptr, {});
    commands.follow(robot, {{"/left/command", 0}, {"/right/command", 1}, {"/command", -1}});
    EXPECT_EQ(commands.take(topic, trajectoryOf(joint, {{1.0, 0.5}}), at(0.0)), "");
    const CommandedMotion motion = commands.lookUp({0, 1, 2, 3}, poses, moving, at(0.0));
    EXPECT_NE(motion.text.find("along the trajectory of " + topic), std::string::npos) << motion.text;
    return motion.followed.empty() ? std::string() : robot->robotModel().joints[motion.followed.back().joints[0]].name;
  };
  EXPECT_EQ(followed("/left/command", "to_a"), "left/to_a");
  EXPECT_EQ(followed("/right/command", "to_a"), "right/to_a");
  EXPECT_EQ(followed("/command", "right/to_b"), "right/to_b");
  EXPECT_EQ(commands.take("/command", trajectoryOf("to_a", {{1.0, 0.5}}), at(0.0)),
            "joint 'to_a' may be 'left/to_a' or 'right/to_a': name the topic in robots/right/trajectories");
}

TEST(CommandedParameters, AreChecked) {
  XmlRpc::XmlRpcValue values;
  values["trajectories"][0] = "/arm controller";
  EXPECT_EQ(scene::errorOf([&] { configFrom(values, "/node"); }),
            "parameter /node/trajectories has no name of a topic: '/arm controller'");
  Config config;
  config.tracking_error.of_joint["to_midle"] = 0.1;
  EXPECT_EQ(scene::errorOf([&] { Robot(kSliders, "", config); }),
            "parameter tracking_error/to_midle: the robot has no such movable joint: did you mean 'to_middle'?");
  config = Config();
  config.tracking_error.of_joint["to_middle"] = 0.1;
  EXPECT_EQ(Robot(kSliders, "", config).trackingErrors(), (std::vector<std::optional<double>>{0.01, 0.1, 0.01}));
}

// --- laws

/// Samples what controllers drive, by powers of the time as they compute it.
TEST_F(Commanded, NoMotionWithinTheTrackingErrorTouchesBeforeItIsSaidTo) {
  constexpr double kError = 0.01;
  config_.tracking_error = {kError, {}};
  use(kSliders);
  std::mt19937 random(17);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  int contacts = 0, free = 0;
  for (int i = 0; i < 400; ++i) {
    use(kSliders);
    const std::vector<double> home{-1.0, 0.0, 0.5};
    std::vector<std::vector<Knot>> knots(3);
    for (const int joint : {1, 2}) {
      double time = 0.0;
      for (int k = 0; k < 3; ++k)
        knots[joint].push_back({time += 0.45 + 0.3 * unit(random), home[joint] + 0.35 * unit(random), unit(random)});
      for (Knot& knot : knots[joint]) knot.time = std::round(1e3 * knot.time) * 1e-3;
    }
    command(0.0, "/arm", trajectoryOf("to_middle", knots[1]));
    command(0.0, "/gripper", trajectoryOf("to_right", knots[2]));
    const double velocity = 0.2 * unit(random);
    const Lookahead lookahead = ahead(0.0, {home[0], home[1], home[2]}, {velocity, 0.0, 0.0});
    contacts += lookahead.state == Lookahead::CONTACT;
    free += lookahead.state == Lookahead::FREE;
    ASSERT_FALSE(std::isnan(lookahead.time_free)) << lookahead.status.message;
    const auto placeAt = [&](int joint, double time) {
      std::vector<Knot> own = knots[joint];
      for (Knot& knot : own) knot.position -= home[joint];
      return home[joint] + positionIn(own, time);
    };
    for (double time = 0.0; time < lookahead.time_free; time += 1e-3) {
      const double left = home[0] + velocity * time, middle = placeAt(1, time), right = placeAt(2, time);
      const double nearest = std::min(
          {std::abs(middle - left) - kError, std::abs(right - left) - kError, std::abs(right - middle) - 2.0 * kError});
      ASSERT_GT(nearest, 0.2 + 0.02 - 1e-9) << i << " at " << time;
    }
    if (lookahead.state != Lookahead::CONTACT) continue;
    EXPECT_LT(lookahead.time_to_contact - lookahead.time_free, 0.7) << i;
  }
  EXPECT_GT(contacts, 50);
  EXPECT_GT(free, 50);
}

// The right joint, farther off, is the other controller's from now on.
TEST_F(Commanded, NamesAStrayJointOfThoseThatAreLeft) {
  JointTrajectory both = trajectoryOf("to_middle", {{1.0, -0.7}});
  both.joint_names.push_back("to_right");
  both.points[0].positions.push_back(0.5);
  command(0.0, "/arm", both);
  ahead(0.0, {-1.0, 0.0, 0.5});
  command(0.5, "/gripper", trajectoryOf("to_right", {{1.0, 1.6}}));
  const std::string message = ahead(0.5, {-1.0, 0.3, 1.5}).status.message;
  EXPECT_NE(message.find("joint 'to_middle' is "), std::string::npos) << message;
  EXPECT_EQ(message.find("'to_right' is "), std::string::npos) << message;
}

TEST_F(Commanded, ThreadsMayCommandAndLoadRobotsDuringCycles) {
  std::atomic<bool> goes_on{true};
  std::vector<std::thread> threads;
  for (const std::string topic : {"/arm", "/gripper"}) {
    threads.emplace_back([&, topic] {
      const JointTrajectory trajectories[] = {trajectoryOf("to_middle", kOvershoot), JointTrajectory(),
                                              trajectoryOf("to_right", {{1.0, 0.6}}), trajectoryOf("no", {{1.0, 0.6}})};
      for (int i = 0; goes_on; ++i) commands_.take(topic, trajectories[i % 4], at(0.0));
    });
  }
  threads.emplace_back([&] {
    for (const auto again = std::make_shared<const Robot>(kSliders, "", config_); goes_on;) {
      commands_.follow(again, {{"/arm", 0}});
      commands_.follow(robot_, {{"/arm", 0}, {"/gripper", 0}});
    }
  });
  int along = 0;
  // On a busy machine the other threads may begin late.
  for (int i = 0; i < 2000 || (along == 0 && i < 1'000'000); ++i)
    along += !ahead(0.0, {-1.0, 0.0, 0.5}).status.message.empty();
  goes_on = false;
  for (std::thread& thread : threads) thread.join();
  EXPECT_GT(along, 0);
}

}  // namespace proximity_server::node::commanded_trajectories_test
