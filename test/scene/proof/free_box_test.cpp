#include "proximity_server/scene/proof/free_box.h"

#include "proximity_server/scene/model/names.h"
#include "sanitized.h"
#include "scene/posed_scene.h"
#include "scene/random_objects.h"
#include "scene/small_robots.h"

#include <gtest/gtest.h>

#include <map>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

namespace proximity_server::scene::free_box_test {

/// A ball at 2 + slide and 0.3 * lift beside a wall whose face is at 2.5: they touch at slide = 0.4.
const std::string kSled =
    urdfOf(link("wall", box("1 9 9", "3 0 0")) + link("rail") + link("sled", ball("0.1")) +
           joint("lift", "prismatic", "wall", "rail", axis("0 0 1") + limits("-1", "0.25")) +
           joint("slide", "prismatic", "rail", "sled", origin("2 0 0") + axis("1 0 0") + limits("-9", "9")));

FreeBox boxOf(double slide, const std::map<std::string, double>& weights, const FreeBoxQuestion& question = {}) {
  const auto model = modelOf(kSled);
  return freeBox(model, {pairOf(*model, "wall", "sled")}, byJoint(model->robot, {{"slide", slide}}),
                 byJoint(model->robot, weights), question);
}

const JointRange& of(const char* joint, const FreeBox& free) {
  return *intervalOf(free.box, findNamed(robotOf(kSled).joints, joint));
}

TEST(FreeBox, ReachesAlmostToContact) {
  FreeBoxQuestion question;
  question.most_scale = 3.0;
  const FreeBox free = boxOf(-0.6, {{"lift", 1.0}, {"slide", 2.0}}, question);
  EXPECT_LT(free.scale, 0.5);
  EXPECT_GT(free.scale, 0.5 * 0.98);
  ASSERT_EQ(free.box.size(), 2U);
  EXPECT_EQ(of("lift", free).lower, -free.scale);
  EXPECT_EQ(of("lift", free).upper, 0.25) << "the limit";
  EXPECT_EQ(of("slide", free).lower, -0.6 - 2.0 * free.scale);
  EXPECT_EQ(of("slide", free).upper, -0.6 + 2.0 * free.scale);
  ASSERT_EQ(free.obstacles.size(), 1U);
  EXPECT_EQ(free.obstacles[0].outcome, ProofOutcome::Refuted);
}

TEST(FreeBox, TheLargestScaleIsAsked) {
  const FreeBox free = boxOf(-0.6, {{"lift", 1.0}, {"slide", 0.9}});
  EXPECT_EQ(free.scale, 1.0);
  EXPECT_TRUE(free.obstacles.empty());
}

TEST(FreeBox, AWeightOfZeroFixesAJoint) {
  const FreeBox free = boxOf(0.3, {{"lift", 1.0}});
  EXPECT_EQ(free.scale, 1.0);
  EXPECT_EQ(of("slide", free).lower, 0.3);
  EXPECT_EQ(of("slide", free).upper, 0.3);
}

TEST(FreeBox, AStateInContactHasNone) {
  const FreeBox free = boxOf(0.5, {{"slide", 1.0}});
  EXPECT_EQ(free.scale, -1.0);
  EXPECT_TRUE(free.box.empty());
  EXPECT_EQ(free.obstacles.size(), 1U);
}

TEST(FreeBox, WrongQuestionsAreRefused) {
  FreeBoxQuestion question;
  question.most_scale = 0.0;
  EXPECT_THROW(boxOf(0.0, {{"slide", 1.0}}, question), std::invalid_argument);
  question = {};
  question.accuracy = 1.0;
  EXPECT_THROW(boxOf(0.0, {{"slide", 1.0}}, question), std::invalid_argument);
  const auto model = modelOf(kSled);
  EXPECT_THROW(freeBox(model, {pairOf(*model, "wall", "sled")}, {0.0, 0.0}, {1.0}), std::invalid_argument);
  EXPECT_THROW(boxOf(0.0, {{"slide", -1.0}}), std::invalid_argument);
}

TEST(FreeBox, NoStateOfItIsInContact) {
  Chance chance(44);
  const auto model = arm();
  PosedScene scene(model);
  const std::vector<JointRange> ranges = jointRanges(model->robot);
  std::mt19937_64 random(45);
  int boxes = 0;
  double largest = 0.0;
  for (int i = 0; i < repeats(40); ++i) {
    const Positions state = randomPositions(model->robot, ranges, random);
    const FreeBox free =
        freeBox(model, scene.candidates().list(), state, std::vector<double>(model->robot.joints.size(), 1.0));
    if (free.box.empty()) continue;
    ++boxes;
    largest = std::max(largest, free.scale);
    for (int s = 0; s < 50; ++s) {
      Positions within = state;
      for (const JointRange& interval : free.box)
        within[interval.joint] = chance.below(2) == 0 ? interval.upper : chance.between(interval.lower, interval.upper);
      scene.update(forwardKinematics(model->robot, within));
      EXPECT_GT(scene.minimum(scene.candidates())->result.upper_bound, 0.0);
    }
  }
  if (kIsSanitized) return;
  EXPECT_GT(boxes, 10);
  EXPECT_GT(largest, 0.1);
}

}  // namespace proximity_server::scene::free_box_test
