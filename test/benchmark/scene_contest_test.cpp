// ./dev bench scene relies on this: motions that are what they say, and a peer that is asked the same as we are.
#include "benchmark/agreement.h"
#include "benchmark/motions.h"
#include "benchmark/timing.h"
#include "peers/fcl_scene.h"
#include "peers/robots.h"
#include "proximity_server/scene/model/kinematics.h"
#include "sanitized.h"
#include "tools/second_opinion/fcl_shape.h"

#include <gtest/gtest.h>

#include <cmath>

namespace proximity_server::benchmark::scene_contest_test {

using namespace narrowphase;
using namespace scene;
using namespace peers;
using tools::fclShape;

using Eigen::Isometry3d;

constexpr int kStates = kIsSanitized ? 5 : 50;
constexpr double kFclError = 3e-2;  // [m]; FCL stalls now and then: by 2e-2 at worst in 100,000 distances of the demo

const NamedRobot& demo() {
  static const NamedRobot robot = demoRobot();
  return robot;
}

/// Returns the pose of a body in its parent.
Isometry3d acrossJoint(const Body& body, const BodyPoses& poses, const RobotModel& robot) {
  const auto index = static_cast<std::size_t>(&body - robot.bodies.data());
  return poses[body.parent]->inverse() * *poses[index];
}

TEST(CoherentMotion, StepsOfAMillisecondTurnNoJointFasterThanARadianPerSecond) {
  const RobotModel& robot = demo().model->robot;
  const std::vector<BodyPoses> states = coherentMotion(robot, kStates);
  double fastest = 0.0;
  for (std::size_t i = 1; i < states.size(); ++i)
    for (const Body& body : robot.bodies) {
      if (body.joint < 0) continue;
      const Isometry3d step = acrossJoint(body, states[i - 1], robot).inverse() * acrossJoint(body, states[i], robot);
      const double angle = Eigen::AngleAxisd(step.linear()).angle();
      EXPECT_LE(angle, 1e-3 + 1e-9);
      fastest = std::max(fastest, angle);
    }
  EXPECT_GT(fastest, 0.9e-3);
}

TEST(CoherentMotion, IsSlowerWhereTheJointIs) {
  RobotModel robot = rowsOfArms(2).model->robot;
  for (Joint& joint : robot.joints) joint.max_velocity = 0.25;
  const std::vector<BodyPoses> states = coherentMotion(robot, kStates);
  for (std::size_t i = 1; i < states.size(); ++i) {
    const Isometry3d step = states[i - 1][1]->inverse() * *states[i][1];
    EXPECT_LE(Eigen::AngleAxisd(step.linear()).angle(), 0.25e-3 + 1e-9);
  }
}

TEST(RandomStates, AreTheSameOnEveryRunAndDifferFromEachOther) {
  const RobotModel& robot = demo().model->robot;
  const std::vector<BodyPoses> states = randomStates(robot, 2), again = randomStates(robot, 2);
  EXPECT_TRUE(states[1].back()->isApprox(*again[1].back()));
  EXPECT_FALSE(states[0].back()->isApprox(*states[1].back(), 1e-3));
}

TEST(RowsOfArms, HaveAsManyBodiesAsAskedAndCheckAllButNeighbours) {
  const std::pair<int, int> bodies_and_neighbours[] = {{2, 0}, {5, 3}, {12, 9}};  // arms: 1+1, 4+1, 5+5+2
  for (const auto& [bodies, neighbours] : bodies_and_neighbours) {
    const NamedRobot arms = rowsOfArms(bodies);
    EXPECT_EQ(arms.model->robot.bodies.size(), static_cast<std::size_t>(bodies) + 1);  // and the world
    EXPECT_EQ(arms.model->pairs.checked.size(), static_cast<std::size_t>(bodies * (bodies - 1) / 2 - neighbours));
  }
}

class FclMethods : public testing::TestWithParam<FclScene::Method> {};

TEST_P(FclMethods, AnswersEveryQuestionAsOursDoes) {
  FclScene fcl(*demo().model, GetParam());
  OurScene ours(demo().model, Skipping::On);
  for (const SceneQuestion question : {SceneQuestion::Minimum, SceneQuestion::Below, SceneQuestion::All}) {
    Agreement agreement(*demo().model, question);
    for (const BodyPoses& poses : randomStates(demo().model->robot, kStates)) {
      fcl.ask(poses, question);
      ours.ask(poses, question);
      agreement.compare(poses, ours.pairs(), fcl.pairs());
    }
    const nlohmann::json summary = agreement.summary();
    if (!kIsSanitized) {
      EXPECT_GT(summary["compared"], question == SceneQuestion::All ? 100 * kStates : kStates / 3);
    }
    EXPECT_LT(summary["max_error"], kFclError) << summary;
    EXPECT_EQ(summary["ours_right"], summary["judged"]) << summary;
    EXPECT_EQ(summary["overlaps_claimed"], 0);
    EXPECT_EQ(summary["unanswered"], 0);
  }
}

TEST_P(FclMethods, FindAFirstContactWhereTheMinimumIsAnOverlap) {
  FclScene fcl(*demo().model, GetParam());
  OurScene ours(demo().model, Skipping::On), minimum(demo().model, Skipping::On);
  int overlaps = 0;
  for (const BodyPoses& poses : randomStates(demo().model->robot, kStates)) {
    fcl.ask(poses, SceneQuestion::Contact);
    ours.ask(poses, SceneQuestion::Contact);
    minimum.ask(poses, SceneQuestion::Minimum);
    const bool is_overlap = minimum.pairs().front().distance <= 0.0;
    EXPECT_EQ(fcl.pairs().size(), is_overlap ? 1u : 0u);
    ASSERT_EQ(ours.pairs().size(), is_overlap ? 1u : 0u);
    if (!is_overlap) continue;
    EXPECT_LE(ours.pairs().front().distance, 0.0);
    ++overlaps;
  }
  if (!kIsSanitized) {
    EXPECT_GT(overlaps, kStates / 10);
  }
  EXPECT_LT(overlaps, kStates);
}

INSTANTIATE_TEST_SUITE_P(Methods, FclMethods,
                         testing::Values(FclScene::Method::Triangles, FclScene::Method::HullsLibccd,
                                         FclScene::Method::HullsIndep));

TEST(FclScene, CountsThePairsWhoseBoxesAreNear) {
  const NamedRobot arms = rowsOfArms(10);
  FclScene fcl(*arms.model, FclScene::Method::HullsLibccd);
  fcl.ask(randomStates(arms.model->robot, 1).front(), SceneQuestion::Minimum);
  EXPECT_EQ(fcl.pairsWithBoxesWithin(-1.0), 0);
  EXPECT_EQ(fcl.pairsWithBoxesWithin(100.0), static_cast<int>(arms.model->pairs.checked.size()));
  EXPECT_GE(fcl.pairsWithBoxesWithin(fcl.pairs().front().distance), 1);
}

TEST(FclShape, NamesWhatFclHasNoShapeFor) {
  EXPECT_NO_THROW(fclShape(Sphere{0.1}));
  EXPECT_THROW(fclShape(Shape(Box{{1, 1, 1}}).padded(0.1)), std::invalid_argument);
  EXPECT_THROW(fclShape(ConvexHull({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}})), std::invalid_argument);
}

