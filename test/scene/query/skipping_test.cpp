// Skipping changes no answer: 100,000 states of a robot that moves in every way, with skipping and without.
#include "chance.h"
#include "proximity_server/scene/model/kinematics.h"
#include "proximity_server/scene/query/pair_distances.h"
#include "sanitized.h"
#include "scene/posed_scene.h"
#include "scene/query/all_pairs.h"
#include "scene/two_arms.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <random>
#include <string>
#include <vector>

namespace proximity_server::scene::skipping_test {

using namespace narrowphase;

using Eigen::Isometry3d;
using Eigen::Vector3d;

const int kStates = repeats(6000);    // of each way to move
constexpr double kAgreement = 1e-12;  // [m]
constexpr double kTolerance = 1e-12;  // [m] asked of every distance
constexpr std::size_t kClosest = 5;

// --- the robots

/// Arms about one torso, so that most of them are far from each other and neighbours are not.
std::string manyArms() {
  std::string links = twoArms();
  for (int i = 0; i < 6; ++i) links += arm("arm_" + std::to_string(i) + "_", "0 0 " + std::to_string(1.4 + 1.1 * i));
  return links;
}

// --- how it moves

enum class Motion : unsigned char { Random, Coherent, Teleporting, Resting };

/// A state of the joints, and a robot that stands anywhere.
class Mover {
 public:
  Mover(const RobotModel& robot, Motion motion)
      : robot_(robot), motion_(motion), random_(static_cast<unsigned>(motion) + 1), phases_(robot.joints.size()) {
    jump();
  }

  /// The poses of the next state.
  BodyPoses next() {
    switch (motion_) {
      case Motion::Random:
        jump();
        break;
      case Motion::Coherent:
        one_in(250) ? jump() : step();
        break;
      case Motion::Teleporting:
        one_in(20) ? jump() : step();
        break;
      case Motion::Resting:
        if (one_in(10)) step();
        if (one_in(200)) jump();
        if (one_in(3)) base_ = base_ * Eigen::AngleAxisd(0.01, Vector3d::UnitZ()) * Eigen::Translation3d(0.01, 0, 0);
        break;
    }
    std::vector<double> positions;
    for (const double phase : phases_) positions.push_back(2.5 * std::sin(phase));
    BodyPoses poses = forwardKinematics(robot_, positions);
    for (auto& pose : poses) pose = base_ * *pose;
    return poses;
  }

 private:
  bool one_in(unsigned n) { return random_() % n == 0; }
  void jump() {
    for (double& phase : phases_) phase = std::uniform_real_distribution<double>(-10, 10)(random_);
    base_ = Eigen::Translation3d(Vector3d::Random() * 3.0) *
            Eigen::AngleAxisd(std::uniform_real_distribution<double>(-3, 3)(random_), Vector3d::UnitX());
  }
  void step() {
    for (std::size_t joint = 0; joint < phases_.size(); ++joint)
      phases_[joint] += 0.0004 * static_cast<double>(joint % 3 + 1);
  }

