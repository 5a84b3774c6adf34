#include "proximity_server/scene/answers/assessment.h"

#include "proximity_server/scene/answers/pair_selection.h"
#include "proximity_server/scene/inequalities/joint_inequalities.h"
#include "proximity_server/scene/motion/frames_on_links.h"
#include "scene/random_objects.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace proximity_server::scene::assessment_test {

/// Three balls on a rail, at -1 m, 0 m and 0.5 m, of radius 0.1 m. The distances are 0.8 m, 0.3 m and 1.3 m.
class AnAssessment : public testing::Test {
 protected:
  AnAssessment() { place({-1.0, 0.0, 0.5}); }

  static std::shared_ptr<const SceneModel> balls() {
    RobotModel robot = robotOf(urdfOf(link("rail") + link("left", ball("0.1")) + link("middle", ball("0.1")) +
                                      link("right", ball("0.1")) + slider("l", "rail", "left", "1 0 0") +
                                      slider("m", "rail", "middle", "1 0 0") + slider("r", "rail", "right", "1 0 0")));
    setJointInequalities(readYaml("['r - m <= 0.6', 'r - l <= 1.7']", ""), "", robot);
    return modelOf(std::move(robot));
  }

  void place(const Positions& positions) {
    stated_.assign(positions.begin(), positions.end());
    setPositions(state_, positions);
  }

  const Assessment& assess() {
    scene::assess(scene_, state_, question_, found_);
    return found_;
  }

  /// A ball of radius 0.1 m that stands at x [m].
  void addBall(double x) {
    const Object object = makeObject("ball", {{narrowphase::Sphere{0.1}, at(x, 0.0, 0.0)}}, Fixed{});
    state_.set(std::make_shared<const Objects>(noObjects(model_).changed({AddObject{object}})));
    place({-1.0, 0.0, 0.5});
  }

  std::string namesOf(const PairProximity& pair) const {
    return nameOf(pair.asked.a, model_->robot, state_.objects().get()) + " - " +
           nameOf(pair.asked.b, model_->robot, state_.objects().get());
  }

  const std::shared_ptr<const SceneModel> model_ = balls();
  State state_{model_};
  Scene scene_{model_};
  LevelThresholds thresholds_;
  std::vector<std::optional<double>> stated_;
  AssessmentQuestion question_{thresholds_, stated_};
  Assessment found_;
};

TEST_F(AnAssessment, ListsTheClosestPairsAndCountsAllBelowTheThreshold) {
  question_.question.threshold = 1.0;
  EXPECT_EQ(assess().below, 2);
  ASSERT_EQ(found_.listed.size(), 1U);
  EXPECT_EQ(namesOf(found_.listed[0]), "middle - right");
  EXPECT_NEAR(found_.of_listed[0].guaranteed, 0.3, 1e-9);
  question_.most_listed = 5;
  ASSERT_EQ(assess().listed.size(), 2U);
  EXPECT_EQ(namesOf(found_.listed[1]), "left - middle");
  question_.question.threshold = 0.2;
  EXPECT_TRUE(assess().listed.empty());
  EXPECT_EQ(namesOf(found_.minimum.pair), "middle - right");
  EXPECT_EQ(found_.counts.total, 3);
}

TEST_F(AnAssessment, DecidesByTheThresholdsOfEachPair) {
  thresholds_.warn.setPair(1, 3, 1.4);
  assess();
  EXPECT_EQ(namesOf(found_.minimum.pair), "middle - right");
  EXPECT_EQ(namesOf(found_.deciding.pair), "left - right");
  EXPECT_EQ(found_.level->level, ClearanceLevel::Warn);
  EXPECT_EQ(found_.level->threshold, 1.4);
  EXPECT_TRUE(found_.reached);
  EXPECT_EQ(found_.minimum.level, ClearanceLevel::Clear);
}

TEST_F(AnAssessment, OfTwoKindsOfPairsTheOneWithLessToItsThresholdDecides) {
  addBall(1.0);  // 0.3 m from the right ball, as the middle one is
  thresholds_.warn = {0.4, 0.35};
  assess();
  EXPECT_EQ(found_.of_links.level, ClearanceLevel::Warn);
  EXPECT_EQ(found_.with_object.level, ClearanceLevel::Warn);
  EXPECT_EQ(namesOf(found_.deciding.pair), "middle - right");
  thresholds_.warn = {0.35, 0.4};
  assess();
  EXPECT_EQ(namesOf(found_.deciding.pair), "right - ball");
  EXPECT_EQ(namesOf(found_.of_links.closest.pair), "middle - right");
  EXPECT_EQ(namesOf(found_.with_object.closest.pair), "right - ball");
}

