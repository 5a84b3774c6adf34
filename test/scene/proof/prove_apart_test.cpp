#include "proximity_server/scene/proof/prove_apart.h"

#include "laws/refusals.h"
#include "proximity_server/scene/loading/joined_robots.h"
#include "sanitized.h"
#include "scene/derivative/moved_robot.h"
#include "scene/posed_scene.h"
#include "scene/proof/random_boxes.h"
#include "scene/random_objects.h"
#include "scene/small_robots.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace proximity_server::scene::prove_apart_test {

/// A ball of radius 0.1 at 1 m from an axis, and a post of radius 0.2 at 1 m along x: they meet if the arm is within
/// 2 asin(0.15) of the x axis.
const std::string kSweeper =
    urdfOf(link("post", ball("0.2", "1 0 0")) + link("hub") + link("arm", ball("0.1", "1 0 0")) +
           weld("stands", "post", "hub") + joint("turn", "revolute", "hub", "arm", axis("0 0 1") + limits("-3", "3")));
const double kMeetingAngle = 2.0 * std::asin(0.15);

/// Two joints: an arm of two links in the plane, with a ball at its end, beside a wall.
const std::string kPlanarArm =
    urdfOf(link("wall", box("0.2 4 1", "1.6 0 0")) + link("upper", box("0.9 0.1 0.1", "0.5 0 0")) +
           link("fore", box("0.7 0.1 0.1", "0.45 0 0")) +
           joint("shoulder", "revolute", "wall", "upper", axis("0 0 1") + limits("-3.1", "3.1")) +
           joint("elbow", "revolute", "upper", "fore", origin("1 0 0") + axis("0 0 1") + limits("-2.5", "2.5")));

JointBox boxOf(const SceneModel& model, const std::vector<std::pair<double, double>>& intervals) {
  JointBox box = jointRanges(model.robot);
  for (std::size_t i = 0; i < intervals.size(); ++i) {
    box[i].lower = intervals[i].first;
    box[i].upper = intervals[i].second;
  }
  return box;
}

PairProof proofOf(const std::shared_ptr<const SceneModel>& model, const char* a, const char* b, const JointBox& box,
                  const ProofQuestion& question = {}) {
  return proveApart(model, {pairOf(*model, a, b)}, box, question).at(0);
}

TEST(ProveApart, ProvesUpToTheAngleAtWhichTheyMeet) {
  const auto model = modelOf(kSweeper);
  const PairProof proof = proofOf(model, "post", "arm", boxOf(*model, {{kMeetingAngle + 1e-3, 3.0}}));
  EXPECT_EQ(proof.outcome, ProofOutcome::Proven);
  EXPECT_GT(proof.lower_bound, 0.0);
  EXPECT_LE(proof.lower_bound, 2.0 * std::sin(0.5 * (kMeetingAngle + 1e-3)) - 0.3);
  EXPECT_EQ(proof.undecided, 0.0);
  EXPECT_TRUE(proof.worst.empty());
}

TEST(ProveApart, RefutesWithAStateOfTheBox) {
  const auto model = modelOf(kSweeper);
  const JointBox box = boxOf(*model, {{kMeetingAngle - 1e-3, 3.0}});
  const PairProof proof = proofOf(model, "arm", "post", box);
  ASSERT_EQ(proof.outcome, ProofOutcome::Refuted);
  ASSERT_EQ(proof.closest.size(), 1U);
  EXPECT_GE(proof.closest[0], box[0].lower);
  EXPECT_LE(proof.closest[0], kMeetingAngle);
  EXPECT_LE(proof.closest_upper_bound, 0.0);
}

TEST(ProveApart, TheContactDistanceIsAskedFor) {
  const auto model = modelOf(kSweeper);
  const JointBox box = boxOf(*model, {{1.0, 2.0}});
  const double smallest = 2.0 * std::sin(0.5) - 0.3;
  ProofQuestion question;
  question.contact_distance = smallest - 1e-6;
  EXPECT_EQ(proofOf(model, "post", "arm", box, question).outcome, ProofOutcome::Proven);
  question.contact_distance = smallest + 1e-6;
  EXPECT_EQ(proofOf(model, "post", "arm", box, question).outcome, ProofOutcome::Refuted);
}

TEST(ProveApart, TightBoundsComeNearToTheSmallestDistance) {
  const auto model = modelOf(kSweeper);
  const JointBox box = boxOf(*model, {{1.0, 2.0}});
  const double smallest = 2.0 * std::sin(0.5) - 0.3;
  ProofQuestion question;
  question.tightness = 0.99;
  const PairProof proof = proofOf(model, "post", "arm", box, question);
  EXPECT_EQ(proof.outcome, ProofOutcome::Proven);
  EXPECT_LE(proof.lower_bound, smallest);
  EXPECT_GE(proof.lower_bound, 0.99 * smallest);
}

