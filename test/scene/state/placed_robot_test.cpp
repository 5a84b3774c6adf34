#include "scene/state/placed_robot.h"

#include "scene/model/body_pose.h"
#include "scene/small_robots.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace proximity_server::scene::placed_robot_test {

using namespace narrowphase;

using Eigen::AngleAxisd;
using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;

/// Floating links in poses.
struct Placed {
  explicit Placed(const std::vector<std::string>& links) : model(floatingLinks(links)) {}

  void update(const std::vector<Isometry3d>& poses) {
    BodyPoses usable = posesOf(model, poses);
    for (auto& pose : usable) pose = usablePose(pose);
    robot.update(usable, {});
  }
  int link(const char* name) const { return model.findLink(name); }  // also the number of its part

  // Questions about two parts, which are links here.
  double sphereGap(int p, int q, const RelativePose& p_T_q) const {
    return scene::sphereGap(robot[p].whole().bounds, robot[q].whole().bounds, p_T_q);
  }
  double boxGap(int p, int q, const RelativePose& p_T_q) const {
    return scene::boxGap(robot[p].whole().bounds, robot[q].whole().bounds, p_T_q);
  }
  bool boxesPay(int p, int q) const { return PlacedRobot::boxesPay(robot[p].whole(), robot[q].whole()); }
  RelativeMotionBound relativeMotion(int p, int q, const RelativePose& before, const RelativePose& now) const {
    return PlacedRobot::relativeMotion(robot[p], robot[q], before, now);
  }
  SignedDistance distance(int p, int q, const RelativePose& p_T_q, const Options& options = {}) {
    return PlacedRobot::distanceInBodyA({robot[p], p}, {robot[q], q}, p_T_q, options, warm_starts.of(p, q));
  }

  const RobotModel model;
  PlacedRobot robot{model, std::make_shared<const Volumes>(model)};
  const int a = link("0"), b = link("1");
  WarmStarts warm_starts{64};
};

RelativePose relativePose(const Isometry3d& pose) { return {pose.linear(), pose.translation()}; }

// --- relative poses

// a looks along y; b stands 2 before it and is turned back.
TEST(RelativePoseOfPlacedRobot, IsThatOfBInTheFrameOfA) {
  Placed placed({ball("1"), ball("1")});
  placed.update({turned(M_PI / 2, Vector3d::UnitZ(), {1, 2, 3}), at(1, 4, 3)});
  const RelativePose a_T_b = placed.robot.relative(placed.a, placed.b);
  EXPECT_LE((a_T_b.translation - Vector3d(2, 0, 0)).norm(), 1e-14);
  EXPECT_LE((a_T_b.rotation - AngleAxisd(-M_PI / 2, Vector3d::UnitZ()).toRotationMatrix()).norm(), 1e-14);
}

TEST(RelativePoseOfPlacedRobot, IsTheIdentityWithinABody) {
  Placed placed({ball("1") + ball("1", "3 0 0"), ball("1")});
  placed.update({turned(1.0, {1, 2, 3}, {1e6, 0, 0}), at(0, 0, 0)});
  const int first = placed.robot.numberOf({placed.a, 1}), second = placed.robot.numberOf({placed.a, 2});
  const RelativePose relative = placed.robot.relative(first, second);
  EXPECT_EQ(relative.rotation, Matrix3d::Identity());
  EXPECT_EQ(relative.translation, Vector3d::Zero());
}

// --- known and unknown poses

TEST(PlacedRobot, PlacesNothingBeforeItsFirstPoses) {
  const Placed placed({ball("1"), ball("1")});
  EXPECT_FALSE(placed.robot.isPlaced(placed.a));
}

TEST(PlacedRobot, PlacesOnlyLinksWithGeometryAtAUsablePose) {
  Placed placed({ball("1"), ball("1"), ball("1")});
  Isometry3d broken = Isometry3d::Identity();
  broken.linear()(0, 0) = std::numeric_limits<double>::quiet_NaN();
  placed.update({at(0, 0, 0), broken, at(3, 0, 0)});
  EXPECT_TRUE(placed.robot.isPlaced(placed.a));
  EXPECT_FALSE(placed.robot.isPlaced(placed.b));
  EXPECT_TRUE(placed.robot.isPlaced(placed.link("2")));
  EXPECT_FALSE(placed.robot.isPlaced(placed.link("frame")));
  placed.update({at(0, 0, 0), at(1, 0, 0), at(3, 0, 0)});
  EXPECT_TRUE(placed.robot.isPlaced(placed.b));
}

