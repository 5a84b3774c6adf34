#include "scene/certificate/axis_heights.h"

#include "proximity_server/narrowphase/shape/support.h"
#include "proximity_server/scene/model/kinematics.h"
#include "proximity_server/scene/model/names.h"
#include "sanitized.h"
#include "scene/derivative/moved_robot.h"
#include "scene/proof/random_boxes.h"
#include "scene/random_objects.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace proximity_server::scene::axis_heights_test {

using Eigen::Isometry3d;
using Eigen::Vector3d;
using narrowphase::Shape;
using narrowphase::Sphere;

// --- on paper: a ball of radius 0.1 at 1 m from the axis of a joint

const std::string kTurning = urdfOf(link("base", ball("0.2")) + link("arm", ball("0.1", "1 0 0")) +
                                    joint("turn", "revolute", "base", "arm", axis("0 0 1") + limits("-3", "3")));

double highestOfBall(const std::string& urdf, const JointRange& interval, const Vector3d& direction) {
  const RobotModel robot = robotOf(urdf);
  return AxisHeights(robot, {interval}, 0, 1, direction).highest(Sphere{0.1}, at(1, 0, 0), 1.0);
}

TEST(AxisHeights, ATurnIsHighestAtAnEndIfTheAxisIsNotWithin) {
  EXPECT_NEAR(highestOfBall(kTurning, {0, -0.1, 0.3}, Vector3d::UnitY()), std::sin(0.3) + 0.1, 1e-12);
  EXPECT_NEAR(highestOfBall(kTurning, {0, -0.1, 0.3}, -Vector3d::UnitY()), std::sin(0.1) + 0.1, 1e-12);
  EXPECT_NEAR(highestOfBall(kTurning, {0, 0.3, 0.3}, Vector3d::UnitX()), std::cos(0.3) + 0.1, 1e-12);
  EXPECT_NEAR(highestOfBall(kTurning, {0, -2.0, 3.0}, Vector3d::UnitZ()), 0.1, 1e-12);
}

TEST(AxisHeights, ATurnThroughTheAxisIsHighestWhereTangentsMeet) {
  EXPECT_NEAR(highestOfBall(kTurning, {0, -0.3, 0.3}, Vector3d::UnitX()), 1.0 / std::cos(0.3) + 0.1, 1e-12);
  for (const double half : {0.7, 1.5, 2.0, 3.0, 3.2, 10.0}) {
    const double highest = highestOfBall(kTurning, {0, -half, half}, Vector3d::UnitX());
    EXPECT_GE(highest, 1.1) << half;
    EXPECT_LE(highest, 1.0 / std::cos(0.6) + 0.1 + 1e-12) << half;
  }
}

TEST(AxisHeights, ASlideIsHighestAtAnEnd) {
  const std::string urdf = urdfOf(link("base", ball("0.2")) + link("arm", ball("0.1", "1 0 0")) +
                                  joint("slide", "prismatic", "base", "arm", axis("0 1 0") + limits("-1", "1")));
  EXPECT_NEAR(highestOfBall(urdf, {0, -0.5, 0.25}, Vector3d::UnitY()), 0.35, 1e-12);
  EXPECT_NEAR(highestOfBall(urdf, {0, -0.5, 0.25}, -Vector3d::UnitY()), 0.6, 1e-12);
  EXPECT_NEAR(highestOfBall(urdf, {0, -0.5, 0.25}, Vector3d::UnitX()), 1.1, 1e-12);
}

TEST(AxisHeights, AFollowerHasTheIntervalOfItsLeader) {
  const std::string urdf =
      urdfOf(link("base", ball("0.2")) + link("arm", ball("0.1", "1 0 0")) + link("other") +
             joint("turn", "revolute", "base", "arm",
                   axis("0 0 1") + limits("-3", "3") + "<mimic joint='leader' multiplier='-2' offset='0.1'/>") +
             joint("leader", "revolute", "base", "other", axis("0 0 1") + limits("-3", "3")));
  const RobotModel robot = robotOf(urdf);
  const int leader = findNamed(robot.joints, "leader");
  const auto highest = [&](const Vector3d& direction) {
    return AxisHeights(robot, {{leader, -0.1, 0.3}}, 0, bodyOf(robot, "arm"), direction)
        .highest(Sphere{0.1}, at(1, 0, 0), 1.0);
  };
  EXPECT_NEAR(highest(Vector3d::UnitY()), std::sin(0.3) + 0.1, 1e-12);   // 0.1 + 2 * 0.1
  EXPECT_NEAR(highest(-Vector3d::UnitY()), std::sin(0.5) + 0.1, 1e-12);  // 0.1 - 2 * 0.3
}

TEST(AxisHeights, NumbersThatAreNoneOrOverflowBoundNothing) {
  EXPECT_EQ(highestOfBall(kTurning, {0, 0.0, 1.0}, Vector3d(NAN, 0, 0)), std::numeric_limits<double>::infinity());
  EXPECT_EQ(highestOfBall(kTurning, {0, -1e300, 1e300}, Vector3d::UnitY()), std::numeric_limits<double>::infinity());
}

