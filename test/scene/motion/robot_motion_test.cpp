#include "proximity_server/scene/motion/robot_motion.h"

#include "scene/files.h"
#include "scene/small_robots.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace proximity_server::scene::robot_motion_test {

using Eigen::Isometry3d;
using Eigen::Vector3d;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

// An arm that "turn" turns about z through (1, 0, 0), a slider that "slide" moves along the x axis of the arm's end at
// (2, 0, 0), which looks along y; a follower that turns about z by 2 turn + 0.5, and a link that floats.
const std::string kMachine =
    urdfOf(link("base") + link("arm") + link("slider") + link("follower") + link("kite") +
           hinge("turn", "base", "arm", "0 0 1", "1 0 0") +
           joint("slide", "prismatic", "arm", "slider",
                 origin("2 0 0", "0 0 1.5707963267948966") + axis("1 0 0") + limits("-9", "9")) +
           joint("follow", "continuous", "base", "follower",
                 axis("0 0 1") + "<mimic joint='turn' multiplier='2' offset='0.5'/>") +
           joint("float", "floating", "base", "kite"));

class JointMotion : public testing::Test {
 protected:
  std::vector<double> byJoint(const std::map<std::string, double>& named) const {
    return scene::byJoint(robot_, named);
  }
  int body(const char* link) const { return bodyOf(robot_, link); }
  BodyPoses start() const { return forwardKinematics(robot_, byJoint({})); }

  const RobotModel robot_ = robotOf(kMachine);
};

void expectPose(const std::optional<Isometry3d>& pose, const Isometry3d& expected) {
  ASSERT_TRUE(pose.has_value());
  EXPECT_LE((pose->matrix() - expected.matrix()).norm(), 1e-12) << pose->matrix();
}

TEST_F(JointMotion, TurnsAboutTheAxisOfARevoluteJoint) {
  const RobotMotion motion = RobotMotion::ofTravel(robot_, start(), byJoint({{"turn", M_PI}}));
  expectPose(motion.at(0.0)[body("arm")], at(1, 0, 0));
  expectPose(motion.at(0.5)[body("arm")], turned(M_PI / 2, Vector3d::UnitZ(), {1, 0, 0}));
  // The slider is carried: 2 before the arm, and turned by a quarter more.
  expectPose(motion.at(0.5)[body("slider")], turned(M_PI, Vector3d::UnitZ(), {1, 2, 0}));
}

// Its axis is the arm's y axis.
TEST_F(JointMotion, SlidesAlongTheAxisOfAPrismaticJoint) {
  const RobotMotion motion = RobotMotion::ofTravel(robot_, start(), byJoint({{"slide", 4.0}}));
  expectPose(motion.at(0.25)[body("slider")], turned(M_PI / 2, Vector3d::UnitZ(), {3, 1, 0}));
  expectPose(motion.at(0.25)[body("arm")], at(1, 0, 0));
}

TEST_F(JointMotion, AFollowerGoesByItsMultipleWhateverItsOwnTravelIs) {
  const RobotMotion motion = RobotMotion::ofTravel(robot_, start(), byJoint({{"turn", 1.0}, {"follow", 77.0}}));
  expectPose(motion.at(0.0)[body("follower")], turned(0.5, Vector3d::UnitZ()));
  expectPose(motion.at(0.5)[body("follower")], turned(0.5 + 1.0, Vector3d::UnitZ()));
}

TEST_F(JointMotion, AFloatingJointRests) {
  BodyPoses poses = start();
  poses[body("kite")] = at(7, 8, 9);
  const RobotMotion motion = RobotMotion::ofTravel(robot_, poses, byJoint({{"float", 1.0}}));
  expectPose(motion.at(1.0)[body("kite")], at(7, 8, 9));
}

TEST_F(JointMotion, BeginsAtThePosesThatAreGiven) {
  BodyPoses poses = start();
  for (auto& pose : poses) pose = turned(M_PI / 2, Vector3d::UnitX(), {0, 0, 5}) * *pose;
  const RobotMotion motion = RobotMotion::ofTravel(robot_, poses, byJoint({{"turn", M_PI}}));
  expectPose(motion.at(0.5)[body("arm")],
             turned(M_PI / 2, Vector3d::UnitX(), {0, 0, 5}) * turned(M_PI / 2, Vector3d::UnitZ(), {1, 0, 0}));
}