// --- lower bounds

// The centres of the balls are at (0, 0, 1) and (3, 4, 1), also seen from a, which is turned.
TEST(SphereGapOfPlacedRobot, IsTheDistanceOfTheSpheresInAnyFrame) {
  Placed placed({ball("1", "0 0 1"), ball("2", "-1 0 0")});
  placed.update({turned(1.0, Vector3d::UnitZ()), turned(M_PI / 2, Vector3d::UnitZ(), {3, 5, 1})});
  EXPECT_NEAR(placed.robot.sphereGap(placed.a, placed.b), 2.0, 1e-12);
  EXPECT_NEAR(placed.robot.sphereGap(placed.b, placed.a), 2.0, 1e-12);
  const RelativePose a_T_b = placed.robot.relative(placed.a, placed.b);
  EXPECT_NEAR(placed.sphereGap(placed.a, placed.b, a_T_b), 2.0, 1e-12);
}

TEST(AreFarInPlacedRobot, ComparesTheSphereGapWithALimitOfEitherSign) {
  Placed placed({ball("1"), ball("2")});
  placed.update({at(0, 0, 0), at(3, 4, 0)});  // a gap of 2
  EXPECT_TRUE(placed.robot.areFar(placed.a, placed.b, 2.0 - 1e-9));
  EXPECT_FALSE(placed.robot.areFar(placed.a, placed.b, 2.0 + 1e-9));
  EXPECT_TRUE(placed.robot.areFar(placed.a, placed.b, -4.0)) << "no balls overlap by more than the sum of their radii";
  EXPECT_FALSE(placed.robot.areFar(placed.a, placed.b, std::numeric_limits<double>::infinity()));
}

TEST(AreFarInPlacedRobot, IsFalseWithoutAPose) {
  Placed placed({ball("1"), ball("2")});
  EXPECT_FALSE(placed.robot.areFar(placed.a, placed.b, 0.0));
}

TEST(SphereGapOfPlacedRobot, IsTheSameFarFromTheFrameOfThePoses) {
  Placed placed({ball("1"), ball("2")});
  placed.update({at(1e9, 0, -1e9), at(1e9 + 5, 0, -1e9)});
  EXPECT_NEAR(placed.robot.sphereGap(placed.a, placed.b), 2.0, 1e-12);
}

// A cube of edge 2 at (0, 3, 0) of a, which is turned by a quarter: it stands at (-3, 0, 0). b's reaches x = 0.5.
TEST(BoxGapOfPlacedRobot, IsTheDistanceOfTheBoxes) {
  Placed placed({box("2 2 2", "0 3 0"), box("1 1 1", "0 0 1")});
  placed.update({turned(M_PI / 2, Vector3d::UnitZ()), at(1, 0, 0)});
  const RelativePose a_T_b = placed.robot.relative(placed.a, placed.b);
  EXPECT_NEAR(placed.boxGap(placed.a, placed.b, a_T_b), 2.5, 1e-12);
}

// The cube is slanted within b, so that an edge looks at a's face.
TEST(BoxGapOfPlacedRobot, TurnsTheAxesOfB) {
  Placed placed({box("2 2 2"), box("2 2 2", "0 0 0", "0 0 0.5")});
  placed.update({at(0, 0, 0), turned(M_PI / 4 - 0.5, Vector3d::UnitZ(), {4, 0, 0})});
  const RelativePose a_T_b = placed.robot.relative(placed.a, placed.b);
  EXPECT_NEAR(placed.boxGap(placed.a, placed.b, a_T_b), 3.0 - std::sqrt(2.0), 1e-12);
}