// --- laws

struct Case {
  std::shared_ptr<const SceneModel> model;
  int from, to;
};

/// Two bodies with joints of one position between them.
Case someCase(Chance& chance) {
  for (;;) {
    const auto model = chance.below(3) == 0 ? arm() : someRobot(chance);
    const auto links = static_cast<int>(model->robot.links.size());
    const ShapeRefPair pair{chance.below(links), chance.below(links)};
    if (pair.a != pair.b && hasOnePositionEach(model->robot, pair))
      return {model, model->robot.links[pair.a.link()].body, model->robot.links[pair.b.link()].body};
  }
}

/// The height of the highest point of a shape in one state.
double heightIn(const Case& it, const Positions& positions, const Vector3d& direction, const Shape& shape,
                const Isometry3d& body_T_shape) {
  const BodyPoses poses = forwardKinematics(it.model->robot, positions);
  const Isometry3d from_T_shape = poses[it.from]->inverse() * *poses[it.to] * body_T_shape;
  int vertex = 0;
  const Vector3d point = supportPoint(shape, from_T_shape.linear().transpose() * direction, vertex);
  return direction.dot(from_T_shape * point) + shape.margin();
}

TEST(AxisHeights, NoStateIsHigher) {
  Chance chance(43);
  int near = 0;
  for (int i = 0; i < repeats(3000); ++i) {
    const Case it = someCase(chance);
    const JointBox box = someBox(it.model->robot, chance);
    const Vector3d direction = chance.direction();
    const Shape shape = someShape(chance).padded(chance.below(2) == 0 ? 0.0 : 0.02);
    const Isometry3d body_T_shape = chance.pose(0.3);
    const double reach = body_T_shape.translation().norm() + shape.coreReach();
    const double highest =
        AxisHeights(it.model->robot, box, it.from, it.to, direction).highest(shape, body_T_shape, reach);
    double sampled = -std::numeric_limits<double>::infinity();
    for (int s = 0; s < 60; ++s)
      sampled =
          std::max(sampled, heightIn(it, someStateIn(it.model->robot, box, chance), direction, shape, body_T_shape));
    ASSERT_LE(sampled, highest + 1e-13) << i;
    near += sampled > highest - 0.01;
  }
  if (!kIsSanitized) {
    EXPECT_GT(near, 1000);
  }
}

/// A bound that is off by a share of the size of the box would be so for small boxes, too.
TEST(AxisHeights, SmallBoxesAreBoundedToSecondOrder) {
  Chance chance(44);
  for (int i = 0; i < repeats(300); ++i) {
    const Case it = someCase(chance);
    constexpr double kHalf = 1e-3;
    JointBox box = someBox(it.model->robot, chance);
    bool has_followers = false;
    for (const Joint& joint : it.model->robot.joints) has_followers |= joint.mimic.has_value();
    if (has_followers) continue;  // they have intervals of their own
    for (JointRange& interval : box) interval = {interval.joint, interval.lower, interval.lower + 2.0 * kHalf};
    const Vector3d direction = chance.direction();
    const double highest =
        AxisHeights(it.model->robot, box, it.from, it.to, direction).highest(Sphere{0.1}, at(0.1, 0, 0), 0.1);
    double corner = -std::numeric_limits<double>::infinity();
    for (int c = 0; c < 1 << box.size(); ++c) {
      Positions positions(it.model->robot.joints.size(), 0.0);
      for (std::size_t k = 0; k < box.size(); ++k)
        positions[box[k].joint] = (c >> k & 1) != 0 ? box[k].upper : box[k].lower;
      corner = std::max(corner, heightIn(it, positions, direction, Sphere{0.1}, at(0.1, 0, 0)));
    }
    EXPECT_LE(highest - corner, 30.0 * kHalf * kHalf) << i;
  }
}

TEST(AxisHeights, ManyWideJointsAreBounded) {
  std::string parts = link("0", ball("0.1"));
  for (int i = 1; i <= 14; ++i)
    parts += link(std::to_string(i), ball("0.1")) +
             joint("j" + std::to_string(i), "revolute", std::to_string(i - 1), std::to_string(i),
                   origin("0.1 0 0") + axis(i % 2 == 0 ? "0 1 0" : "0 0 1") + limits("-3", "3"));
  const Case it{modelOf(urdfOf(parts)), 0, 14};
  const JointBox box = jointRanges(it.model->robot);
  const double highest =
      AxisHeights(it.model->robot, box, 0, 14, Vector3d::UnitX()).highest(Sphere{0.1}, at(0, 0, 0), 0.0);
  EXPECT_GE(highest, 1.5);  // all straight
  EXPECT_LE(highest, 30.0);
}

}  // namespace proximity_server::scene::axis_heights_test
