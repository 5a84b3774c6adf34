#include "tools/pair_audit/pair_study.h"
#include "robots/urdf.h"

#include "proximity_server/scene/inequalities/joint_inequalities.h"
#include "proximity_server/scene/loading/load_robot_model.h"
#include "proximity_server/scene/model/kinematics.h"
#include "scene/posed_scene.h"
#include "tools/pair_audit/audit_report.h"
#include "tools/robot/crossing_sliders.h"
#include "tools/robot/two_sliders.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <stdexcept>
#include <string>

namespace proximity_server::tools::pair_study_test {

using namespace narrowphase;
using namespace scene;

std::shared_ptr<const SceneModel> modelOf(const std::string& urdf, const std::string& srdf = "") {
  auto model = std::make_shared<SceneModel>();
  model->robot = loadRobotModel(urdf, packageResolver({}));
  model->pairs = filterPairs(model->robot, srdf);
  return model;
}

TEST(PairStudy, OfTooLittleTimeDecidesNothing) {
  StudyOptions options;
  options.budget.seconds = 1e-9;
  options.budget.begin();
  const auto model = modelOf(kTwoSliders);
  const PairStudy study = studyPairs(model, options);
  EXPECT_TRUE(study.is_out_of_time);
  EXPECT_EQ(study.samples, 0);
  ASSERT_FALSE(study.pairs.empty());
  for (const PairEvidence& pair : study.pairs) EXPECT_EQ(pair.nearClass(), NearClass::Undecided);
  EXPECT_TRUE(alwaysNear(study, model->pairs).empty());
  const std::string report = auditReport(*model, study, SrdfGiven::No);
  EXPECT_NE(report.find("The time was over: " + std::to_string(study.pairs.size()) + " pairs were not searched"),
            std::string::npos)
      << report;
}

class CrossingSliders : public ::testing::Test {
 protected:
  const PairEvidence& evidence(const PairStudy& study, const std::string& a, const std::string& b) const {
    const int link_a = model_->robot.findLink(a), link_b = model_->robot.findLink(b);
    for (const PairEvidence& each : study.pairs) {
      if (each.pair.a.link() == std::min(link_a, link_b) && each.pair.b.link() == std::max(link_a, link_b)) return each;
    }
    throw std::invalid_argument("no pair " + a + " - " + b);
  }
  /// The distance of a pair at given positions, asked of a scene of its own.
  double distanceAt(const PairEvidence& pair, const Positions& positions) const {
    PosedScene scene(model_);
    scene.update(forwardKinematics(model_->robot, positions));
    return scene.proximity(pair.pair).result.distance;
  }