  const RobotModel& robot_;
  const Motion motion_;
  Chance random_;
  std::vector<double> phases_;
  Isometry3d base_ = Isometry3d::Identity();
};

// --- the same questions with skipping and without

/// As the levels of a monitor divide the distances.
int levelOf(double distance) { return (distance <= 0.0) + (distance <= 0.02) + (distance <= 0.05); }

struct Case {
  const char* name;
  std::string (*links)();
  Motion motion;
  int states;
};

class MovingRobot : public testing::TestWithParam<Case> {};

TEST_P(MovingRobot, SkippingNeverChangesAnAnswer) {
  const auto model = modelOf(urdfOf(GetParam().links()));
  PosedScene scene(model), everything(model, Skipping::Off);
  Mover mover(model->robot, GetParam().motion);
  const Candidates& pairs = scene.candidates();
  Question question, below;
  question.tolerance = below.tolerance = kTolerance;
  below.threshold = 0.05;
  long overlaps = 0, near = 0;
  PairCounts counts;
  for (int state = 0; state < GetParam().states && !HasFatalFailure(); ++state) {
    SCOPED_TRACE("state " + std::to_string(state));
    const BodyPoses poses = mover.next();
    scene.update(poses);
    everything.update(poses);
    const AllPairs truth(everything.all(pairs, question), kAgreement);
    ASSERT_EQ(everything.counts().computed, static_cast<int>(pairs.size()));

    const PairProximity minimum = *scene.minimum(pairs, question);
    truth.expectClosest({minimum});
    counts.total += scene.counts().total;
    counts.at_rest += scene.counts().at_rest;
    counts.by_motion += scene.counts().by_motion;
    counts.by_bounds += scene.counts().by_bounds;
    counts.computed += scene.counts().computed;

    const std::vector<PairProximity>& found = scene.below(pairs, below);
    truth.expectCount(found.size(), below.threshold);
    truth.expectClosest(found);
    truth.expectClosest(scene.closest(pairs, kClosest, question));
    const int level = levelOf(minimum.result.distance);
    ASSERT_TRUE(level == levelOf(truth.smallest(0) - kAgreement) || level == levelOf(truth.smallest(0) + kAgreement));

    overlaps += truth.smallest(0) < 0.0;
    near += truth.smallest(0) > 0.0 && truth.smallest(0) <= below.threshold;
  }
  EXPECT_EQ(counts.total, counts.at_rest + counts.by_motion + counts.by_bounds + counts.computed);
  if (!kIsSanitized) {
    EXPECT_GT(overlaps, GetParam().states / 50);
    EXPECT_GT(near, GetParam().states / 50);
  }
  RecordProperty("settled", std::to_string(counts.at_rest) + " at rest, " + std::to_string(counts.by_motion) +
                                " by motion, " + std::to_string(counts.by_bounds) + " by bounds, " +
                                std::to_string(counts.computed) + " computed");
}

TEST_P(MovingRobot, PairsBeyondTheListAreCountedAsIfTheyWereComputed) {
  constexpr int kListed = 2;
  const auto model = modelOf(urdfOf(GetParam().links()));
  PosedScene scene(model), everything(model, Skipping::Off);
  Mover mover(model->robot, GetParam().motion);
  Question question, below;
  question.tolerance = below.tolerance = kTolerance;
  below.threshold = 0.3;
  long counted = 0, computed = 0;
  for (int state = 0; state < GetParam().states && !HasFatalFailure(); ++state) {
    SCOPED_TRACE("state " + std::to_string(state));
    const BodyPoses poses = mover.next();
    scene.update(poses);
    everything.update(poses);
    const AllPairs truth(everything.all(everything.candidates(), question), kAgreement);
    const PairsBelow found = scene.closestBelow(scene.candidates(), kListed, below);
    truth.expectCount(found.count, below.threshold);
    ASSERT_EQ(static_cast<int>(found.closest.size()), std::min(kListed, found.count));
    truth.expectClosest(found.closest);
    const PairCounts& counts = scene.counts();
    ASSERT_EQ(counts.total, counts.at_rest + counts.by_motion + counts.by_bounds + counts.computed);
    counted += found.count;
    computed += counts.computed;
  }
  EXPECT_GT(counted, kListed * GetParam().states);
  if (GetParam().motion == Motion::Coherent || GetParam().motion == Motion::Resting) {
    EXPECT_LT(computed, counted);
  }
}

/// Every third pair has a threshold of its own, up to 0.6 m.
PairDistances someThresholds(const Candidates& pairs) {
  PairDistances thresholds(0.02, 0.0);
  for (std::size_t i = 0; i < pairs.size(); i += 3)
    thresholds.setPair(pairs[i].b.link(), pairs[i].a.link(), 0.05 * static_cast<double>(i % 13));
  return thresholds;
}

TEST_P(MovingRobot, SkippingNeverChangesWhichPairsAreNearestToTheirThresholds) {
  const auto model = modelOf(urdfOf(GetParam().links()));
  PosedScene scene(model), everything(model, Skipping::Off);
  Mover mover(model->robot, GetParam().motion);
  const Candidates& pairs = scene.candidates();
  const PairDistances thresholds = someThresholds(pairs);
  Question question;
  question.tolerance = kTolerance;
  long not_closest = 0;
  for (int state = 0; state < GetParam().states / 10 && !HasFatalFailure(); ++state) {
    SCOPED_TRACE("state " + std::to_string(state));
    const BodyPoses poses = mover.next();
    scene.update(poses);
    everything.update(poses);
    question.thresholds = nullptr;
    const AllPairs truth(everything.all(pairs, question), kAgreement, thresholds);
    const ShapeRefPair closest = scene.minimum(pairs, question)->asked;

    question.thresholds = &thresholds;
    const std::vector<PairProximity>& found = scene.closest(pairs, kClosest, question);
    ASSERT_EQ(found.size(), kClosest);
    truth.expectClosest(found);
    not_closest += found[0].asked.a != closest.a || found[0].asked.b != closest.b;
  }
  if (!kIsSanitized) {
    EXPECT_GT(not_closest, 0);
  }
}

INSTANTIATE_TEST_SUITE_P(Motions, MovingRobot,
                         testing::Values(Case{"Random", twoArms, Motion::Random, kStates},
                                         Case{"Coherent", twoArms, Motion::Coherent, kStates},
                                         Case{"Teleporting", twoArms, Motion::Teleporting, kStates},
                                         Case{"Resting", twoArms, Motion::Resting, kStates},
                                         Case{"ManyArmsCoherent", manyArms, Motion::Coherent, kStates / 20},
                                         Case{"ManyArmsTeleporting", manyArms, Motion::Teleporting, kStates / 20}),
                         [](const testing::TestParamInfo<Case>& test) { return test.param.name; });

// --- each way to skip a computation by itself

/// Two arms in some state, and what a scene says about them.
class Shortcuts : public testing::Test {
 protected:
  BodyPoses posesAt(double position) const {
    return forwardKinematics(model_->robot, std::vector<double>(model_->robot.joints.size(), position));
  }
  static BodyPoses moved(BodyPoses poses, const Isometry3d& base) {
    for (auto& pose : poses) pose = base * *pose;
    return poses;
  }

