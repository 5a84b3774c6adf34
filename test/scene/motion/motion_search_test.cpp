#include "proximity_server/scene/motion/motion_search.h"

#include "chance.h"
#include "proximity_server/scene/model/kinematics.h"
#include "sanitized.h"
#include "scene/example_robots.h"
#include "scene/posed_scene.h"
#include "scene/small_robots.h"
#include "scene/solids.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <random>
#include <stdexcept>
#include <string>

namespace proximity_server::scene::motion_search_test {

using namespace narrowphase;

using Eigen::Isometry3d;
using Eigen::Vector3d;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kPi = 3.14159265358979323846;

// On the x axis a wall whose face stands at x = 0.5, and a box of edge 1 that "slide" carries from x = 3 on: the gap is
// 2 + slide. "swing" turns an arm about the z axis through (0, 5, 0): a ball of radius 0.25, at (2, 5, 0) when it
// stands at 0. "stand" moves a post of radius 0.5, a ball about (0, 7.25 + stand, 0), so that the arm at a quarter turn
// points at it and the gap is stand - 0.5.
const std::string kSlideAndSwing =
    urdfOf(link("wall", box("1 4 4")) + link("sled", box("1 1 1")) + link("arm", ball("0.25", "2 0 0")) +
           link("post", ball("0.5")) + link("frame") + weld("weld", "frame", "wall") +
           slider("slide", "frame", "sled", "1 0 0", "3 0 0") + hinge("swing", "frame", "arm", "0 0 1", "0 5 0") +
           slider("stand", "frame", "post", "0 1 0", "0 7.25 0"));

/// The robot above, on the way from one state to another.
class SlideAndSwing : public testing::Test {
 protected:
  using State = std::map<std::string, double>;
  RobotMotion motion(const State& from, const State& to) const {
    return RobotMotion::between(model_->robot, byJoint(model_->robot, from), byJoint(model_->robot, to));
  }

