// The line about the pair that sets the level.
#include "node/answers/clearance_text.h"
#include "node/monitor/slider_robot.h"
#include "robots/urdf.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace proximity_server::node::clearance_text_test {

/// Three spheres of radius 0.1 m on sliders: left at x = -1, middle at 0, right where the test wants it.
class ClearanceLine : public MonitorOfSliders {
 protected:
  void SetUp() override { follow(""); }

  /// The message of a cycle with the three at these positions [m], `time` [s] after the first one.
  std::string at(double time, double left, double middle, double right) {
    PoseSnapshot snapshot;
    snapshot.stamp = ros::Time(1000.0 + time);
    snapshot.poses = scene::forwardKinematics(robot_->robotModel(), std::vector<double>{left, middle, right});
    return monitor_.cycle(snapshot, {}, settings_).status.message;
  }
};

TEST_F(ClearanceLine, NamesThePairAndTheThresholdOfTheNextLevelOrItsOwn) {
  EXPECT_EQ(at(0.0, -1.0, 0.0, 0.5), "middle is 300.0 mm from right; warn below 50 mm");
  EXPECT_EQ(at(1.5, -1.0, 0.0, 0.24), "middle is 40.0 mm from right; warn below 50 mm");
  EXPECT_EQ(at(3.0, -1.0, 0.0, 0.2123), "middle is 12.3 mm from right; stop below 20 mm");
  EXPECT_EQ(at(4.5, -1.0, 0.0, 0.1958), "middle overlaps right by 4.2 mm");
}

TEST_F(ClearanceLine, NamesTheJointThatClosesTheGapAndHowFast) {
  at(0.0, -1.0, 0.0, 0.22);
  EXPECT_EQ(at(0.1, -1.0, 0.0, 0.212), "middle is 12.0 mm from right, closing 80 mm/s by to_right; stop below 20 mm");
  EXPECT_EQ(at(0.2, -1.0, 0.0, 0.213), "middle is 13.0 mm from right, opening 10 mm/s; stop below 20 mm");
  EXPECT_EQ(at(0.2, -1.0, 0.0, 0.213), "middle is 13.0 mm from right, opening 10 mm/s; stop below 20 mm")
      << "the same transforms once more";
  EXPECT_EQ(at(0.3, -1.0, 0.0, 0.213), "middle is 13.0 mm from right; stop below 20 mm");
}

TEST_F(ClearanceLine, NamesTwoJointsOnlyIfTheSecondIsHalfAsFast) {
  at(0.0, -1.0, 0.0, 0.23);
  EXPECT_EQ(at(0.1, -1.0, 0.006, 0.222),
            "middle is 16.0 mm from right, closing 140 mm/s by to_right and to_middle; stop below 20 mm");
  EXPECT_EQ(at(0.2, -1.0, 0.007, 0.219), "middle is 12.0 mm from right, closing 40 mm/s by to_right; stop below 20 mm");
}

TEST_F(ClearanceLine, TellsNoVelocityAcrossAPauseAndAfterTheClockJumpedBack) {
  at(10.0, -1.0, 0.0, 0.23);
  EXPECT_EQ(at(11.5, -1.0, 0.0, 0.22), "middle is 20.0 mm from right; stop below 20 mm");
  EXPECT_EQ(at(5.0, -1.0, 0.0, 0.215), "middle is 15.0 mm from right; stop below 20 mm");
}

// The level is that of tf, as joint_states do not place links.
TEST_F(ClearanceLine, NamesAJointBeyondItsLimits) {
  PoseSnapshot snapshot = withTheRightSphereAt(*robot_, 0.5);
  snapshot.beyond = JointBeyond{2, 300.0};
  const Clearance& clearance = monitor_.cycle(snapshot, {}, settings_);
  EXPECT_EQ(clearance.level, Clearance::CLEAR);
  EXPECT_EQ(
      clearance.status.message.find("middle is 300.0 mm from right; warn below 50 mm; joint 'to_right' is at 300 m "
                                    "in joint_states, beyond its limits of "),
      0u)
      << clearance.status.message;
}

TEST_F(ClearanceLine, HasTheGuaranteedDistanceIfThatDecides) {
  config_.uncertainty.joint = {0.0025};
  follow("");
  EXPECT_EQ(at(0.0, -1.0, 0.0, 0.24), "middle is 40.0 mm from right, guaranteed 35.0 mm; warn below 50 mm");
}

TEST(ClearanceLineOfAngles, TakesTheShortWayAcrossHalfATurn) {
  using namespace robots;
  const Robot robot(urdfOf(link("base") + link("arm") + hinge("hinge", "base", "arm", "0 0 1")), "", Config());
  ClearanceText text(robot.robotModel());
  text.move(scene::forwardKinematics(robot.robotModel(), std::vector<double>{3.1}), ros::Time(1.0));
  text.move(scene::forwardKinematics(robot.robotModel(), std::vector<double>{-3.1}), ros::Time(1.5));
  Clearance clearance;
  clearance.level = Clearance::COLLISION;
  clearance.deciding.a.link = "base";
  clearance.deciding.b.link = "arm";
  clearance.deciding.state = Proximity::TOUCHING;
  std::string written;
  text.write(written, clearance, {-0.5});
  EXPECT_EQ(written, "base touches arm, closing 83 mm/s by hinge") << "0.0832 rad in half a second";
}

}  // namespace proximity_server::node::clearance_text_test