TEST_F(AnAssessment, KeepsALevelWithinItsHysteresis) {
  question_.hysteresis = 0.05;
  thresholds_.warn = {0.28, 0.28};
  EXPECT_EQ(assess().level->level, ClearanceLevel::Clear);
  place({-1.0, 0.0, 0.47});
  EXPECT_EQ(assess().level->level, ClearanceLevel::Warn);
  place({-1.0, 0.0, 0.5});
  EXPECT_EQ(assess().level->level, ClearanceLevel::Warn);
  EXPECT_FALSE(found_.reached);
  place({-1.0, 0.0, 0.54});
  EXPECT_EQ(assess().level->level, ClearanceLevel::Clear);
}

TEST_F(AnAssessment, HasNoLevelWithoutTheDistanceOfAPairOrABoundOfTheState) {
  EXPECT_TRUE(assess().level);
  place({-1.0, std::numeric_limits<double>::quiet_NaN(), 0.5});
  EXPECT_FALSE(assess().level);
  EXPECT_EQ(found_.counts.unknown, 2);
  EXPECT_EQ(found_.of_links.level, std::nullopt);
  EXPECT_EQ(found_.minimum.pair.result.status, narrowphase::Status::Unknown);
  place({-1.0, 0.0, 0.5});
  question_.is_bounded = false;
  EXPECT_FALSE(assess().level);
  EXPECT_EQ(namesOf(found_.listed.at(0)), "middle - right");
  EXPECT_TRUE(std::isnan(found_.of_listed[0].guaranteed));
}

TEST_F(AnAssessment, HasGradientsWhereTheyAreAskedForAndOfADecidingPairThatIsNotClear) {
  EXPECT_TRUE(assess().minimum.gradient.empty());
  EXPECT_TRUE(found_.deciding.gradient.empty());
  thresholds_.warn = {0.3, 0.3};
  EXPECT_EQ(assess().deciding.gradient, (std::vector<double>{0.0, -1.0, 1.0}));
  EXPECT_TRUE(found_.minimum.gradient.empty());
  question_.wants_gradients = true;
  EXPECT_EQ(assess().minimum.gradient, (std::vector<double>{0.0, -1.0, 1.0}));
  EXPECT_EQ(found_.of_listed[0].gradient, found_.minimum.gradient);
}

TEST_F(AnAssessment, HasTheGuaranteedDistanceAndAStateWithinItThatReachesTheLevel) {
  GuaranteedDistances within(model_);
  Uncertainty uncertainty(model_->robot);
  uncertainty.positions[2] = 0.2;
  within.assume(uncertainty);
  question_.guaranteed = &within;
  thresholds_.warn = {0.2, 0.2};
  EXPECT_NEAR(assess().deciding.guaranteed, 0.1, 1e-6);
  EXPECT_EQ(found_.level->level, ClearanceLevel::Warn);
  EXPECT_TRUE(found_.reached);
}

TEST_F(AnAssessment, NamesTheInequalityThatIsBrokenMost) {
  EXPECT_FALSE(assess().broken);
  place({-1.5, 0.0, 0.7});
  ASSERT_TRUE(assess().broken);
  EXPECT_EQ(found_.broken->inequality->text, "r - l <= 1.7");
  EXPECT_NEAR(found_.broken->excess, 0.5, 1e-9);
}

TEST_F(AnAssessment, SelectsThePairsOfAQuestion) {
  using Kind = PairSelection::Kind;
  const auto select = [&](const PairSelection& selection) {
    Question question;
    question.threshold = 1.0;
    std::vector<std::string> names;
    for (const PairProximity& pair : selectPairs(scene_, state_, scene_.candidates(), selection, question))
      names.push_back(namesOf(pair));
    return names;
  };
  using Names = std::vector<std::string>;
  EXPECT_EQ(select({Kind::All}), (Names{"left - middle", "left - right", "middle - right"}));
  EXPECT_EQ(select({Kind::Minimum}), (Names{"middle - right"}));
  EXPECT_EQ(select({Kind::Below}), (Names{"middle - right", "left - middle"}));
  EXPECT_EQ(select({Kind::Closest, 1}), (Names{"middle - right"}));
  EXPECT_EQ(select({Kind::Any}).size(), 1U);
  place({-2.0, 0.0, 2.0});
  EXPECT_TRUE(select({Kind::Any}).empty());
  EXPECT_TRUE(select({Kind::Minimum}).empty());
}

}  // namespace proximity_server::scene::assessment_test