  const std::shared_ptr<const SceneModel> model_ = modelOf(kSlideAndSwing);
  const std::vector<ShapeRefPair> sled_ = {pairOf(*model_, "wall", "sled")};
  const std::vector<ShapeRefPair> arm_ = {pairOf(*model_, "post", "arm")};
  MotionSearch scene_{model_};
};

TEST_F(SlideAndSwing, SledReachesTheWallWhenItHasCoveredTheGap) {
  const RobotTimeOfContact contact = scene_.timeOfContact(sled_, motion({}, {{"slide", -2.5}}));
  EXPECT_EQ(contact.status, Status::Converged);
  ASSERT_TRUE(contact.contact);
  EXPECT_NEAR(contact.t_contact, 2.0 / 2.5, 1e-6 / 2.5 + 1e-12);
  EXPECT_LE(contact.t_free, 0.8);
  EXPECT_LE(contact.t_free, contact.t_contact);
  EXPECT_LE(contact.pair.result.distance, 1e-6);
  EXPECT_NEAR(contact.pair.result.point_a.x(), 0.5, 1e-12);
  EXPECT_NEAR(contact.pair.result.normal.x(), 1.0, 1e-12);
}

TEST_F(SlideAndSwing, ContactDistanceIsReachedBefore) {
  MotionQuestion question;
  question.contact_distance = 0.5;
  const RobotTimeOfContact contact = scene_.timeOfContact(sled_, motion({}, {{"slide", -2.5}}), question);
  ASSERT_TRUE(contact.contact);
  EXPECT_NEAR(contact.t_contact, 1.5 / 2.5, 1e-6);
}

TEST_F(SlideAndSwing, PairPaddingIsTakenOffTheDistance) {
  SceneModel model = *model_;
  for (LinkPair& pair : model.pairs.pairs) pair.padding = 0.5;
  MotionSearch padded(std::make_shared<const SceneModel>(model));
  const RobotTimeOfContact contact = padded.timeOfContact(sled_, motion({}, {{"slide", -2.5}}));
  ASSERT_TRUE(contact.contact);
  EXPECT_NEAR(contact.t_contact, 1.5 / 2.5, 1e-6);
  EXPECT_NEAR(contact.pair.result.point_a.x(), 0.75, 1e-6);  // half of the padding on either side
  const RobotMinimum minimum = padded.minimum(sled_, motion({}, {{"slide", -1.0}}));
  EXPECT_NEAR(minimum.upper_bound, 0.5, 1e-6);
}

TEST_F(SlideAndSwing, NoContactIsAProofForTheWholeMotion) {
  const RobotTimeOfContact contact = scene_.timeOfContact(sled_, motion({}, {{"slide", -1.9}}));
  EXPECT_EQ(contact.status, Status::Converged);
  EXPECT_FALSE(contact.contact);
  EXPECT_EQ(contact.t_free, 1.0);
  EXPECT_TRUE(std::isnan(contact.t_contact));
}

TEST_F(SlideAndSwing, ContactFromTheBeginningIsAtTimeZero) {
  const RobotTimeOfContact contact = scene_.timeOfContact(sled_, motion({{"slide", -2.25}}, {{"slide", 1.0}}));
  ASSERT_TRUE(contact.contact);
  EXPECT_EQ(contact.t_contact, 0.0);
  EXPECT_EQ(contact.t_free, 0.0);
  EXPECT_NEAR(contact.pair.result.distance, -0.25, 1e-9);
}

TEST_F(SlideAndSwing, PairWithAContactDistanceOfItsOwnMayStartNearerAndPart) {
  MotionQuestion question;
  question.contact_distance = 0.5;
  const RobotMotion away = motion({{"slide", -1.9}}, {{"slide", 1.0}});
  ASSERT_EQ(scene_.timeOfContact(sled_, away, question).t_contact, 0.0);
  question.nearer_pairs = {{{sled_.front().b, sled_.front().a}, 0.09}};  // in any order
  const RobotTimeOfContact free = scene_.timeOfContact(sled_, away, question);
  EXPECT_EQ(free.status, Status::Converged);
  EXPECT_FALSE(free.contact);
  EXPECT_EQ(free.t_free, 1.0);
}

TEST_F(SlideAndSwing, PairWithAContactDistanceOfItsOwnMeetsItThere) {
  MotionQuestion question;
  question.contact_distance = 0.5;
  question.nearer_pairs = {{sled_.front(), 0.05}};
  const RobotTimeOfContact contact =
      scene_.timeOfContact(sled_, motion({{"slide", -1.9}}, {{"slide", -2.0}}), question);
  ASSERT_TRUE(contact.contact);
  EXPECT_NEAR(contact.t_contact, 0.5, 1e-4);
  EXPECT_NEAR(contact.pair.result.distance, 0.05, 1e-5);
}

TEST_F(SlideAndSwing, ContactDistanceOfOnePairIsNoneOfAnother) {
  MotionQuestion question;
  question.contact_distance = 0.5;
  question.nearer_pairs = {{arm_.front(), -1.0}};
  EXPECT_EQ(scene_.timeOfContact(sled_, motion({{"slide", -1.9}}, {{"slide", 1.0}}), question).t_contact, 0.0);
}

TEST_F(SlideAndSwing, ThresholdOfAPairIsAddedToTheContactDistance) {
  PairDistances thresholds(0.25, 0.0);
  MotionQuestion question;
  question.contact_distance = 0.25;
  question.thresholds = &thresholds;
  const RobotMotion towards = motion({}, {{"slide", -2.5}});
  EXPECT_NEAR(scene_.timeOfContact(sled_, towards, question).t_contact, 1.5 / 2.5, 1e-6);
  thresholds.setPair(sled_.front().b.link(), sled_.front().a.link(), 0.75);
  const RobotTimeOfContact contact = scene_.timeOfContact(sled_, towards, question);
  EXPECT_NEAR(contact.t_contact, 1.0 / 2.5, 1e-6);
  EXPECT_NEAR(contact.pair.result.distance, 1.0, 1e-5);
}

// Regression: the search ended at once, and said Converged.
TEST_F(SlideAndSwing, ToleranceThatIsNotANumberCountsAsZero) {
  MotionQuestion question;
  question.tolerance = std::numeric_limits<double>::quiet_NaN();
  const RobotMinimum minimum = scene_.minimum(sled_, motion({{"slide", 1.0}}, {{"slide", -1.0}}), question);
  EXPECT_NEAR(minimum.lower_bound, 1.0, 1e-9);
  EXPECT_NEAR(minimum.upper_bound, 1.0, 1e-9);
}

TEST_F(SlideAndSwing, RestingRobotKeepsItsDistance) {
  const RobotMotion rest = motion({{"slide", -1.0}}, {{"slide", -1.0}});
  EXPECT_FALSE(scene_.timeOfContact(sled_, rest).contact);
  const RobotMinimum minimum = scene_.minimum(sled_, rest);
  EXPECT_EQ(minimum.status, Status::Converged);
  EXPECT_NEAR(minimum.lower_bound, 1.0, 1e-6);
  EXPECT_NEAR(minimum.upper_bound, 1.0, 1e-6);
}

TEST_F(SlideAndSwing, SmallestDistanceOnAnArcIsWhereTheArmPointsAtThePost) {
  const RobotMinimum minimum = scene_.minimum(arm_, motion({{"stand", 2.0}}, {{"stand", 2.0}, {"swing", 2.0}}));
  EXPECT_EQ(minimum.status, Status::Converged);
  EXPECT_LE(minimum.lower_bound, 1.5);
  EXPECT_GE(minimum.upper_bound, 1.5);
  EXPECT_LE(minimum.upper_bound - minimum.lower_bound, 1e-6);
  EXPECT_NEAR(minimum.time, 0.5 * kPi / 2.0, 1e-3);  // a distance that is 1e-6 larger may be this much apart in time
  EXPECT_NEAR(minimum.pair.result.point_b.y(), 7.25, 1e-3);
}

TEST_F(SlideAndSwing, ArmThatTurnsSeveralTimesMeetsThePostInTheFirst) {
  // The centres are 0.75 apart where 4 + 2.25^2 - 9 sin(swing) = 0.75^2.
  const double swing = std::asin((4.0 + 2.25 * 2.25 - 0.75 * 0.75) / 9.0), all = 6.0 * kPi;
  const RobotTimeOfContact contact = scene_.timeOfContact(arm_, motion({}, {{"swing", all}}));
  ASSERT_TRUE(contact.contact);
  EXPECT_LE(contact.t_free, swing / all);
  EXPECT_NEAR(contact.t_contact, swing / all, 1e-6);
}

TEST_F(SlideAndSwing, FirstOfSeveralContactsWins) {
  const RobotMotion both = motion({}, {{"slide", -2.5}, {"swing", kPi}});
  const double swing = std::asin((4.0 + 2.25 * 2.25 - 0.75 * 0.75) / 9.0);
  const RobotTimeOfContact contact = scene_.timeOfContact(std::vector<ShapeRefPair>{sled_[0], arm_[0]}, both);
  ASSERT_TRUE(contact.contact);
  EXPECT_NEAR(contact.t_contact, swing / kPi, 1e-6);
  EXPECT_EQ(contact.pair.asked.a.link(), model_->robot.findLink("post"));
  const RobotMinimum minimum = scene_.minimum(std::vector<ShapeRefPair>{sled_[0], arm_[0]}, both);
  EXPECT_NEAR(minimum.upper_bound, -0.5, 1e-6);  // both overlap by a half: the ball in the post, the sled in the wall
}

TEST_F(SlideAndSwing, SwappingTheShapesFlipsTheNormal) {
  const RobotMotion towards = motion({}, {{"slide", -2.5}});
  const RobotTimeOfContact one = scene_.timeOfContact(sled_, towards);
  const RobotTimeOfContact other = scene_.timeOfContact(std::vector<ShapeRefPair>{{sled_[0].b, sled_[0].a}}, towards);
  EXPECT_NEAR(one.t_contact, other.t_contact, 1e-6);
  EXPECT_LE((one.pair.result.normal + other.pair.result.normal).norm(), 1e-12);
}

TEST_F(SlideAndSwing, PairsFarApartAreSettledByOneBound) {
  const RobotTimeOfContact contact =
      scene_.timeOfContact(std::vector<ShapeRefPair>{pairOf(*model_, "sled", "arm")}, motion({}, {{"slide", 0.1}}));
  EXPECT_EQ(contact.counts.pairs, 1);
  EXPECT_EQ(contact.counts.by_one_bound, 1);
  EXPECT_EQ(contact.counts.queries, 0);
  EXPECT_FALSE(contact.contact);
}

TEST_F(SlideAndSwing, MissingPoseMakesThePairUnknownAndCounted) {
  BodyPoses start = forwardKinematics(model_->robot, {});
  start[bodyOf(model_->robot, "sled")].reset();
  const RobotMotion motion = RobotMotion::ofTravel(model_->robot, start, byJoint(model_->robot, {{"slide", -2.5}}));
  const RobotTimeOfContact contact = scene_.timeOfContact(sled_, motion);
  EXPECT_EQ(contact.status, Status::Unknown);
  EXPECT_EQ(contact.counts.unknown, 1);
  EXPECT_FALSE(contact.contact);
  EXPECT_EQ(contact.t_free, 0.0);
  const RobotMinimum minimum = scene_.minimum(sled_, motion);
  EXPECT_EQ(minimum.status, Status::Unknown);
  EXPECT_EQ(minimum.lower_bound, -kInfinity);
}

// Regression: the status of a motion that overflows was lost beside those of others.
TEST_F(SlideAndSwing, TravelThatOverflowsIsUnknown) {
  for (const double far : {1e31, 1e200, 1e300}) {
    const RobotMotion passing = motion({{"slide", -far}}, {{"slide", far}});
    const RobotTimeOfContact contact = scene_.timeOfContact(sled_, passing);
    EXPECT_EQ(contact.status, Status::Unknown) << far;
    EXPECT_EQ(contact.t_free, 0.0) << far;
    EXPECT_EQ(scene_.minimum(sled_, passing).status, Status::Unknown) << far;
  }
}

// Regression: the bounds of a contact at the start were those of the pieces that were looked at first.
TEST(ContactOfLinks, HasTheBoundsOfAllTheirPieces) {
  const std::string near = ball("0.02", "0.05 0 0");
  // Its box in the frame of the link is nearer than it is, so that it is looked at first.
  const std::string far = box("0.1 0.3 0.1", "-0.09 -0.09 0", "0 0 0.7854");
  for (const std::string& pieces : {near + far, far + near}) {
    const auto model =
        modelOf(urdfOf(link("probe", ball("0.01")) + link("hand", pieces) + slider("slide", "probe", "hand", "0 1 0")));
    MotionQuestion question;
    question.contact_distance = 0.2;
    const RobotTimeOfContact contact = MotionSearch(model).timeOfContact(
        std::vector<ShapeRefPair>{pairOf(*model, "probe", "hand")},
        RobotMotion::between(model->robot, std::vector<double>{0.0}, std::vector<double>{1.0}), question);
    ASSERT_TRUE(contact.contact);
    EXPECT_EQ(contact.t_contact, 0.0);
    EXPECT_LE(contact.pair.result.lower_bound, 0.02);
    EXPECT_NEAR(contact.pair.result.upper_bound, 0.02, 1e-8);
  }
}

TEST_F(SlideAndSwing, DeadlineThatHasPassedLeavesBoundsThatHold) {
  MotionQuestion question;
  question.deadline = std::chrono::steady_clock::now() - std::chrono::seconds(1);
  const RobotMotion towards = motion({}, {{"slide", -2.5}});
  const RobotTimeOfContact contact = scene_.timeOfContact(sled_, towards, question);
  EXPECT_EQ(contact.status, Status::IterationLimit);
  EXPECT_FALSE(contact.contact);
  EXPECT_LE(contact.t_free, 0.8);
  const RobotMinimum minimum = scene_.minimum(sled_, towards, question);
  EXPECT_EQ(minimum.status, Status::IterationLimit);
  EXPECT_LE(minimum.lower_bound, -0.5);
  EXPECT_GE(minimum.upper_bound, -0.5);
}

TEST_F(SlideAndSwing, TheFlagOfADeadlineEndsASearchBeforeItsFirstQuery) {
  const std::atomic<bool> stop{true};
  MotionQuestion question;
  question.deadline = Deadline(stop);
  const std::vector<ShapeRefPair> pairs{pairOf(*model_, "wall", "sled"), pairOf(*model_, "arm", "post")};
  const RobotMotion towards = motion({}, {{"slide", -2.5}, {"swing", 2.0}, {"stand", 0.1}});
  const RobotTimeOfContact contact = scene_.timeOfContact(pairs, towards, question);
  EXPECT_EQ(contact.status, Status::IterationLimit);
  EXPECT_EQ(contact.t_free, 0.0);
  EXPECT_EQ(contact.counts.queries, 0);
  EXPECT_LE(contact.counts.intervals, 1);
  const RobotMinimum minimum = scene_.minimum(pairs, towards, question);
  EXPECT_EQ(minimum.status, Status::IterationLimit);
  EXPECT_LE(minimum.lower_bound, -0.5);
  EXPECT_EQ(minimum.counts.queries, 0);
  EXPECT_LE(minimum.counts.intervals, 1);
  EXPECT_GT(scene_.minimum(pairs, towards).counts.queries, 0);
}

TEST_F(SlideAndSwing, BodiesMoveAtTheirOwnTwists) {
  const BodyPoses start = forwardKinematics(model_->robot, {});
  std::vector<RobotMotion::Twist> twists(start.size());
  const int body = bodyOf(model_->robot, "sled");
  twists[body].linear = {-4.0, 0.5, 0.0};
  twists[body].angular = {7.0, 0.0, 0.0};  // about the way it goes, so that its face stays parallel to the wall
  const RobotTimeOfContact contact = scene_.timeOfContact(sled_, RobotMotion::ofTwists(start, twists));
  ASSERT_TRUE(contact.contact);
  EXPECT_NEAR(contact.t_contact, 0.5, 1e-6);
}

TEST_F(SlideAndSwing, BadMotionsAreRefused) {
  const BodyPoses start = forwardKinematics(model_->robot, {});
  const std::vector<double> still = byJoint(model_->robot, {});
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(RobotMotion::ofTravel(model_->robot, BodyPoses(1), still), std::invalid_argument);
  EXPECT_THROW(RobotMotion::ofTravel(model_->robot, start, std::vector<double>(1)), std::invalid_argument);
  EXPECT_THROW(RobotMotion::ofTwists(start, {}), std::invalid_argument);
  EXPECT_THROW(scene_.minimum(sled_, RobotMotion::ofTwists({start[0]}, {{}})), std::invalid_argument);
  EXPECT_THROW(scene_.minimum(std::vector<ShapeRefPair>{{{99}, {0}}}, motion({}, {})), std::invalid_argument);
  const std::string error = errorOf([&] {
    RobotMotion::ofTravel(model_->robot, start, byJoint(model_->robot, {{"swing", nan}}));
  });
  EXPECT_NE(error.find("swing"), std::string::npos) << error;
}

// --- whole robots, against states in between

/// Random motions of about a second within the limits.
class JointMotions {
 public:
  explicit JointMotions(const RobotModel& robot, unsigned seed) : robot_(robot), random_(seed) {}