  const std::shared_ptr<const SceneModel> model_ = modelOf(urdfOf(twoArms()));
  PosedScene scene_{model_};
};

TEST_F(Shortcuts, AnAnswerAtRestIsTheSameToTheLastBit) {
  scene_.update(posesAt(0.3));
  const std::vector<PairProximity> before = scene_.all(scene_.candidates());
  EXPECT_EQ(scene_.counts().computed, static_cast<int>(before.size()));
  scene_.update(posesAt(0.3));
  const std::vector<PairProximity>& after = scene_.all(scene_.candidates());
  EXPECT_EQ(scene_.counts().at_rest, static_cast<int>(before.size()));
  for (std::size_t i = 0; i < before.size(); ++i) {
    EXPECT_EQ(after[i].result.distance, before[i].result.distance);
    EXPECT_EQ(after[i].result.point_b, before[i].result.point_b);
  }
}

TEST_F(Shortcuts, ARobotThatIsCarriedAwayIsAtRest) {
  const Isometry3d away = Eigen::Translation3d(30.0, -20.0, 5.0) * Eigen::AngleAxisd(2.0, Vector3d(0.6, 0.0, 0.8));
  scene_.update(posesAt(0.3));
  const std::vector<PairProximity> before = scene_.all(scene_.candidates());
  scene_.update(moved(posesAt(0.3), away));
  const std::vector<PairProximity>& after = scene_.all(scene_.candidates());
  EXPECT_EQ(scene_.counts().at_rest, static_cast<int>(before.size()));
  for (std::size_t i = 0; i < before.size(); ++i) {
    EXPECT_TRUE(after[i].result.point_a.isApprox(away * before[i].result.point_a, 1e-14));
    EXPECT_TRUE(after[i].result.normal.isApprox(away.linear() * before[i].result.normal, 1e-14));
    EXPECT_LE(after[i].result.lower_bound, before[i].result.lower_bound);
    EXPECT_GE(after[i].result.upper_bound, before[i].result.upper_bound);
  }
}

TEST_F(Shortcuts, AnAnswerAtRestDoesNotServeANarrowerTolerance) {
  Question loose, narrow;
  loose.tolerance = 0.05;
  narrow.tolerance = 1e-12;
  scene_.update(posesAt(0.3));
  scene_.all(scene_.candidates(), loose);
  PosedScene fresh(model_);
  fresh.update(posesAt(0.3));
  const std::vector<PairProximity>& expected = fresh.all(fresh.candidates(), narrow);
  const std::vector<PairProximity>& found = scene_.all(scene_.candidates(), narrow);
  for (std::size_t i = 0; i < found.size(); ++i)
    EXPECT_NEAR(found[i].result.distance, expected[i].result.distance, kAgreement);
}

TEST_F(Shortcuts, BoundsOfBeforeLessTheMotionAreEnoughForWhatIsFar) {
  Question below;
  scene_.update(posesAt(0.3));
  scene_.all(scene_.candidates());
  below.threshold = scene_.minimum(scene_.candidates())->result.distance - 0.01;  // nothing is that near
  scene_.update(posesAt(0.3 + 1e-4));
  EXPECT_TRUE(scene_.below(scene_.candidates(), below).empty());
  EXPECT_GT(scene_.counts().by_motion, 0);
  EXPECT_EQ(scene_.counts().computed, 0);
}

TEST_F(Shortcuts, BoundsOfBeforeAreNotThoseOfWhatHasComeNearer) {
  scene_.update(posesAt(0.3));
  const double before = scene_.minimum(scene_.candidates())->result.distance;
  int nearer = 0;
  for (const double position : {0.2, 0.4}) {
    PosedScene fresh(model_);
    fresh.update(posesAt(position));
    Question below;
    below.threshold = fresh.minimum(fresh.candidates())->result.distance + 1e-6;
    if (below.threshold < before - 0.001) ++nearer;
    scene_.update(posesAt(0.3));
    scene_.all(scene_.candidates());
    scene_.update(posesAt(position));
    EXPECT_FALSE(scene_.below(scene_.candidates(), below).empty()) << position;
  }
  EXPECT_GT(nearer, 0);
}

TEST_F(Shortcuts, BoundsOfBeforePlusTheMotionAreEnoughToCountWhatIsNearButNotListed) {
  Question near;
  near.threshold = 1.0;
  scene_.update(posesAt(0.3));
  const int count = scene_.closestBelow(scene_.candidates(), 1, near).count;
  const int all = scene_.counts().computed;
  ASSERT_GT(count, 2);
  EXPECT_GE(all, count);
  scene_.update(posesAt(0.3 + 1e-4));
  EXPECT_EQ(scene_.closestBelow(scene_.candidates(), 1, near).count, count);
  EXPECT_LT(scene_.counts().computed, all / 2);
  EXPECT_EQ(scene_.closestBelow(scene_.candidates(), 0, near).count, count);
}

TEST_F(Shortcuts, WithoutSkippingAllIsComputed) {
  PosedScene everything(model_, Skipping::Off);
  for (int repeat = 0; repeat < 2; ++repeat) {
    everything.update(posesAt(0.3));
    everything.minimum(everything.candidates());
    EXPECT_EQ(everything.counts().computed, everything.counts().total);
  }
}

TEST_F(Shortcuts, OverlapOfSeveralPiecesSaysThatTheWholeMayBeDeeper) {
  const int hand = model_->robot.findLink("left_hand"), fore = model_->robot.findLink("left_fore"),
            wrist = model_->robot.findLink("right_wrist");
  BodyPoses poses = posesAt(0.3);
  const auto body = [&](int link) { return static_cast<std::size_t>(model_->robot.links[link].body); };
  poses[body(hand)] = poses[body(fore)] = poses[body(wrist)] = Isometry3d::Identity();
  scene_.update(poses);
  const PairProximity of_several = scene_.proximity({{hand}, {fore}}), of_one = scene_.proximity({{wrist}, {fore}});
  EXPECT_LT(of_several.result.distance, 0.0);
  EXPECT_TRUE(of_several.depth_is_lower_bound);
  EXPECT_LT(of_one.result.distance, 0.0);
  EXPECT_FALSE(of_one.depth_is_lower_bound);
  scene_.update(posesAt(0.3));
  EXPECT_FALSE(scene_.proximity({{hand}, {wrist}}).depth_is_lower_bound);
}

}  // namespace proximity_server::scene::skipping_test