TEST(PlacedRobot, HasABoxAroundTheSphereOfALink) {
  Placed placed({ball("1"), ball("0.5", "2 0 0")});
  placed.update({at(1, 1, 1), turned(M_PI / 2, Vector3d::UnitZ(), {5, 1, 1})});  // the ball is at (5, 3, 1)
  const Eigen::AlignedBox3d a = placed.robot.boxAround(placed.a), b = placed.robot.boxAround(placed.b);
  EXPECT_LE((b.sizes() - Vector3d(1, 1, 1)).norm(), 1e-12);
  EXPECT_LE((b.center() - a.center() - Vector3d(4, 2, 0)).norm(), 1e-12);
}

TEST(PlacedRobot, ComputesNoBoxesForTwoClosedForms) {
  const Placed placed({ball("1"), ball("1"), box("1 1 1")});
  EXPECT_FALSE(placed.boxesPay(placed.a, placed.b));
  EXPECT_TRUE(placed.boxesPay(placed.a, placed.link("2")));
  EXPECT_TRUE(placed.boxesPay(placed.link("2"), placed.b));
}

// --- motion

TEST(MotionBoundOfPlacedRobot, IsZeroForEqualPoses) {
  const Placed placed({box("1 2 3"), box("3 2 1")});
  const RelativePose pose = relativePose(turned(0.3, {1, 2, 3}, {4, 5, 6}));
  const RelativeMotionBound motion = placed.relativeMotion(placed.a, placed.b, pose, pose);
  EXPECT_EQ(motion.distance_change, 0.0);
  EXPECT_TRUE(motion.is_rest);
}

TEST(MotionBoundOfPlacedRobot, IsTheLengthOfAShift) {
  const Placed placed({box("1 2 3"), box("3 2 1")});
  const RelativeMotionBound motion =
      placed.relativeMotion(placed.a, placed.b, relativePose(at(9, 0, 0)), relativePose(at(9, 0.3, -0.4)));
  EXPECT_NEAR(motion.distance_change, 0.5, 1e-12);
  EXPECT_GT(motion.distance_change, 0.5) << "rounding";
  EXPECT_FALSE(motion.is_rest);
}

// The sphere of a box of 2 x 4 x 4 has a radius of 3. Turned by 60 degrees, its points move by at most 2 sin 30 = 1
// times that, while a, seen from b, moves by 20.
TEST(MotionBoundOfPlacedRobot, OfATurnAboutTheCentreIsTheChordAtTheRadius) {
  const Placed placed({box("1 1 1"), box("2 4 4")});
  const Isometry3d before = at(20, 0, 0), now = before * turned(M_PI / 3, {0, 1, 2});
  const RelativeMotionBound motion = placed.relativeMotion(placed.a, placed.b, relativePose(before), relativePose(now));
  EXPECT_NEAR(motion.distance_change, 3.0, 1e-12);
}

// b goes round a: seen from b, a turns about its centre. Its radius is 3, too.
TEST(MotionBoundOfPlacedRobot, OfATurnAboutTheOtherOneIsTheChordAtThatOnesRadius) {
  const Placed placed({box("2 4 4"), box("1 1 1")});
  const Isometry3d before = at(20, 0, 0), now = turned(M_PI / 3, {0, 0, 1}) * before;
  const RelativeMotionBound motion = placed.relativeMotion(placed.a, placed.b, relativePose(before), relativePose(now));
  EXPECT_NEAR(motion.distance_change, 3.0, 1e-12);
}

// The centre of the ball, at (2, 0, 0) of b, goes along the chord of a quarter.
TEST(MotionBoundOfPlacedRobot, CountsFromTheCentreOfTheSphere) {
  const Placed placed({ball("10"), ball("1", "2 0 0")});
  const Isometry3d now = turned(M_PI / 2, Vector3d::UnitZ());
  const RelativeMotionBound motion =
      placed.relativeMotion(placed.a, placed.b, relativePose(Isometry3d::Identity()), relativePose(now));
  EXPECT_NEAR(motion.distance_change, std::sqrt(2.0) * (2.0 + 1.0), 1e-12);
}