  struct Ends {
    std::vector<double> from, to;
    std::vector<double> at(double time) const {
      std::vector<double> state(from);
      for (std::size_t i = 0; i < state.size(); ++i) state[i] += time * (to[i] - from[i]);
      return state;
    }
  };
  Ends next() {
    Ends ends;
    for (const Joint& joint : robot_.joints) {
      const double lower = std::max(joint.lower, -kPi), upper = std::min(joint.upper, kPi);
      const double from = std::uniform_real_distribution<>(lower, upper)(random_);
      const double travel = std::min(joint.max_velocity, 2.0) * std::uniform_real_distribution<>(-1.0, 1.0)(random_);
      ends.from.push_back(from);
      ends.to.push_back(std::clamp(from + travel, lower, upper));
    }
    return ends;
  }

 private:
  const RobotModel& robot_;
  Chance random_;
};

void expectSamePoses(const BodyPoses& poses, const BodyPoses& expected) {
  ASSERT_EQ(poses.size(), expected.size());
  for (std::size_t i = 0; i < poses.size(); ++i)
    EXPECT_LE((poses[i]->matrix() - expected[i]->matrix()).norm(), 1e-13) << "body " << i;
}

/// No state on the way is closer than the bounds say, nor in contact before t_free.
void expectHoldsOnTheWay(const std::shared_ptr<const SceneModel>& model, int motions, int states,
                         double contact_distance) {
  MotionSearch moving(model);
  PosedScene scene(model);
  const Candidates pairs = scene.candidates();
  JointMotions random(model->robot, 3);
  int contacts = 0, exact = 0;
  MotionQuestion question;
  question.contact_distance = contact_distance;
  for (int i = 0; i < motions; ++i) {
    const JointMotions::Ends ends = random.next();
    const RobotMotion motion = RobotMotion::between(model->robot, ends.from, ends.to);
    expectSamePoses(motion.at(0.37), forwardKinematics(model->robot, ends.at(0.37)));
    const RobotTimeOfContact contact = moving.timeOfContact(pairs, motion, question);
    const RobotMinimum minimum = moving.minimum(pairs, motion, question);
    ASSERT_EQ(contact.status, Status::Converged);
    // Inside of a closed mesh a minimum may be less exact than asked.
    ASSERT_EQ(minimum.status,
              minimum.upper_bound < 0.0 && minimum.upper_bound - minimum.lower_bound > question.tolerance
                  ? Status::IterationLimit
                  : Status::Converged);
    double closest = kInfinity;
    for (int k = 0; k <= states; ++k) {
      const double time = static_cast<double>(k) / states;
      scene.update(forwardKinematics(model->robot, ends.at(time)));
      const SignedDistance found = scene.minimum(pairs)->result;
      closest = std::min(closest, found.upper_bound);
      if (time < contact.t_free) {
        EXPECT_GT(found.upper_bound, contact_distance - 1e-9) << "motion " << i << " at " << time;
      }
    }
    EXPECT_GE(closest, minimum.lower_bound - 1e-9) << "motion " << i;
    if (minimum.status == Status::Converged) {
      ++exact;
      EXPECT_LE(minimum.upper_bound, closest + question.tolerance) << "motion " << i;
    }
    EXPECT_EQ(contact.contact, minimum.lower_bound <= contact_distance) << "motion " << i;
    contacts += contact.contact;
    if (!contact.contact) continue;
    scene.update(motion.at(contact.t_contact));
    EXPECT_LE(scene.minimum(pairs)->result.lower_bound, contact_distance + question.tolerance) << "motion " << i;
  }
  EXPECT_GT(contacts, motions / 50);
  EXPECT_LT(contacts, motions - motions / 50);
  EXPECT_GE(exact, motions / 2);
}

TEST(MotionSearch, DemoRobotComesNoCloserOnTheWayThanTheBoundsSay) {
  expectHoldsOnTheWay(demoModel(), 60, repeats(100), 0.02);
}

class SharedRobotInMotion : public testing::TestWithParam<ExampleRobot> {};

TEST_P(SharedRobotInMotion, ComesNoCloserOnTheWayThanTheBoundsSay) {
  const MeshResolver resolve = exampleRobotsResolver();
  if (!findsExampleRobots(resolve)) GTEST_SKIP() << kExampleRobotsMissing;
  const auto model = modelOf(GetParam(), resolve);
  const bool is_large = model->robot.bodies.size() > 20;
  expectHoldsOnTheWay(model, is_large ? 10 : 100, repeats(100), 0.01);
}

INSTANTIATE_TEST_SUITE_P(MotionSearch, SharedRobotInMotion, testing::ValuesIn(robotsToTest()),
                         [](const auto& robot) { return std::string(robot.param.name); });

// --- closed meshes

/// A bracket (see solids.h) as triangles, whose walls are a metre thick, and a ball of radius 0.1 that "slide" carries
/// along the x axis from (x, 0.5, 0.4) on.
class BallAndBracket : public testing::Test {
 protected:
  std::shared_ptr<const SceneModel> ballAt(double x) const {
    const std::string file = files_.write("bracket.stl", stlOf(bracket()));
    ModelOptions options;
    options.mesh_tolerance = 0.0;
    const std::string start = std::to_string(x) + " 0.5 0.4";
    return modelOf(robotOf(urdfOf(link("frame") + link("bracket", mesh(file)) + link("ball", ball("0.1")) +
                                  weld("weld", "frame", "bracket") + slider("slide", "frame", "ball", "1 0 0", start)),
                           options));
  }