  const std::shared_ptr<const SceneModel>& model_ = crossingSlidersStudy().model;
  const PairStudy& study_ = crossingSlidersStudy().study;
};

TEST_F(CrossingSliders, EveryPairIsInItsClass) {
  EXPECT_EQ(evidence(study_, "base", "far").nearClass(), NearClass::Never);
  EXPECT_EQ(evidence(study_, "base", "rod").nearClass(), NearClass::Always);
  EXPECT_EQ(evidence(study_, "base", "tip").nearClass(), NearClass::Sometimes);
  EXPECT_EQ(evidence(study_, "base", "loose").nearClass(), NearClass::Undecided);
  EXPECT_EQ(study_.pairs.size(), 15U);
}

// The distance of the base and the sled is 1 + slide.
TEST(PairStudy, LooksOnlyWithinJointInequalities) {
  RobotModel robot = loadRobotModel(kTwoSliders, packageResolver({}));
  setJointInequalities(readYaml("- slide >= 0.25", ""), "", robot);
  auto model = std::make_shared<SceneModel>();
  model->pairs = filterPairs(robot, "");
  model->robot = std::move(robot);
  for (const PairEvidence& pair : studyPairs(model, StudyOptions()).pairs) {
    if (pair.pair.b.link() != model->robot.findLink("sled, left") || pair.pair.a.link() != 0) continue;
    EXPECT_GE(pair.smallest, 1.25 - 1e-5);
    EXPECT_LE(pair.smallest, 1.25 + 1e-3);
    return;
  }
  FAIL() << "no such pair";
}

TEST_F(CrossingSliders, NeighboursAreThoseOfOneJoint) {
  EXPECT_TRUE(evidence(study_, "base", "cart").are_neighbours);
  EXPECT_FALSE(evidence(study_, "base", "rod").are_neighbours);
}

// From 3.25 m to 7.25 m lie between the base and the ball, and the search goes to the end of both ranges.
TEST_F(CrossingSliders, SmallestDistanceIsThatAtTheLimits) {
  const PairEvidence& far = evidence(study_, "base", "far");
  EXPECT_NEAR(far.smallest, 3.25, 1e-3);
  EXPECT_NEAR(distanceAt(far, far.closest), far.smallest, 1e-9);
}

TEST_F(CrossingSliders, ProvenBoundIsAtMostTheSmallestDistanceAndAtLeastHalfOfIt) {
  const PairEvidence& far = evidence(study_, "base", "far");
  ASSERT_TRUE(far.proven);
  EXPECT_LE(*far.proven, 3.25);
  EXPECT_GE(*far.proven, 0.5 * 3.25);
}

TEST_F(CrossingSliders, StatesShowWhatTheyAreSaidToShow) {
  int both = 0;
  for (const PairEvidence& pair : study_.pairs) {
    const double in_contact = pair.contact ? distanceAt(pair, *pair.contact) : -1.0;
    const double apart = pair.apart ? distanceAt(pair, *pair.apart) : 1.0;
    EXPECT_LE(in_contact, kContactDistance);
    EXPECT_GT(apart, kContactDistance);
    if (pair.contact && pair.apart) ++both;
  }
  EXPECT_GT(both, 0);
}

// The rod, 0.2 thin, leaves the base, which reaches 0.5 from its axis, at 0.6 to the side: not at an angle of 45
// degrees.
TEST_F(CrossingSliders, DepthIsThatOfTheStateShown) {
  const PairEvidence& rod = evidence(study_, "base", "rod");
  EXPECT_NEAR(rod.contact_depth, -distanceAt(rod, *rod.contact), 1e-9);
  EXPECT_GE(rod.contact_depth, 0.6 - 1e-9);
  EXPECT_LE(rod.contact_depth, 0.5 + 0.1 * std::sqrt(2.0) + 1e-9);
  EXPECT_NEAR(evidence(study_, "base", "tip").contact_depth, 0.0, 1e-9);
}

// The two touch at the very end of a range of 2.25 m only.
TEST_F(CrossingSliders, SearchFindsContactThatSamplesMiss) {
  StudyOptions few;
  few.most_samples = 10;
  const PairStudy study = studyPairs(model_, few);
  EXPECT_EQ(study.samples, 10);
  EXPECT_EQ(study.end, SamplingEnd::MaxSamples);
  EXPECT_EQ(evidence(study, "base", "tip").nearClass(), NearClass::Sometimes);
}

TEST_F(CrossingSliders, SamplingEndsWhenNothingChanges) {
  if (kIsSanitized) GTEST_SKIP() << "the study of a sanitized build ends before";
  EXPECT_EQ(study_.end, SamplingEnd::Quiet);
  EXPECT_GE(study_.samples, kQuietSamples);
  EXPECT_LT(study_.samples, StudyOptions().most_samples);
}

TEST(PairStudy, SamplingEndsWhenAllIsKnown) {
  using namespace robots;
  const auto model = modelOf(urdfOf(link("a", box("1 1 1")) + link("b", ball("0.2", "0.6 0 0")) +
                                    hinge("turn", "a", "b", "0 0 1", "0.4 0 0")));
  const PairStudy study = studyPairs(model, {});
  EXPECT_EQ(study.end, SamplingEnd::AllKnown);
  EXPECT_LT(study.samples, 5000);
}

TEST_F(CrossingSliders, AnotherSeedDrawsOtherStates) {
  StudyOptions options;
  options.seed = 2;
  options.most_samples = 10;
  const PairStudy other = studyPairs(model_, options);
  EXPECT_NE(*evidence(other, "base", "far").apart, *evidence(study_, "base", "far").apart);
  EXPECT_EQ(evidence(other, "base", "far").nearClass(), NearClass::Never);
}

using Pairs = std::set<std::set<std::string>>;
Pairs namesOf(const std::vector<int>& indices, const SceneModel& model, const PairStudy& study) {
  Pairs names;
  for (const int i : indices) {
    const ShapeRefPair& pair = study.pairs[i].pair;
    names.insert({model.robot.links[pair.a.link()].name, model.robot.links[pair.b.link()].name});
  }
  return names;
}

TEST_F(CrossingSliders, FaultsOfAnSrdfAreFound) {
  const auto model = modelOf(kCrossingSliders, kFaultySrdf);
  const SrdfFaults faults = findSrdfFaults(*model, study_);
  EXPECT_EQ(namesOf(faults.disabled_but_touch, *model, study_), (Pairs{{"base", "tip"}}));
  EXPECT_EQ(namesOf(faults.disabled_but_near, *model, study_), Pairs{});
  EXPECT_EQ(namesOf(faults.checked_but_always, *model, study_), (Pairs{{"base", "rod"}}));
  EXPECT_EQ(namesOf(faults.checked_but_never, *model, study_), (Pairs{{"rod", "far"}, {"tip", "far"}}));
}

TEST_F(CrossingSliders, APairThatTheSrdfSaysWhyItDisablesIsNoFault) {
  std::string srdf = kFaultySrdf;
  srdf.replace(srdf.find("\"User\""), 6, "\"User: a bumper\"");
  const auto model = modelOf(kCrossingSliders, srdf);
  const SrdfFaults faults = findSrdfFaults(*model, study_);
  EXPECT_EQ(namesOf(faults.disabled_by_decision, *model, study_), (Pairs{{"base", "tip"}}));
  EXPECT_EQ(namesOf(faults.disabled_but_touch, *model, study_), Pairs{});
  const std::string report = auditReport(*model, study_, SrdfGiven::Yes);
  EXPECT_NE(report.find("disabled by decision, although they can collide (1)\n  base - tip: said to be \"User: a "
                        "bumper\", in contact, "),
            std::string::npos)
      << report;
}

StudyOptions within(double distance) {
  StudyOptions options;
  options.distance = distance;
  options.most_samples = 2000;
  return options;
}

// The tip comes as near to the rod as 0.5 - sqrt(0.02), 0.36. The ball is from 0.75 to 2.75 behind the end of the rod.
TEST_F(CrossingSliders, ADistanceMakesTheClasses) {
  const PairStudy at_04 = studyPairs(model_, within(0.4));
  EXPECT_EQ(evidence(at_04, "rod", "tip").nearClass(), NearClass::Sometimes);
  EXPECT_FALSE(evidence(at_04, "rod", "tip").canCollide());
  EXPECT_EQ(evidence(at_04, "rod", "far").nearClass(), NearClass::Never);
  EXPECT_EQ(evidence(at_04, "base", "rod").nearClass(), NearClass::Always);
  EXPECT_TRUE(evidence(at_04, "base", "rod").alwaysInContact());
  EXPECT_EQ(evidence(at_04, "base", "tip").nearClass(), NearClass::Sometimes);
  EXPECT_TRUE(evidence(at_04, "base", "tip").canCollide());
  EXPECT_EQ(evidence(at_04, "base", "loose").nearClass(), NearClass::Undecided);

  const PairEvidence far = evidence(studyPairs(model_, within(1.0)), "rod", "far");
  EXPECT_EQ(far.nearClass(), NearClass::Sometimes);
  EXPECT_NEAR(far.smallest, 0.75, 1e-3);
}

TEST_F(CrossingSliders, ThatAPairIsNeverWithinADistanceIsProvenForThatDistance) {
  const PairEvidence far = evidence(studyPairs(model_, within(0.7)), "rod", "far");
  EXPECT_EQ(far.nearClass(), NearClass::Never);
  ASSERT_TRUE(far.proven);
  EXPECT_GT(*far.proven, 0.7);
  EXPECT_LE(*far.proven, 0.75);
}

// Ten states are not enough to see the ends of the range, so the searches find them.
TEST_F(CrossingSliders, BothEndsAreMeasuredOfAPairThatIsAlwaysNear) {
  StudyOptions few = within(3.0);
  few.most_samples = 10;
  const PairEvidence far = evidence(studyPairs(model_, few), "rod", "far");
  EXPECT_EQ(far.nearClass(), NearClass::Always);
  EXPECT_FALSE(far.alwaysInContact());
  EXPECT_NEAR(far.smallest, 0.75, 1e-3);
  EXPECT_NEAR(far.largest, 2.75, 1e-3);
  EXPECT_NEAR(distanceAt(far, far.farthest), far.largest, 1e-9);
}

// The ball comes to 0.75 of the rod: never within 0.4, but within a warn distance of 1.
TEST_F(CrossingSliders, WhatComesWithinTheWarnDistanceIsNotBeyondIt) {
  StudyOptions options = within(0.4);
  options.warn_distance = 1.0;
  const PairEvidence near = evidence(studyPairs(model_, options), "rod", "far");
  EXPECT_EQ(near.nearClass(), NearClass::Never);
  EXPECT_FALSE(near.isBeyond());
  options.warn_distance = 0.7;
  const PairEvidence far = evidence(studyPairs(model_, options), "rod", "far");
  EXPECT_TRUE(far.isProvenBeyond());
  EXPECT_GT(*far.proven, 0.7);
}

TEST_F(CrossingSliders, TheLargestDistanceIsMeasuredUpToTheWarnDistance) {
  StudyOptions options = within(0.7);
  options.warn_distance = 3.0;
  const PairStudy study = studyPairs(model_, options);
  EXPECT_EQ(evidence(study, "rod", "far").nearClass(), NearClass::Never);
  EXPECT_NEAR(evidence(study, "rod", "far").largest, 2.75, 1e-3);
  EXPECT_GT(evidence(study, "base", "far").largest, 3.0);
}

// base - tip and rod - tip are within 3 m too; base - rod is always in contact, and nobody knows of "loose".
TEST_F(CrossingSliders, CheckedPairsThatAreAlwaysNearAreListed) {
  const PairStudy study = studyPairs(model_, within(3.0));
  const auto namesOf = [&](const std::vector<AlwaysNear>& near) {
    Pairs names;
    for (const AlwaysNear& each : near) {
      names.insert({model_->robot.links[each.pair.a.link()].name, model_->robot.links[each.pair.b.link()].name});
    }
    return names;
  };
  EXPECT_EQ(namesOf(alwaysNear(study, model_->pairs)), (Pairs{{"base", "tip"}, {"rod", "tip"}, {"rod", "far"}}));
  const PairTable without_far = filterPairs(
      model_->robot, R"(<robot name="crossing sliders"><disable_collisions link1="far" link2="rod"/></robot>)");
  const std::vector<AlwaysNear> left = alwaysNear(study, without_far);
  EXPECT_EQ(namesOf(left), (Pairs{{"base", "tip"}, {"rod", "tip"}}));
  EXPECT_TRUE(alwaysNear(studyPairs(model_, within(0.5)), model_->pairs).empty());
}

// The tip touches the cart's ball, which is 5 to its side, in no state.
TEST_F(CrossingSliders, NeighboursAreJudgedByContactWhateverTheDistance) {
  const PairStudy study = studyPairs(model_, within(10.0));
  EXPECT_EQ(evidence(study, "cart", "tip").nearClass(), NearClass::Never);
}

TEST_F(CrossingSliders, DisabledPairsThatComeNearAreFound) {
  const auto model = modelOf(kCrossingSliders, kFaultySrdf);
  const PairStudy study = studyPairs(model_, within(0.4));
  const SrdfFaults faults = findSrdfFaults(*model, study);
  EXPECT_EQ(namesOf(faults.disabled_but_touch, *model, study), (Pairs{{"base", "tip"}}));
  EXPECT_EQ(namesOf(faults.disabled_but_near, *model, study), (Pairs{{"rod", "tip"}}));
  EXPECT_EQ(namesOf(faults.checked_but_never, *model, study), (Pairs{{"rod", "far"}, {"tip", "far"}}));
}

TEST(JointRanges, AFollowerHasNoRangeOfItsOwn) {
  const RobotModel robot = modelOf(kTwoSliders)->robot;
  const std::vector<JointRange> ranges = jointRanges(robot);
  ASSERT_EQ(ranges.size(), 1U);
  EXPECT_EQ(robot.joints[ranges[0].joint].name, "slide");
  EXPECT_EQ(ranges[0].lower, -1.0);
  EXPECT_EQ(ranges[0].upper, 2.0);
}

TEST(JointRanges, PositionsCanBeTypedIn) {
  const JointRange turn{0, -2.8973, 2.8973}, finger{0, 0.0, 0.04}, welded{0, 0.5, 0.5};
  EXPECT_EQ(turn.typeable(1.23456789), 1.2346);
  EXPECT_EQ(turn.typeable(2.89728), 2.8973);
  EXPECT_EQ(turn.typeable(3.5), 2.8973);
  EXPECT_EQ(finger.typeable(0.0123456789), 0.012346);
  EXPECT_EQ(welded.typeable(0.7), 0.5);
}

/// A robot with one joint, given the rest of its element.
RobotModel withJoint(const std::string& joint) {
  return loadRobotModel(R"(<robot name="r"><link name="a"/><link name="b"/><joint name="j" )" + joint +
                            R"(<parent link="a"/><child link="b"/></joint></robot>)",
                        packageResolver({}));
}

const char* const kTwoTurns = R"(type="revolute"><limit lower="-6.5" upper="6.5" effort="1" velocity="1"/>)";
const char* const kEndless = R"(type="prismatic"><limit lower="1" upper="-1" effort="1" velocity="1"/>)";

TEST(JointRanges, MoreThanAFullTurnIsAFullTurn) {
  constexpr double kPi = 3.14159265358979323846;
  const JointRange two_turns = jointRanges(withJoint(kTwoTurns)).at(0);
  EXPECT_DOUBLE_EQ(two_turns.lower, -kPi);
  EXPECT_DOUBLE_EQ(two_turns.upper, kPi);
  EXPECT_DOUBLE_EQ(jointRanges(withJoint("type=\"continuous\">")).at(0).upper, kPi);
}

TEST(JointRanges, WhatHasNoLimitsIsNotKnown) {
  EXPECT_TRUE(hasKnownRange(withJoint(kTwoTurns), 0));
  EXPECT_TRUE(hasKnownRange(withJoint("type=\"continuous\">"), 0));
  EXPECT_FALSE(hasKnownRange(withJoint(kEndless), 0));
  EXPECT_FALSE(hasKnownRange(withJoint("type=\"floating\">"), 0));
  EXPECT_EQ(jointRanges(withJoint(kEndless)).at(0).upper, 1.0);
  EXPECT_TRUE(jointRanges(withJoint("type=\"floating\">")).empty());
}

}  // namespace proximity_server::tools::pair_study_test