// Regression: seen from b, a ball of 1 mm that b goes round turns about its centre, and its points move by less than
// the rounding. But the point on b, which is kept in the frame of a, was 2e-9 m off its shape.
TEST(MotionBoundOfPlacedRobot, OfWhatGoesRoundASmallBallIsNoRest) {
  const Placed placed({ball("0.001"), ball("1")});
  const Isometry3d before = at(100, 0, 0), now = turned(2e-11, {0, 0, 1}) * before;
  const RelativeMotionBound motion = placed.relativeMotion(placed.a, placed.b, relativePose(before), relativePose(now));
  EXPECT_LT(motion.distance_change, 1e-11);
  EXPECT_FALSE(motion.is_rest);
}

TEST(MotionBoundOfPlacedRobot, OfNoMoreThanRoundingIsRest) {
  const Placed placed({ball("1"), ball("1")});
  const auto shiftedBy = [&](double shift) {
    return placed.relativeMotion(placed.a, placed.b, relativePose(at(8, 0, 0)), relativePose(at(8 + shift, 0, 0)));
  };
  const double rounding = kPoseRounding * (8.0 + 1.0 + 1.0);
  EXPECT_TRUE(shiftedBy(0.9 * rounding).is_rest);
  EXPECT_FALSE(shiftedBy(1.1 * rounding).is_rest);
  EXPECT_GT(shiftedBy(0.9 * rounding).distance_change, rounding);
}

TEST(MotionBoundOfPlacedRobot, IsNeverBelowTheChangeOfTheDistance) {
  Placed placed({box("0.5 1 2", "0.3 0 0", "0.1 0.2 0.3"), cylinder("0.4", "1.5", "0 0.5 0")});
  Chance chance(31);
  int close = 0;
  for (int i = 0; i < 1000; ++i) {
    const Isometry3d before = chance.pose(2.5),
                     step = turned(chance.between(0, 0.2), chance.direction(), 0.2 * chance.direction());
    const RelativePose first = relativePose(before), second = relativePose(step * before);
    const double change =
        placed.distance(placed.a, placed.b, second).distance - placed.distance(placed.a, placed.b, first).distance;
    const double bound = placed.relativeMotion(placed.a, placed.b, first, second).distance_change;
    EXPECT_LE(std::abs(change), bound + 2e-9);
    close += std::abs(change) > 0.5 * bound;
  }
  EXPECT_GT(close, 50);
}

// --- distances

// In the frame of a: a face of the cube at x = 1, the ball at (5, 0.5, 0.25) with radius 1, whose near point is at
// x = 4.
TEST(DistanceOfPlacedRobot, IsThatOnPaperInTheFrameOfA) {
  Placed placed({box("2 2 2"), ball("1", "0 0 0.25")});
  placed.update({turned(M_PI / 2, Vector3d::UnitZ(), {0, 0, 7}), turned(2.0, Vector3d::UnitZ(), {-0.5, 5, 7})});
  const RelativePose a_T_b = placed.robot.relative(placed.a, placed.b);
  const SignedDistance result = placed.distance(placed.a, placed.b, a_T_b);
  EXPECT_EQ(result.status, Status::Converged);
  EXPECT_NEAR(result.distance, 3.0, 1e-12);
  EXPECT_LE((result.normal - Vector3d(1, 0, 0)).norm(), 1e-12);
  EXPECT_LE((result.point_a - Vector3d(1, 0.5, 0.25)).norm(), 1e-12);
  EXPECT_LE((result.point_b - Vector3d(4, 0.5, 0.25)).norm(), 1e-12);

  // In the frame of the poses a's x axis is y, and its y axis is -x.
  const SignedDistance seen = placed.robot.inPosesFrame(placed.a, result);
  EXPECT_EQ(seen.distance, result.distance);
  EXPECT_LE((seen.normal - Vector3d(0, 1, 0)).norm(), 1e-12);
  EXPECT_LE((seen.point_a - Vector3d(-0.5, 1, 7.25)).norm(), 1e-12);
  EXPECT_LE((seen.point_b - Vector3d(-0.5, 4, 7.25)).norm(), 1e-12);
}