  RobotTimeOfContact contact(double from, double to, double contact_distance = 0.0) const {
    const auto model = ballAt(from);
    MotionQuestion question;
    question.contact_distance = contact_distance;
    return MotionSearch(model).timeOfContact(
        std::vector<ShapeRefPair>{pairOf(*model, "bracket", "ball")},
        RobotMotion::ofTravel(model->robot, forwardKinematics(model->robot, {}), {to - from}), question);
  }
  /// Returns the minimum for the ball that stands still, with a tracking error.
  RobotMinimum minimumInTube(double x, double tracking_error) const {
    const auto model = ballAt(x);
    const Positions still(model->robot.joints.size(), 0.0);
    const Motion tube(model->robot, {0.0, still}, {1.0, still}, std::vector<double>(still.size(), tracking_error));
    return MotionSearch(model).minimum(std::vector<ShapeRefPair>{pairOf(*model, "bracket", "ball")}, tube);
  }
  RobotMinimum minimum(double from, double to) const {
    const auto model = ballAt(from);
    return MotionSearch(model).minimum(
        std::vector<ShapeRefPair>{pairOf(*model, "bracket", "ball")},
        RobotMotion::ofTravel(model->robot, forwardKinematics(model->robot, {}), {to - from}));
  }

 private:
  TemporaryFiles files_;
};

TEST_F(BallAndBracket, IsAContactFromTheStartOnInsideOfTheBracket) {
  const RobotTimeOfContact found = contact(0.5, 0.6);
  EXPECT_EQ(found.status, Status::Converged);
  ASSERT_TRUE(found.contact);
  EXPECT_EQ(found.t_contact, 0.0);
  EXPECT_EQ(found.t_free, 0.0);
  EXPECT_NEAR(found.pair.result.distance, -0.5, 1e-9);
}

TEST_F(BallAndBracket, IsAContactOfSurfacesIfItBeginsOutside) {
  const RobotTimeOfContact found = contact(3.1, 1.1);  // to the face at x = 2: 1 m of 2 m
  ASSERT_TRUE(found.contact);
  EXPECT_NEAR(found.t_contact, 0.5, 1e-5);
  EXPECT_FALSE(contact(5.0, 3.0).contact);
}

TEST_F(BallAndBracket, LeavesDepthsOpenThatItReachesLater) {
  const RobotTimeOfContact found = contact(3.1, 1.1, -0.3);
  EXPECT_EQ(found.status, Status::IterationLimit);
  EXPECT_EQ(found.t_free, 0.0);
  EXPECT_EQ(contact(0.5, 0.6, -0.3).t_contact, 0.0);
}

TEST_F(BallAndBracket, HasABoundedMinimumInsideOfTheBracket) {
  // The bottom is 0.4 below the ball's centre, everywhere between 0.4 and 1.6; outside of that a side is nearer.
  const RobotMinimum through = minimum(3.1, 1.1);
  EXPECT_NEAR(through.upper_bound, -0.5, 1e-6);
  EXPECT_LE(through.lower_bound, -0.5);
  EXPECT_GE(through.lower_bound, -0.502);
  EXPECT_NEAR(through.pair.result.distance, -0.5, 1e-6);
  const RobotMinimum inside = minimum(0.1, 0.3);
  EXPECT_NEAR(inside.upper_bound, -0.4, 2e-3);
  EXPECT_LE(inside.lower_bound, -0.4);
  EXPECT_GE(inside.lower_bound, -0.402);
}

TEST_F(BallAndBracket, HasTheMinimumOfItsPiecesOutsideOfTheBracket) {
  const RobotMinimum outside = minimum(3.1, 2.2);
  EXPECT_EQ(outside.status, Status::Converged);
  EXPECT_NEAR(outside.upper_bound, 0.1, 1e-6);
  EXPECT_NEAR(outside.lower_bound, 0.1, 1e-6);
}

// Regression: the depth counted without the tracking error as an upper bound, and with it as a lower one. So the bounds
// stayed apart, and each state was divided into a thousand intervals.
TEST_F(BallAndBracket, ATrackingErrorInsideOfTheBracketIsNotDividedInVain) {
  const RobotMinimum inside = minimumInTube(0.2, 0.01);  // the side at x = 0 is nearest
  EXPECT_EQ(inside.status, Status::Converged);
  EXPECT_NEAR(inside.lower_bound, -0.31, 1e-5);
  EXPECT_LE(inside.lower_bound, -0.31);
  EXPECT_LT(inside.counts.intervals, 100);
}

// A depth at poses far from the origin is known to their rounding only.
TEST_F(BallAndBracket, ATransformThatRoundsIsNotDividedInVain) {
  const auto model = ballAt(0.2);
  BodyPoses far = forwardKinematics(model->robot, {});
  for (auto& pose : far) pose->pretranslate(Vector3d(1e9, 0.0, 0.0));
  const RobotMinimum minimum = MotionSearch(model).minimum(std::vector<ShapeRefPair>{pairOf(*model, "bracket", "ball")},
                                                           RobotMotion::ofTravel(model->robot, far, {0.1}));
  EXPECT_EQ(minimum.status, Status::IterationLimit);
  EXPECT_NEAR(minimum.upper_bound, -0.4, 0.01);
  EXPECT_NEAR(minimum.lower_bound, -0.4, 0.01);
  EXPECT_LE(minimum.lower_bound, -0.4);
  EXPECT_LT(minimum.counts.intervals, 100);
}

// A carriage, and 1.25 from it a wheel on an axle and a ball on a swivel.
const std::string kWheel =
    urdfOf(link("carriage", box("3 1 3", "0 2 0")) +
           link("wheel", cylinder("1", "0.5", "0 0 0", "1.5707963267948966 0 0")) + link("ball", ball("0.25")) +
           hinge("axle", "carriage", "wheel", "0 1 0") + hinge("swivel", "carriage", "ball", "0.6 0 0.8", "0 2 3"));

// Regression: the wheel or the ball stood still and the carriage went round it, so that 512 queries did not prove a
// distance that never changes.
TEST(MotionSearch, MinimumOfWhatTurnsAboutItsOwnAxisConverges) {
  const std::shared_ptr<const SceneModel> model = modelOf(kWheel);
  const RobotMotion motion =
      RobotMotion::ofTravel(model->robot, forwardKinematics(model->robot, std::vector<double>{0.0, 0.0}), {4.0, 5.0});
  MotionSearch scene(model);
  for (const char* const link : {"wheel", "ball"})
    for (const ShapeRefPair& pair : {pairOf(*model, "carriage", link), pairOf(*model, link, "carriage")}) {
      const RobotMinimum minimum = scene.minimum(std::vector<ShapeRefPair>{pair}, motion);
      EXPECT_EQ(minimum.status, Status::Converged) << link;
      EXPECT_NEAR(minimum.upper_bound, 1.25, 1e-9) << link;
    }
}

}  // namespace proximity_server::scene::motion_search_test