TEST(ProveApart, WhatTheBudgetLeavesIsUndecided) {
  const auto model = modelOf(kPlanarArm);
  ProofQuestion question;
  question.most_boxes = 9;
  const JointBox box = boxOf(*model, {{0.8, 3.0}, {-0.5, 0.5}});
  const PairProof proof = proofOf(model, "wall", "fore", box, question);
  EXPECT_EQ(proof.outcome, ProofOutcome::Undecided);
  EXPECT_EQ(proof.boxes, 9);
  EXPECT_GT(proof.undecided, 0.0);
  EXPECT_LT(proof.undecided, 1.0);
  EXPECT_LE(proof.lower_bound, 0.0);
  ASSERT_EQ(proof.worst.size(), 2U);
  for (int i = 0; i < 2; ++i) {
    EXPECT_GE(proof.worst[i].lower, box[i].lower);
    EXPECT_LE(proof.worst[i].upper, box[i].upper);
    EXPECT_LT(proof.worst[i].lower, proof.worst[i].upper);
  }
}

TEST(ProveApart, ADeadlineThatHasPassedLeavesAllBoxes) {
  const auto model = modelOf(kPlanarArm);
  const std::atomic<bool> stop{true};
  for (const Deadline& passed : {Deadline(std::chrono::steady_clock::time_point::min()), Deadline(stop)}) {
    ProofQuestion question;
    question.deadline = passed;
    const PairProof proof = proofOf(model, "wall", "fore", boxOf(*model, {{0.8, 3.0}, {-0.5, 0.5}}), question);
    EXPECT_EQ(proof.outcome, ProofOutcome::Undecided);
    EXPECT_EQ(proof.boxes, 0);
    EXPECT_EQ(proof.undecided, 1.0);
    EXPECT_EQ(proof.lower_bound, -std::numeric_limits<double>::infinity());
    EXPECT_TRUE(proof.closest.empty());
  }
}

TEST(ProveApart, FixedJointsMakeAStateOfABox) {
  const auto model = modelOf(kPlanarArm);
  PosedScene scene(model);
  const ShapeRefPair pair = pairOf(*model, "wall", "fore");
  const PairProof proof = proofOf(model, "wall", "fore", boxOf(*model, {{2.0, 2.0}, {0.5, 0.5}}));
  EXPECT_EQ(proof.outcome, ProofOutcome::Proven);
  EXPECT_EQ(proof.boxes, 1);
  EXPECT_NEAR(proof.lower_bound, distanceIn(scene, {2.0, 0.5}, pair), 1e-8);
}

TEST(ProveApart, OnlyJointsBetweenTheTwoNeedAnInterval) {
  const auto model = modelOf(kPlanarArm);
  const ShapeRefPair pair = pairOf(*model, "upper", "fore");
  EXPECT_EQ(proveApart(model, {pair}, {{1, -1.0, 1.0}}).at(0).outcome, ProofOutcome::Proven);
  EXPECT_THROW(proveApart(model, {pair}, {{0, -1.0, 1.0}}), std::invalid_argument);
}

// --- refusals

void expectRefused(const std::shared_ptr<const SceneModel>& model, const ShapeRefPair& pair, const JointBox& box,
                   const ProofQuestion& question, const std::string& reason) {
  EXPECT_TRUE(isRefused([&] { proveApart(model, {pair}, box, question); }, reason));
}

TEST(ProveApart, JointsWithoutAPositionAreRefusedIfTheyAreBetween) {
  const auto model =
      modelOf(urdfOf(link("floor", ball("0.1")) + link("cart", ball("0.1", "1 0 0")) +
                     link("lift", ball("0.1", "3 0 0")) + joint("drive", "planar", "floor", "cart", axis("0 0 1")) +
                     joint("up", "prismatic", "cart", "lift", axis("0 0 1") + limits("0", "1"))));
  const JointBox box = jointRanges(model->robot);
  expectRefused(model, pairOf(*model, "floor", "lift"), box, {}, "joint \"drive\", between floor - lift, is planar");
  EXPECT_EQ(proofOf(model, "cart", "lift", box).outcome, ProofOutcome::Proven);
}