// The piece stands within its body: turned by a quarter, so that its long half, 2, is along y.
TEST(DistanceOfPlacedRobot, CountsThePosesOfThePiecesInTheirBodies) {
  Placed placed({box("4 2 2", "1 0 0", "0 0 1.5707963267948966"), box("4 2 2", "0 1 0", "0 0 1.5707963267948966")});
  placed.update({at(0, 0, 0), at(1, 7, 0)});
  const SignedDistance result = placed.distance(placed.a, placed.b, placed.robot.relative(placed.a, placed.b));
  EXPECT_NEAR(result.distance, 8.0 - 2.0 - 2.0, 1e-12);
  EXPECT_LE((result.normal - Vector3d(0, 1, 0)).norm(), 1e-12);
}

// Two balls that reach 1 and 2 from the origins of their bodies, which are 5 apart.
TEST(DistanceOfPlacedRobot, HasBoundsThatAllowForTheRoundingOfThePoses) {
  Placed placed({ball("1"), ball("2")});
  const SignedDistance result = placed.distance(placed.a, placed.b, relativePose(at(0, 5, 0)));
  const double rounding = kPoseRounding * (5.0 + 1.0 + 2.0);
  EXPECT_LE(result.lower_bound, 2.0 - 0.9 * rounding);
  EXPECT_GE(result.lower_bound, 2.0 - 2.0 * rounding);
  EXPECT_GE(result.upper_bound, 2.0 + 0.9 * rounding);
  EXPECT_LE(result.upper_bound, 2.0 + 2.0 * rounding);
}

TEST(DistanceOfPlacedRobot, HasNotConvergedWithinAToleranceBelowTheRoundingOfThePoses) {
  Placed placed({ball("1"), ball("2")});
  Options options;
  options.distance_tolerance = kPoseRounding * (5.0 + 1.0 + 2.0);  // the bounds are twice as far apart
  EXPECT_EQ(placed.distance(placed.a, placed.b, relativePose(at(0, 5, 0)), options).status, Status::Degenerate);
  options.distance_tolerance *= 5.0;
  EXPECT_EQ(placed.distance(placed.a, placed.b, relativePose(at(0, 5, 0)), options).status, Status::Converged);
}

// A face before a cylinder, 3 away. Its bounds are off by the rounding: a threshold between them and the distance is
// not decided.
TEST(DistanceOfPlacedRobot, DecidesNoThresholdWithinTheRoundingOfThePoses) {
  Placed placed({box("2 2 2"), cylinder("1", "2")});
  const double rounding = kPoseRounding * (5.0 + std::sqrt(3.0) + std::sqrt(2.0));
  int decided = 0;
  for (int i = -400; i <= 400; ++i) {
    const double threshold = 3.0 + 0.05 * i * rounding;
    const SignedDistance result =
        placed.distance(placed.a, placed.b, relativePose(at(5, 0, 0)), Options::above(threshold));
    if (result.status != Status::Threshold) continue;
    EXPECT_TRUE(result.lower_bound > threshold || result.upper_bound <= threshold) << i;
    ++decided;
  }
  EXPECT_GT(decided, 100);
}

TEST(LowerBoundsOfPlacedRobot, AreNeverAboveTheDistance) {
  const std::vector<std::string> links{box("0.5 1 2", "0.3 0 0", "0.1 0.2 0.3"), cylinder("0.4", "1.5", "0 0.5 0"),
                                       ball("0.6", "0 0 0.2"), box("1 0.1 1", "0.2 0.1 0")};
  Placed placed(links);
  Chance chance(41);
  int apart = 0;
  for (int i = 0; i < 300; ++i) {
    placed.update({chance.pose(2.0), chance.pose(2.0), chance.pose(2.0), chance.pose(2.0)});
    for (const char* name_a : {"0", "1", "2", "3"}) {
      for (const char* name_b : {"0", "1", "2", "3"}) {
        const int a = placed.link(name_a), b = placed.link(name_b);
        if (a == b) continue;
        const RelativePose a_T_b = placed.robot.relative(a, b);
        const SignedDistance result = placed.distance(a, b, a_T_b);
        EXPECT_LE(placed.robot.sphereGap(a, b), result.upper_bound);
        EXPECT_LE(placed.sphereGap(a, b, a_T_b), result.upper_bound);
        EXPECT_LE(placed.boxGap(a, b, a_T_b), result.upper_bound);
        apart += result.distance > 0.0;
      }
    }
  }
  EXPECT_GT(apart, 1000);
}

}  // namespace proximity_server::scene::placed_robot_test