TEST(Agreement, SaysWhoIsRightWhereTwoAnswersDiffer) {
  const NamedRobot arms = rowsOfArms(10);
  OurScene ours(arms.model, Skipping::On);
  const BodyPoses poses = coherentMotion(arms.model->robot, 1).front();
  ours.ask(poses, SceneQuestion::Minimum);
  ASSERT_GT(ours.pairs().front().distance, 0.001);
  std::vector<PairDistance> wrong = ours.pairs();
  wrong.front().distance += 0.001;

  Agreement agreement(*arms.model, SceneQuestion::Minimum);
  agreement.compare(poses, ours.pairs(), wrong);
  const nlohmann::json summary = agreement.summary();
  EXPECT_EQ(summary["differing"], 1);
  EXPECT_EQ(summary["ours_right"], 1);
  EXPECT_EQ(summary["other_right"], 0);
  EXPECT_NEAR(summary["max_error"], 0.001, 1e-12);
}

TEST(Quantile, IsTheValueThatSoManyDoNotExceed) {
  EXPECT_EQ(quantile({3.0, 1.0, 2.0}, 0.5), 2.0);
  EXPECT_EQ(quantile({3.0, 1.0, 2.0}, 1.0), 3.0);
  EXPECT_EQ(quantile({4.0}, 0.99), 4.0);
}

}  // namespace proximity_server::benchmark::scene_contest_test