TEST_F(JointMotion, ABodyWithoutAPoseHasNoneLaterNorHasWhatItCarries) {
  BodyPoses poses = start();
  poses[body("arm")].reset();
  const BodyPoses later = RobotMotion::ofTravel(robot_, poses, byJoint({{"turn", 1.0}})).at(0.5);
  EXPECT_FALSE(later[body("arm")].has_value());
  EXPECT_FALSE(later[body("slider")].has_value());
  EXPECT_TRUE(later[body("follower")].has_value());
}

TEST_F(JointMotion, BetweenTwoStatesIsLinear) {
  const RobotMotion motion =
      RobotMotion::between(robot_, byJoint({{"turn", -1.0}, {"slide", 1.0}}), byJoint({{"turn", 2.0}, {"slide", 5.0}}));
  for (const double time : {0.0, 0.3, 1.0}) {
    const BodyPoses expected =
        forwardKinematics(robot_, byJoint({{"turn", -1.0 + 3.0 * time}, {"slide", 1.0 + 4.0 * time}}));
    const BodyPoses poses = motion.at(time);
    for (std::size_t i = 0; i < poses.size(); ++i) expectPose(poses[i], *expected[i]);
  }
}

TEST_F(JointMotion, RefusesNumbersThatDoNotFitTheRobot) {
  EXPECT_EQ(errorOf([&] { RobotMotion::ofTravel(robot_, BodyPoses(2), byJoint({})); }),
            "the robot has 5 bodies, but there are 2 poses");
  EXPECT_EQ(errorOf([&] { RobotMotion::ofTravel(robot_, start(), std::vector<double>(3)); }),
            "the robot has 4 movable joints, but there are 3 travels");
  EXPECT_EQ(errorOf([&] { RobotMotion::between(robot_, byJoint({}), std::vector<double>(5)); }),
            "the robot has 4 movable joints, but there are 5 positions to go to");
}

TEST_F(JointMotion, RefusesATravelThatIsNotFiniteNamingTheJoint) {
  EXPECT_EQ(errorOf([&] {
              RobotMotion::ofTravel(robot_, start(), byJoint({{"slide", kNaN}}));
            }),
            "the travel of joint slide is not finite");
  EXPECT_EQ(errorOf([&] { RobotMotion::ofTravel(robot_, start(), byJoint({{"follow", kNaN}})); }), "");
}

// --- twists

// The origin moves along x at first, and the body turns about z by half a turn: a half circle of length 1 about
// (0, 1 / pi, 0), whose middle is as high as its radius is.
TEST(TwistMotion, MovesAlongAScrewInTheFrameOfThePoses) {
  const RobotMotion motion =
      RobotMotion::ofTwists({Isometry3d::Identity(), at(5, 0, 0)}, {{{1, 0, 0}, {0, 0, M_PI}}, {{0, 0, 2}, {0, 0, 0}}});
  expectPose(motion.at(0.5)[0], turned(M_PI / 2, Vector3d::UnitZ(), {1 / M_PI, 1 / M_PI, 0}));
  expectPose(motion.at(1.0)[0], turned(M_PI, Vector3d::UnitZ(), {0, 2 / M_PI, 0}));
  expectPose(motion.at(0.5)[1], at(5, 0, 1));
}

TEST(TwistMotion, OfABodyWithoutAPoseIsUnknown) {
  const RobotMotion motion = RobotMotion::ofTwists({std::nullopt, at(5, 0, 0)}, {{}, {}});
  EXPECT_FALSE(motion.at(0.0)[0].has_value());
  EXPECT_TRUE(motion.at(0.0)[1].has_value());
}

TEST(TwistMotion, RefusesTwistsThatAreNotFiniteOrTooFew) {
  EXPECT_EQ(errorOf([] { RobotMotion::ofTwists(BodyPoses(1), {{{0, kNaN, 0}, {0, 0, 0}}}); }), "twist 0 is not finite");
  EXPECT_EQ(errorOf([] { RobotMotion::ofTwists(BodyPoses(2), {{}}); }),
            "the robot has 2 poses, but there are 1 twists");
}

TEST_F(JointMotion, PosesAreThoseOfPositionsByName) {
  expectPose(*forwardKinematics(robot_, {{"turn", M_PI}})[body("slider")],
             *forwardKinematics(robot_, byJoint({{"turn", M_PI}}))[body("slider")]);
  expectPose(*forwardKinematics(robot_, {})[body("slider")], *forwardKinematics(robot_, byJoint({}))[body("slider")]);
  EXPECT_EQ(errorOf([&] {
              forwardKinematics(robot_, {{"turm", 1.0}});
            }),
            "no movable joint \"turm\" (did you mean \"turn\"?)");
}

}  // namespace proximity_server::scene::robot_motion_test