TEST(ProveApart, WrongQuestionsAreRefused) {
  const auto model = modelOf(kSweeper);
  const ShapeRefPair pair = pairOf(*model, "post", "arm");
  const JointBox box = jointRanges(model->robot);
  expectRefused(model, pair, {{0, 1.0, -1.0}}, {}, "joint \"turn\", between post - arm, has no finite interval");
  expectRefused(model, pair, {{0, 1.0, INFINITY}}, {}, "no finite interval");
  expectRefused(model, pair, {}, {}, "joint \"turn\", between post - arm, has no interval");
  expectRefused(model, {ShapeRef(7), ShapeRef(0)}, box, {}, "does not exist");
  const auto with = [](const auto& set) {
    ProofQuestion question;
    set(question);
    return question;
  };
  expectRefused(model, pair, box, with([](auto& it) { it.contact_distance = -1e-3; }), "contact distance");
  expectRefused(model, pair, box, with([](auto& it) { it.tightness = 1.0; }), "tightness");
  expectRefused(model, pair, box, with([](auto& it) { it.most_boxes = 0; }), "at least one box");
  const auto other = modelOf(kSweeper);
  expectRefused(model, pair, box, with([&](auto& it) { it.objects = std::make_shared<const Objects>(other); }),
                "another model");
  const auto two = modelOf(joined({{"left", robotOf(kSweeper)}, {"right", robotOf(kSweeper)}}));
  expectRefused(two, pairOf(*two, "left/post", "left/arm"), jointRanges(two->robot), {}, "several robots");
}

// --- laws

constexpr double kRounding = 1e-12;  // [m] of the kinematics and of the distance in a state

TEST(ProveApart, NoStateOfABoxIsCloserThanItsBound) {
  Chance chance(39);
  int outcomes[3] = {0, 0, 0}, near_bound = 0, states = 0;
  for (int i = 0; i < repeats(120); ++i) {
    const auto model = someRobot(chance);
    PosedScene scene(model);
    const JointBox box = someBox(model->robot, chance);
    ProofQuestion question;
    question.most_boxes = chance.below(3) == 0 ? 60 : 7;
    question.contact_distance = chance.below(2) == 0 ? 0.0 : chance.between(0.0, 0.05);
    question.tightness = chance.below(2) == 0 ? 0.0 : 0.5;
    const std::vector<ShapeRefPair> pairs = provablePairs(*model);
    for (const PairProof& proof : proveApart(model, pairs, box, question)) {
      ++outcomes[static_cast<int>(proof.outcome)];
      if (proof.outcome == ProofOutcome::Proven) {
        ASSERT_GT(proof.lower_bound, question.contact_distance);
      }
      double closest = distanceIn(scene, proof.closest, proof.pair);
      EXPECT_LE(closest, proof.closest_upper_bound + 1e-9);
      if (proof.outcome == ProofOutcome::Refuted) {
        EXPECT_LE(closest, question.contact_distance + 1e-9);
      }
      for (int s = 0; s < 40; ++s, ++states)
        closest = std::min(closest, distanceIn(scene, someStateIn(model->robot, box, chance), proof.pair));
      ASSERT_GE(closest, proof.lower_bound - kRounding)
          << i << ": " << nameOf(proof.pair.a, model->robot) << " - " << nameOf(proof.pair.b, model->robot);
      near_bound += closest < proof.lower_bound + 0.02;
    }
  }
  RecordProperty("states", states);
  if (kIsSanitized) return;
  EXPECT_GT(outcomes[0], 300) << "proven";
  EXPECT_GT(outcomes[1], 100) << "refuted";
  EXPECT_GT(outcomes[2], 20) << "undecided";
  EXPECT_GT(near_bound, 100);
}

TEST(ProveApart, NoStateIsCloserToAnObjectThanTheBound) {
  Chance chance(40);
  int proven = 0, refuted = 0, states = 0;
  for (int i = 0; i < repeats(40); ++i) {
    const auto model = arm();
    const auto objects = std::make_shared<const Objects>(
        Objects(model).changed({AddObject{someObject("crate", Fixed{chance.pose(0.8)}, chance)},
                                AddObject{someObject("dish", Moving{"fore", chance.pose(0.3)}, chance)},
                                AddObject{someObject("tool", Attached{"hand", {}, chance.pose(0.2)}, chance)}}));
    PosedScene scene(model);
    scene.use(objects);
    const JointBox box = someBox(model->robot, chance);
    ProofQuestion question;
    question.most_boxes = 100;
    question.objects = objects;
    for (const PairProof& proof : proveApart(model, checkedPairs(*model, objects.get()), box, question)) {
      proven += proof.outcome == ProofOutcome::Proven;
      refuted += proof.outcome == ProofOutcome::Refuted;
      EXPECT_LE(distanceIn(scene, proof.closest, proof.pair), proof.closest_upper_bound + 1e-9);
      for (int s = 0; s < 20; ++s, ++states)
        ASSERT_GE(distanceIn(scene, someStateIn(model->robot, box, chance), proof.pair), proof.lower_bound - kRounding)
            << i << ": " << nameOf(proof.pair.a, model->robot, objects.get()) << " - "
            << nameOf(proof.pair.b, model->robot, objects.get());
    }
  }
  RecordProperty("states", states);
  if (kIsSanitized) return;
  EXPECT_GT(proven, 150);
  EXPECT_GT(refuted, 60);
}

/// A proven share is not larger than the true one, which a grid counts, and the share in contact is not either.
TEST(ProveApart, SharesOfTwoJointsBracketTheTrueOnes) {
  const auto model = modelOf(kPlanarArm);
  const ShapeRefPair pair = pairOf(*model, "wall", "fore");
  const JointBox box = jointRanges(model->robot);
  constexpr int kSteps = 200;
  PosedScene scene(model);
  int in_contact = 0;
  for (int i = 0; i < kSteps * kSteps; ++i) {
    const auto at = [](const JointRange& range, int step) {
      return range.lower + (step + 0.5) / kSteps * range.width();
    };
    in_contact += distanceIn(scene, {at(box[0], i / kSteps), at(box[1], i % kSteps)}, pair) <= 0.0;
  }
  const double true_share = static_cast<double>(in_contact) / (kSteps * kSteps);
  constexpr double kOfGrid =
      0.005;  // the border crosses less than 4 * kSteps cells, and about half of each is on a side
  ProofQuestion question;
  question.goal = ProofQuestion::Goal::Shares;
  double undecided = 1.0;
  for (const long boxes : {100L, 1000L, repeats(30) > 1 ? 10000L : 2000L}) {
    question.most_boxes = boxes;
    const PairProof proof = proveApart(model, {pair}, box, question).at(0);
    EXPECT_EQ(proof.outcome, ProofOutcome::Refuted);
    EXPECT_LE(proof.in_contact, true_share + kOfGrid);
    EXPECT_LE(1.0 - proof.in_contact - proof.undecided, 1.0 - true_share + kOfGrid);
    EXPECT_LT(proof.undecided, 0.6 * undecided) << boxes;
    undecided = proof.undecided;
  }
}

TEST(ProveApart, TheUndecidedShareShrinksWithTheBudget) {
  Chance chance(41);
  int shrunk = 0;
  for (int i = 0; i < repeats(60); ++i) {
    const auto model = someRobot(chance);
    const std::vector<ShapeRefPair> pairs = provablePairs(*model);
    const JointBox box = someBox(model->robot, chance);
    std::vector<PairProof> before;
    for (const long boxes : {3L, 9L, 27L}) {
      ProofQuestion question;
      question.most_boxes = boxes;
      const std::vector<PairProof> now = proveApart(model, pairs, box, question);
      for (std::size_t k = 0; k < before.size(); ++k) {
        if (now[k].outcome == ProofOutcome::Refuted) continue;
        EXPECT_LE(now[k].undecided, before[k].undecided);
        EXPECT_GE(now[k].lower_bound, std::min(before[k].lower_bound, 0.0));
        shrunk += now[k].undecided < before[k].undecided;
      }
      before = now;
    }
  }
  if (!kIsSanitized) {
    EXPECT_GT(shrunk, 10);
  }
}

TEST(ProveApart, TheResultIsTheSameForAnyNumberOfThreads) {
  Chance chance(42);
  const auto model = someRobot(chance);
  const std::vector<ShapeRefPair> pairs = provablePairs(*model);
  ASSERT_GT(pairs.size(), 3U);
  const JointBox box = someBox(model->robot, chance);
  ProofQuestion question;
  question.most_boxes = 300;
  const std::vector<PairProof> one = proveApart(model, pairs, box, question);
  double last = 0.0;
  question.progress = [&](double share) {
    EXPECT_GE(share, last);
    last = share;
  };
  question.threads = 3;
  const std::vector<PairProof> three = proveApart(model, pairs, box, question);
  EXPECT_GT(last, 0.0);
  EXPECT_LE(last, 1.0);
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    EXPECT_EQ(one[i].outcome, three[i].outcome);
    EXPECT_EQ(one[i].lower_bound, three[i].lower_bound);
    EXPECT_EQ(one[i].closest, three[i].closest);
    EXPECT_EQ(one[i].boxes, three[i].boxes);
  }
}

}  // namespace proximity_server::scene::prove_apart_test
