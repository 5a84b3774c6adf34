#include "proximity_server/scene/derivative/constraint_rows.h"

#include "from_environment.h"
#include "proximity_server/scene/batch/scene_batch.h"
#include "proximity_server/scene/derivative/free_motion.h"
#include "proximity_server/scene/inequalities/joint_inequalities.h"
#include "proximity_server/scene/levels/make_scene_model.h"
#include "proximity_server/scene/motion/motion_search.h"
#include "sanitized.h"
#include "scene/example_robots.h"
#include "scene/files.h"
#include "scene/posed_scene.h"
#include "scene/random_objects.h"
#include "scene/small_robots.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace proximity_server::scene::constraint_rows_test {

using Eigen::Vector3d;
using Eigen::VectorXd;
using Model = std::shared_ptr<const SceneModel>;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kTolerance = Question().tolerance;

// Pairs of balls have a closed form, so that rounding alone separates the two sides of an EXPECT_NEAR.
constexpr double kRounding = 1e-14;

const VelocityDamper kDamper{{0.02, 0.05}, 0.2, 0.5};

// --- robots

/// The robot with these pairs as its only candidates.
Model modelOf(const std::string& links_and_joints, std::vector<PairFilterOptions::Names> pairs) {
  PairFilterOptions options;
  options.only_pairs = std::move(pairs);
  return scene::modelOf(urdfOf(links_and_joints), options);
}

/// All pairs of the links "0", "1", ... .
std::vector<PairFilterOptions::Names> allPairs(int links) {
  std::vector<PairFilterOptions::Names> pairs;
  for (int i = 0; i < links; ++i)
    for (int k = 0; k < i; ++k) pairs.emplace_back(std::to_string(k), std::to_string(i));
  return pairs;
}

/// Links "0", "1", ... , each on a rail of its own along x, with this largest speed; every pair of them is a candidate.
Model onRails(const std::vector<std::string>& collisions_of_links, const std::string& speed = "1") {
  std::string parts = link("frame");
  for (std::size_t i = 0; i < collisions_of_links.size(); ++i) {
    const std::string name = std::to_string(i);
    parts += link(name, collisions_of_links[i]) +
             joint("rail" + name, "prismatic", "frame", name, axis("1 0 0") + limits("-9", "9", speed));
  }
  return modelOf(parts, allPairs(static_cast<int>(collisions_of_links.size())));
}

Model ballsOnRails(int balls, const std::string& speed = "1") {
  return onRails(std::vector<std::string>(static_cast<std::size_t>(balls), ball("0.1")), speed);
}

/// A robot and its rows.
struct Controlled {
  Controlled(Model robot_model, int capacity) : model(std::move(robot_model)), scene(model), rows(model, capacity) {}

  void use(const std::shared_ptr<const Objects>& objects) { scene.use(objects); }
  void place(const BodyPoses& poses) { scene.update(poses); }
  void place(const std::vector<double>& positions) { place(forwardKinematics(model->robot, positions)); }
  void update(const BodyPoses& poses, const VelocityDamper& damper = kDamper) {
    place(poses);
    rows.find(scene.scene, scene.state, damper);
  }
  void update(const std::vector<double>& positions, const VelocityDamper& damper = kDamper) {
    update(forwardKinematics(model->robot, positions), damper);
  }

  /// The row of two links, or -1.
  int rowOf(const std::string& link_a, const std::string& link_b) const {
    const int a = model->robot.findLink(link_a), b = model->robot.findLink(link_b);
    for (int i = 0; i < rows.capacity(); ++i) {
      const ConstraintRows::Row& row = rows.rows()[i];
      if (row.is_used && std::minmax(row.pair.a.link(), row.pair.b.link()) == std::minmax(a, b)) return i;
    }
    return -1;
  }

  Model model;
  PosedScene scene;
  ConstraintRows rows;
};

std::shared_ptr<const Objects> withBall(const Model& model, const std::string& id, double x) {
  Object object = makeObject(id, {{narrowphase::Sphere{0.1}}}, Fixed{at(x, 0, 0)});
  return std::make_shared<const Objects>(Objects(model).changed({AddObject{object}}));
}

bool isEmpty(const ConstraintRows& rows, int row) {
  return rows.matrix().row(row).isZero(0.0) && rows.bounds()[row] == -kInfinity && !rows.rows()[row].is_used;
}

int usedRows(const ConstraintRows& rows) {
  return static_cast<int>(std::count_if(rows.rows().begin(), rows.rows().end(),
                                        [](const ConstraintRows::Row& row) { return row.is_used; }));
}

// --- the formula

TEST(ConstraintRows, TheRowOfTwoBallsIsTheVelocityDamper) {
  Controlled robot(ballsOnRails(2), 3);
  robot.update({0.0, 0.3});  // 0.1 m apart
  const int row = robot.rowOf("0", "1");
  ASSERT_EQ(row, 0);
  EXPECT_NEAR(robot.rows.matrix()(row, 0), -1.0, kRounding);
  EXPECT_NEAR(robot.rows.matrix()(row, 1), 1.0, kRounding);
  EXPECT_NEAR(robot.rows.bounds()[row], -0.5 * (0.1 - 0.02) / (0.2 - 0.02), kTolerance);
  EXPECT_NEAR(robot.rows.rows()[0].distance, 0.1, kTolerance);
  EXPECT_TRUE(robot.rows.rows()[0].unique);
}

/// A positive bound, with the square of its row's norm.
double damped(double bound, double square) { return bound * square / (square + 0.02 * 0.02); }

TEST(ConstraintRows, AnOverlapMustRetreat) {
  Controlled robot(ballsOnRails(2), 1);
  robot.update({0.0, 0.15});  // 0.05 m deep
  EXPECT_NEAR(robot.rows.bounds()[0], damped(0.5 * (0.05 + 0.02) / (0.2 - 0.02), 2.0), kTolerance);
  EXPECT_NEAR(robot.rows.matrix()(0, 1), 1.0, kRounding);
  EXPECT_EQ(robot.rows.stuckCount(), 0);
}

TEST(ConstraintRows, ObjectsHaveTheirOwnStopDistance) {
  Controlled robot(ballsOnRails(1), 1);
  robot.use(withBall(robot.model, "ball", 0.3));
  robot.update(std::vector<double>{0.0});
  ASSERT_TRUE(robot.rows.rows()[0].is_used);
  EXPECT_NEAR(robot.rows.bounds()[0], -0.5 * (0.1 - 0.05) / (0.2 - 0.05), kTolerance);
  EXPECT_NEAR(robot.rows.matrix()(0, 0), -1.0, kRounding);
}

TEST(ConstraintRows, TheMostDemandingPairsAreChosenAcrossBothStopDistances) {
  Controlled robot(ballsOnRails(2), 1);
  robot.use(withBall(robot.model, "ball", -0.31));
  robot.update({0.0, 0.3});  // the object is 0.11 m from link 0 and nearer to its stop distance than link 1, at 0.1 m
  ASSERT_TRUE(robot.rows.rows()[0].is_used);
  EXPECT_EQ(robot.rows.rows()[0].pair.b.object(), 0);
  EXPECT_EQ(robot.rows.leftOut(), 1);
}

TEST(ConstraintRows, BoundsAreNotBelowTheFormulaInHigherPrecision) {
  Controlled robot(ballsOnRails(2), 1);
  Chance chance(1);
  int below_stop = 0;
  for (int i = 0; i < repeats(20000); ++i) {
    VelocityDamper damper{
        {chance.between(-0.1, 0.1), 0.0}, 0.0, chance.between(0.01, 2.0)};  // slow enough that it may bind
    damper.influence_distance = chance.between(0.11, 3.0);
    robot.update({0.0, chance.between(0.05, 0.3)}, damper);
    ASSERT_TRUE(robot.rows.rows()[0].is_used);
    const long double stop = damper.stop.links, influence = damper.influence_distance, gain = damper.gain;
    const long double exact = -gain * (robot.rows.rows()[0].distance - stop) / (influence - stop);
    below_stop += exact > 0.0L;
    if (exact > 0.0L) continue;  // what it must do is no promise
    ASSERT_GE(robot.rows.bounds()[0], exact);
    ASSERT_LE(robot.rows.bounds()[0], exact + 2e-15L * std::abs(exact));
  }
  EXPECT_GT(below_stop, repeats(2000));
  EXPECT_LT(below_stop, repeats(18000));
}

TEST(ConstraintRows, DistancesAreProvenAlsoWhereTheSearchForThemIsNotExact) {
  Controlled robot(arm(), 4);
  Chance chance(2);
  int used = 0;
  for (int i = 0; i < repeats(300); ++i) {
    std::vector<double> positions;
    for (std::size_t joint = 0; joint < robot.model->robot.joints.size(); ++joint)
      positions.push_back(chance.between(-3.0, 3.0));
    robot.update(positions, {{0.01, 0.01}, 1.0, 1.0});
    for (const ConstraintRows::Row& row : robot.rows.rows()) {
      if (!row.is_used) continue;
      EXPECT_EQ(row.distance, robot.scene.proximity(row.pair).result.lower_bound);
      ++used;
    }
  }
  EXPECT_GT(used, repeats(300));
}

// --- which pairs have a row

TEST(ConstraintRows, ARowThatIsNotUsedIsZeroAndBoundsNothing) {
  Controlled robot(ballsOnRails(3), 3);
  robot.update({0.0, 0.3, 0.55});
  EXPECT_EQ(usedRows(robot.rows), 2);
  robot.update({0.0, 3.0, 6.0});
  for (int row = 0; row < 3; ++row) EXPECT_TRUE(isEmpty(robot.rows, row));
  EXPECT_EQ(robot.rows.leftOut(), 0);
  EXPECT_EQ(robot.rows.unknown(), 0);
}

TEST(ConstraintRows, APairKeepsItsRowWhenACloserOneComes) {
  Controlled robot(ballsOnRails(3), 2);
  robot.update({0.0, 0.39, 3.0});
  const int row = robot.rowOf("0", "1");
  ASSERT_GE(row, 0);
  robot.update({0.0, 0.39, -0.25});  // link 2 is closer
  EXPECT_EQ(robot.rowOf("0", "1"), row);
  EXPECT_EQ(robot.rowOf("0", "2"), 1 - row);
}

TEST(ConstraintRows, TwoPairsThatAreEquallyCloseDoNotTakeTurns) {
  Controlled robot(ballsOnRails(3), 1);
  robot.update({0.0, 0.300, -0.301});
  ASSERT_EQ(robot.rowOf("0", "1"), 0);
  for (const double noise : {-0.002, 0.002, -0.003, 0.003}) {
    robot.update({noise, 0.300, -0.301});
    EXPECT_EQ(robot.rowOf("0", "1"), 0);
    EXPECT_EQ(robot.rows.leftOut(), 1);
  }
}

TEST(ConstraintRows, APairGivesWayToOneThatIsCloserByMoreThanTheKeptShare) {
  const double range = kDamper.influence_distance - kDamper.stop.links;
  const double share = ConstraintRows::kKeepShare;
  Controlled robot(ballsOnRails(3), 1);
  robot.update({0.0, 0.3, 3.0});
  robot.update({0.0, 0.3, -0.3 + 0.99 * share * range});
  EXPECT_EQ(robot.rowOf("0", "1"), 0);
  robot.update({0.0, 0.3, -0.3 + 1.01 * share * range});
  EXPECT_EQ(robot.rowOf("0", "2"), 0);
}

TEST(ConstraintRows, APairAtTheInfluenceDistanceDoesNotComeAndGo) {
  const double range = kDamper.influence_distance - kDamper.stop.links;
  const double share = ConstraintRows::kKeepShare;
  Controlled robot(ballsOnRails(2), 1);
  robot.update({0.0, 0.401});
  EXPECT_EQ(usedRows(robot.rows), 0);
  robot.update({0.0, 0.399});
  EXPECT_EQ(usedRows(robot.rows), 1);
  robot.update({0.0, 0.4 + 0.99 * share * range});
  EXPECT_EQ(usedRows(robot.rows), 1);
  EXPECT_LT(robot.rows.bounds()[0], -kDamper.gain);
  robot.update({0.0, 0.4 + 1.01 * share * range});
  EXPECT_EQ(usedRows(robot.rows), 0);
}

TEST(ConstraintRows, PairsWithoutARowAreCounted) {
  Controlled robot(ballsOnRails(4), 2);
  robot.update({0.0, 0.25, 0.5, 0.75});  // three pairs 0.05 m apart, the others 0.3 m and more
  EXPECT_EQ(usedRows(robot.rows), 2);
  EXPECT_EQ(robot.rows.leftOut(), 1);
}

TEST(ConstraintRows, APairWithoutAPoseIsUnknown) {
  Controlled robot(ballsOnRails(3), 3);
  BodyPoses poses = forwardKinematics(robot.model->robot, std::vector<double>{0.0, 0.25, 0.5});
  robot.update(poses);
  ASSERT_EQ(usedRows(robot.rows), 2);
  poses[bodyOf(robot.model->robot, "2")].reset();
  robot.update(poses);
  EXPECT_EQ(robot.rows.unknown(), 2);
  EXPECT_EQ(usedRows(robot.rows), 1);
  EXPECT_GE(robot.rowOf("0", "1"), 0);
}

TEST(ConstraintRows, APairWithADistanceButWithoutAGradientIsUnknown) {
  std::string parts = link("frame");
  for (const std::string type : {"planar", "floating"})
    parts += link(type, ball("0.1")) + joint("to " + type, type, "frame", type, axis("0 0 1"));
  Controlled robot(modelOf(parts, {{"planar", "floating"}}), 2);
  BodyPoses poses(robot.model->robot.bodies.size(), at(0, 0, 0));
  poses[bodyOf(robot.model->robot, "floating")] = at(0.3, 0, 0);
  robot.update(poses);
  ASSERT_EQ(usedRows(robot.rows), 1);
  poses[bodyOf(robot.model->robot, "frame")].reset();  // along which axes, nobody knows
  robot.update(poses);
  EXPECT_EQ(robot.rows.unknown(), 1);
  EXPECT_EQ(robot.rows.leftOut(), 0);
  EXPECT_TRUE(isEmpty(robot.rows, 0));
  EXPECT_TRUE(isEmpty(robot.rows, 1));
}

TEST(ConstraintRows, ParallelFacesAreFlagged) {
  Controlled robot(onRails({box("0.2 0.2 0.2"), box("0.2 0.2 0.2")}), 1);
  robot.update({0.0, 0.3});
  ASSERT_TRUE(robot.rows.rows()[0].is_used);
  EXPECT_FALSE(robot.rows.rows()[0].unique);
}

TEST(ConstraintRows, AnObjectThatLeavesTakesItsRowAlong) {
  Controlled robot(ballsOnRails(2), 1);
  robot.use(withBall(robot.model, "ball", 0.22));
  robot.update({0.0, 0.45});
  ASSERT_EQ(robot.rows.rows()[0].pair.b.object(), 0);
  robot.use(std::make_shared<const Objects>(robot.model));
  robot.update({0.0, 0.3});
  EXPECT_EQ(robot.rowOf("0", "1"), 0);
  EXPECT_EQ(robot.rows.leftOut(), 0);
}

TEST(ConstraintRows, AnObjectThatMayBeTouchedFromNowOnHasNoRow) {
  Controlled robot(ballsOnRails(1), 1);
  const auto objects = withBall(robot.model, "ball", 0.3);
  robot.use(objects);
  robot.update(std::vector<double>{0.0});
  ASSERT_EQ(usedRows(robot.rows), 1);
  ObjectRules rules = objects->rules();
  rules.allowed.set("0", "ball", AllowedPairs::Rule::Allowed);
  robot.use(std::make_shared<const Objects>(objects->withRules(rules)));
  robot.update(std::vector<double>{0.0});
  EXPECT_EQ(usedRows(robot.rows), 0);
}

// --- what the joints can do

/// A ball that turns about an axis through its centre, `apart` [m] above another one; as it states no speed, it is of
/// any.
Model ballOnASpindle(double apart) {
  return modelOf(link("base", ball("0.1")) + link("turning", ball("0.1", "0 0 " + std::to_string(0.2 + apart))) +
                     hinge("spindle", "base", "turning", "0 0 1"),
                 {{"base", "turning"}});
}

// Regression: the row was about 0 with a positive bound, so that no velocity kept it: a UR10 rested for ever.
TEST(ConstraintRows, APairThatNoJointPartsHasNoRowAndIsNamed) {
  Controlled robot(ballOnASpindle(0.01), 2);
  robot.update(std::vector<double>{0.3});
  EXPECT_EQ(usedRows(robot.rows), 0);
  EXPECT_EQ(robot.rows.unneeded(), 1);
  EXPECT_EQ(robot.rows.leftOut(), 0);
  ASSERT_EQ(robot.rows.stuck().size(), 1u);
  EXPECT_EQ(robot.rows.stuckCount(), 1);
  EXPECT_EQ(robot.rows.stuck()[0].rate, 0.0);
  EXPECT_NEAR(robot.rows.stuck()[0].distance, 0.01, kTolerance);
  EXPECT_EQ(robot.model->robot.links[robot.rows.stuck()[0].pair.a.link()].name, "base");
}

TEST(ConstraintRows, APairThatStaysAboveItsStopDistanceNeedsNoRow) {
  Controlled robot(ballOnASpindle(0.03), 2);
  robot.update(std::vector<double>{0.3});
  EXPECT_EQ(usedRows(robot.rows), 0);
  EXPECT_EQ(robot.rows.unneeded(), 1);
  EXPECT_EQ(robot.rows.stuckCount(), 0);
}

TEST(ConstraintRows, APairThatPartsTooSlowlyIsAskedForHalfOfWhatItCan) {
  Controlled robot(ballsOnRails(2, "0.01"), 2);
  robot.update({0.0, 0.15});  // 0.05 m deep: 0.19 m/s are asked
  ASSERT_EQ(usedRows(robot.rows), 1);
  EXPECT_NEAR(robot.rows.bounds()[0], 0.5 * 0.02, kTolerance);
  ASSERT_EQ(robot.rows.stuck().size(), 1u);
  EXPECT_NEAR(robot.rows.stuck()[0].rate, 0.02, kTolerance);
  EXPECT_EQ(robot.rows.unneeded(), 0);
}

// Its wheel of 5 mm hardly changes the distance, so that the bound itself would ask for 19 rad/s.
TEST(ConstraintRows, APairThatHardlyPartsIsAskedForLittle) {
  const std::string turn = origin("0 0.21 0") + axis("0 0 1") + limits("-3", "3", "20");
  Controlled robot(modelOf(link("base", ball("0.1")) + link("cam", ball("0.1", "0.005 0 0")) +
                               joint("turn", "revolute", "base", "cam", turn),
                           {{"base", "cam"}}),
                   1);
  robot.update(std::vector<double>{0.0});
  ASSERT_EQ(usedRows(robot.rows), 1);
  const double gradient = robot.rows.matrix()(0, 0), asked = 0.5 * (0.02 - robot.rows.rows()[0].distance) / 0.18;
  EXPECT_NEAR(gradient, 0.005, 1e-5);
  EXPECT_NEAR(robot.rows.bounds()[0], damped(asked, gradient * gradient), kTolerance);
  EXPECT_LT(robot.rows.bounds()[0] / gradient, 0.5);
}

TEST(ConstraintRows, APairThatIsTooSlowToComeTooNearNeedsNoRow) {
  Controlled robot(ballsOnRails(2, "0.01"), 1);
  robot.update({0.0, 0.35});  // it may approach at 0.36 m/s
  EXPECT_EQ(usedRows(robot.rows), 0);
  EXPECT_EQ(robot.rows.unneeded(), 1);
  const double spare = ConstraintRows::kSpareShare + 0.02 / kDamper.gain;
  robot.update({0.0, 0.2 + 0.02 + 1.01 * spare * 0.18});
  EXPECT_EQ(usedRows(robot.rows), 0);
  robot.update({0.0, 0.2 + 0.02 + 0.99 * spare * 0.18});
  EXPECT_EQ(usedRows(robot.rows), 1);
  EXPECT_EQ(robot.rows.unneeded(), 0);
}

TEST(ConstraintRows, JointsThatTheControllerDoesNotMoveCountAsAtRest) {
  const Model model = ballsOnRails(4);
  Controlled robot(model, 3);
  robot.rows = ConstraintRows(model, 3, {0});
  robot.update({0.0, 0.3, 0.51, 0.72});  // links 2 and 3 are 0.01 m apart, links 1 and 2 as well
  ASSERT_EQ(usedRows(robot.rows), 1);
  EXPECT_EQ(robot.rowOf("0", "1"), 0);
  EXPECT_NEAR(robot.rows.matrix()(0, 0), -1.0, kRounding);
  EXPECT_EQ(robot.rows.matrix()(0, 1), 0.0);
  EXPECT_EQ(robot.rows.unneeded(), 2);
  EXPECT_EQ(robot.rows.stuckCount(), 2);
  EXPECT_EQ(robot.rows.leftOut(), 0);
}

TEST(ConstraintRows, StuckPairsAreNamedMostDemandingFirstAsManyAsThereAreRows) {
  const Model model = ballsOnRails(4);
  Controlled robot(model, 2);
  robot.rows = ConstraintRows(model, 2, {0});
  robot.update({-3.0, 0.0, 0.205, 0.42});  // 5 mm, 15 mm; links 1 and 3 are 0.22 m apart
  ASSERT_EQ(robot.rows.stuck().size(), 2u);
  EXPECT_NEAR(robot.rows.stuck()[0].distance, 0.005, kTolerance);
  EXPECT_NEAR(robot.rows.stuck()[1].distance, 0.015, kTolerance);
  robot.update({-3.0, 0.0, 0.205, 0.21});
  EXPECT_EQ(robot.rows.stuck().size(), 2u);
  EXPECT_EQ(robot.rows.stuckCount(), 3);
}

TEST(ConstraintRows, AColumnThatDoesNotExistIsRefused) {
  EXPECT_THROW(ConstraintRows(ballsOnRails(2), 1, {2}), std::invalid_argument);
  EXPECT_THROW(ConstraintRows(ballsOnRails(2), 1, {-1}), std::invalid_argument);
}

TEST(ConstraintRows, EachPairHasItsOwnStopDistance) {
  Controlled robot(ballsOnRails(3), 1);
  VelocityDamper damper = kDamper;
  const auto link = [&](const char* name) { return robot.model->robot.findLink(name); };
  damper.stop.setPair(link("2"), link("0"), 0.1);
  robot.update({0.0, 0.28, -0.31}, damper);  // of link 1 the share is 0.06 / 0.18, of link 2 it is 0.01 / 0.1
  ASSERT_EQ(robot.rowOf("0", "2"), 0);
  EXPECT_NEAR(robot.rows.bounds()[0], -0.5 * 0.01 / 0.1, kTolerance);
  EXPECT_EQ(robot.rows.leftOut(), 1);
}

// --- what is refused

std::string refusal(const VelocityDamper& damper) {
  Controlled robot(ballsOnRails(2), 1);
  const std::string text = errorOf([&] { robot.update({0.0, 0.3}, damper); });
  EXPECT_EQ(isEmpty(robot.rows, 0), !text.empty());
  return text;
}

TEST(ConstraintRows, BadSettingsAreRefusedByName) {
  EXPECT_EQ(refusal({{kNaN, 0.0}, 0.2, 1.0}).find("stop_distance is"), 0U);
  EXPECT_EQ(refusal({{0.0, kNaN}, 0.2, 1.0}).find("object_stop_distance is"), 0U);
  EXPECT_EQ(refusal({{0.0, 0.0}, kInfinity, 1.0}).find("influence_distance is"), 0U);
  EXPECT_EQ(refusal({{0.0, 0.0}, 0.2, kInfinity}).find("gain is"), 0U);
  EXPECT_EQ(refusal({{0.0, 0.0}, 0.2, 0.0}), "gain is 0.000000: it is not positive");
  EXPECT_EQ(refusal({{0.2, 0.0}, 0.2, 1.0}), "influence_distance is 0.200000: it is not above stop_distance");
  EXPECT_EQ(refusal({{0.0, 0.3}, 0.2, 1.0}), "influence_distance is 0.200000: it is not above object_stop_distance");
  EXPECT_EQ(refusal({{-0.01, 0.0}, 0.2, 1.0}), "");  // a pair may overlap so much
}

TEST(ConstraintRows, NoRowAtAllIsRefused) { EXPECT_THROW(ConstraintRows(ballsOnRails(2), 0), std::invalid_argument); }

// --- from update to update

/// The steps of a random walk; and how many robots are driven to a stop.
const int kSteps = static_cast<int>(fromEnvironment("PROXIMITY_ROW_STEPS", repeats(2000)));
const int kRobots = std::max(1, kSteps / 70);

/// The robot of ./dev demo, loaded once. Its meshes take a sanitizer minutes: there it is an arm without meshes.
Model demoOrArm() {
  static const Model model = kIsSanitized ? arm() : demoModel();
  return model;
}

/// Every joint goes up to `step` [rad, m] either way, within its limits.
void walk(const RobotModel& robot, Chance& chance, double step, std::vector<double>& positions) {
  for (std::size_t i = 0; i < positions.size(); ++i) {
    const double lower = std::max(robot.joints[i].lower, -3.0), upper = std::min(robot.joints[i].upper, 3.0);
    positions[i] = std::clamp(positions[i] + chance.between(-step, step), lower, upper);
  }
}

bool isSame(const ShapeRefPair& a, const ShapeRefPair& b) { return a.a == b.a && a.b == b.b; }

int rowWith(const std::vector<ConstraintRows::Row>& rows, const ShapeRefPair& pair) {
  const auto found = std::find_if(
      rows.begin(), rows.end(), [&](const ConstraintRows::Row& row) { return row.is_used && isSame(row.pair, pair); });
  return found == rows.end() ? -1 : static_cast<int>(found - rows.begin());
}

/// Whether a velocity within the limits of the joints, with some more, may break what the damper asks of a pair.
bool mayBind(const Controlled& robot, const PairProximity& pair, const VelocityDamper& damper) {
  const DegreesOfFreedom& columns = robot.scene.state.degreesOfFreedom();
  VectorXd gradient(columns.size());
  EXPECT_TRUE(scene::gradient(robot.scene.state, pair, gradient));
  double rate = 0.0;
  for (int column = 0; column < columns.size(); ++column)
    if (std::abs(gradient[column]) > ConstraintRows::kNoChange)
      rate += std::abs(gradient[column]) * robot.model->robot.joints[columns[column].joint].max_velocity;
  const double stop = damper.stop.of(pair.asked);
  const double share = (pair.result.lower_bound - stop) / (damper.influence_distance - stop);
  return rate > 0.0 && rate > damper.gain * (share - ConstraintRows::kSpareShare);
}

/// Checks the promises of the rows about one update by the answers of another scene, which has asked for all pairs.
void expectStable(const std::vector<ConstraintRows::Row>& before, const Controlled& robot,
                  std::vector<PairProximity> below, const VelocityDamper& damper) {
  const ConstraintRows& rows = robot.rows;
  const auto capacity = static_cast<std::size_t>(rows.capacity());
  const auto within = static_cast<int>(below.size());
  const auto needs_none = [&](const PairProximity& pair) { return !mayBind(robot, pair, damper); };
  below.erase(std::remove_if(below.begin(), below.end(), needs_none), below.end());
  EXPECT_EQ(rows.unneeded(), within - static_cast<int>(below.size()));
  const double range = damper.influence_distance - damper.stop.links;
  double farthest = -kInfinity;
  int in_reach = 0;
  for (const ConstraintRows::Row& row : rows.rows()) {
    if (!row.is_used) continue;
    farthest = std::max(farthest, row.distance);
    in_reach += row.distance <= damper.influence_distance;
  }
  EXPECT_LE(farthest, damper.influence_distance + ConstraintRows::kKeepShare * range + kTolerance);
  EXPECT_EQ(rows.leftOut(), static_cast<int>(below.size()) - in_reach);
  for (std::size_t i = 0; i < below.size(); ++i) {
    const int row = rowWith(rows.rows(), below[i].asked), row_before = rowWith(before, below[i].asked);
    if (row < 0) {
      EXPECT_EQ(usedRows(rows), rows.capacity());
      EXPECT_GE(below[i].result.distance, farthest - ConstraintRows::kKeepShare * range - kTolerance);
    }
    if (row_before < 0) continue;
    if (row >= 0 || i < capacity) {
      EXPECT_EQ(row, row_before);
    }
  }
}

void expectStableWalk(const Model& model, const VelocityDamper& damper, int capacity, int steps) {
  Controlled robot(model, capacity);
  PosedScene other(model);
  Chance chance(3);
  std::vector<double> positions(model->robot.joints.size(), 0.0);
  walk(model->robot, chance, 0.5, positions);
  Question within;
  within.threshold = damper.influence_distance;
  int given = 0, crowded = 0;
  for (int step = 0; step < steps; ++step) {
    walk(model->robot, chance, 0.05, positions);
    const BodyPoses poses = forwardKinematics(model->robot, positions);
    const std::vector<ConstraintRows::Row> before = robot.rows.rows();
    robot.update(poses, damper);
    other.update(poses);
    expectStable(before, robot, other.below(other.candidates(), within), damper);
    crowded += robot.rows.leftOut() > 0;
    for (const ConstraintRows::Row& row : robot.rows.rows()) given += row.is_used && rowWith(before, row.pair) < 0;
  }
  if (kIsSanitized) return;
  EXPECT_GT(given, 20);
  EXPECT_GT(crowded, steps / 5);
}

TEST(ConstraintRows, RowsStayInPlaceOnARandomWalkOfTheDemoRobot) {
  expectStableWalk(demoOrArm(), {{0.02, 0.02}, 0.3, 0.5}, 6, kSteps);
}

TEST(ConstraintRows, RowsStayInPlaceOnARandomWalkOfPanda) {
  const MeshResolver resolve = exampleRobotsResolver();
  if (!findsExampleRobots(resolve)) GTEST_SKIP() << kExampleRobotsMissing;
  expectStableWalk(scene::modelOf(kExampleRobots[0], resolve), {{0.02, 0.02}, 0.35, 0.5}, 3, kSteps);
}

// --- what the rows are for

/// The velocity nearest to the wanted one that keeps all rows: Hildreth's method on the dual.
VectorXd nearestAllowed(const ConstraintRows& rows, const VectorXd& wanted) {
  VectorXd velocity = wanted, multipliers = VectorXd::Zero(rows.capacity());
  for (int sweep = 0; sweep < 20000; ++sweep) {
    double change = 0.0;
    for (int i = 0; i < rows.capacity(); ++i) {
      const auto row = rows.matrix().row(i);
      if (row.isZero(0.0)) continue;
      const double step = std::max(-multipliers[i], (rows.bounds()[i] - row.dot(velocity)) / row.squaredNorm());
      multipliers[i] += step;
      velocity += step * row.transpose();
      change = std::max(change, std::abs(step) * row.norm());
    }
    if (change < 1e-14) break;
  }
  return velocity;
}

/// How far [m/s] a velocity misses the worst of the rows.
double violation(const ConstraintRows& rows, const VectorXd& velocity) {
  return (rows.bounds() - rows.matrix() * velocity).maxCoeff();
}

/// Towards the target at no more than 1 rad/s or m/s.
VectorXd towards(const std::vector<double>& positions, const std::vector<double>& target) {
  VectorXd velocity(positions.size());
  for (std::size_t i = 0; i < positions.size(); ++i)
    velocity[static_cast<Eigen::Index>(i)] = std::clamp(5.0 * (target[i] - positions[i]), -1.0, 1.0);
  return velocity;
}

std::string randomShape(Chance& chance) {
  const auto number = [&](double low, double high) { return std::to_string(chance.between(low, high)); };
  const std::string rpy = number(-3, 3) + " " + number(-1, 1) + " " + number(-3, 3);
  switch (chance.below(3)) {
    case 0:
      return ball(number(0.05, 0.2));
    case 1:
      return box(number(0.1, 0.4) + " " + number(0.1, 0.4) + " " + number(0.1, 0.4), "0 0 0", rpy);
    default:
      return cylinder(number(0.05, 0.15), number(0.1, 0.4), "0 0 0", rpy);
  }
}

/// Convex shapes, turned in any way, each on three rails.
Model gantry(Chance& chance, int shapes) {
  std::string parts = link("frame");
  for (int i = 0; i < shapes; ++i) {
    const std::string name = std::to_string(i);
    parts += link("x" + name) + link("y" + name) + link(name, randomShape(chance)) +
             slider("to x" + name, "frame", "x" + name, "1 0 0") +
             slider("to y" + name, "x" + name, "y" + name, "0 1 0") + slider("to " + name, "y" + name, name, "0 0 1");
  }
  return modelOf(parts, allPairs(shapes));
}

std::vector<double> anywhere(Chance& chance, std::size_t joints, double reach) {
  std::vector<double> positions;
  for (std::size_t i = 0; i < joints; ++i) positions.push_back(chance.between(-reach, reach));
  return positions;
}

/// The smallest distance of the robot's candidates.
double clearance(PosedScene& scene, const BodyPoses& poses) {
  scene.update(poses);
  return scene.minimum(scene.candidates())->result.distance;
}

// The distance of two convex shapes that do not turn is a convex function of their positions, so that it never falls
// below what the gradient says, whichever of several closest points that is for: the damper holds in every step, not
// only in the limit of small ones.
TEST(ConstraintRows, ShapesThatOnlyShiftNeverComeBelowTheStopDistance) {
  constexpr double kStep = 0.01;  // [s]
  const VelocityDamper damper{{0.03, 0.03}, 0.2, 2.0};
  Chance chance(6);
  int arrived_at_stop = 0, would_overlap = 0;
  for (int robot_number = 0; robot_number < kRobots; ++robot_number) {
    Controlled robot(gantry(chance, 5), 10);
    std::vector<double> positions = anywhere(chance, 15, 1.0);
    while (clearance(robot.scene, forwardKinematics(robot.model->robot, positions)) < damper.stop.links)
      positions = anywhere(chance, 15, 1.0);
    const std::vector<double> target = anywhere(chance, 15, 0.1);
    would_overlap += clearance(robot.scene, forwardKinematics(robot.model->robot, target)) < 0.0;
    double smallest = kInfinity;
    for (int step = 0; step < 300; ++step) {
      robot.update(positions, damper);
      ASSERT_EQ(robot.rows.leftOut(), 0);
      const VectorXd velocity = nearestAllowed(robot.rows, towards(positions, target));
      ASSERT_LE(violation(robot.rows, velocity), 1e-9);
      for (std::size_t i = 0; i < positions.size(); ++i) positions[i] += kStep * velocity[static_cast<Eigen::Index>(i)];
      const double distance = clearance(robot.scene, forwardKinematics(robot.model->robot, positions));
      ASSERT_GE(distance, damper.stop.links - 10 * kTolerance);
      smallest = std::min(smallest, distance);
    }
    arrived_at_stop += smallest < damper.stop.links + 1e-3;
  }
  if (kIsSanitized) return;
  EXPECT_GT(arrived_at_stop, kRobots * 2 / 3);
  EXPECT_GT(would_overlap, kRobots * 2 / 3);
}

constexpr double kArmLength = 0.9;  // [m]

/// Two arms of three balls each, whose joints have any axes.
Model armsOfBalls(Chance& chance) {
  std::string parts = link("frame");
  std::vector<PairFilterOptions::Names> pairs;
  const auto randomAxis = [&] {
    const Vector3d direction = chance.direction();
    return std::to_string(direction.x()) + " " + std::to_string(direction.y()) + " " + std::to_string(direction.z());
  };
  for (const std::string side : {"left", "right"}) {
    std::string parent = "frame";
    for (int i = 0; i < 3; ++i) {
      const std::string name = side + std::to_string(i);
      const std::string start = i > 0 ? "0.3 0 0" : side == "left" ? "0 0.25 0" : "0 -0.25 0";
      parts += link(name, ball("0.1", "0.3 0 0")) + hinge("to " + name, parent, name, randomAxis(), start);
      parent = name;
      if (side == "left")
        for (int k = 0; k < 3; ++k) pairs.emplace_back(name, "right" + std::to_string(k));
    }
  }
  return modelOf(parts, pairs);
}

// The distance of two balls is a convex function of their centres. In a step an arm turns by s = sum |dq| at most, and
// the centre of a ball leaves the straight line that its velocity says by at most s^2 length / 2. So the deficit below
// the stop distance is at most what was left of the last one, and what both balls lose.
TEST(ConstraintRows, ArmsComeBelowTheStopDistanceByNoMoreThanTheirCurvatureInAStep) {
  constexpr double kStep = 1e-3;  // [s]
  const VelocityDamper damper{{0.03, 0.03}, 0.2, 1.0};
  const double left_over = 1.0 - damper.gain * kStep / (damper.influence_distance - damper.stop.links);
  Chance chance(7);
  int arrived_at_stop = 0, would_overlap = 0;
  for (int robot_number = 0; robot_number < kRobots; ++robot_number) {
    Controlled robot(armsOfBalls(chance), 9);
    std::vector<double> positions = anywhere(chance, 6, M_PI), target = anywhere(chance, 6, M_PI);
    while (clearance(robot.scene, forwardKinematics(robot.model->robot, positions)) < damper.stop.links)
      positions = anywhere(chance, 6, M_PI);
    for (int i = 0; i < 1000 && clearance(robot.scene, forwardKinematics(robot.model->robot, target)) > -0.05; ++i)
      target = anywhere(chance, 6, M_PI);
    would_overlap += clearance(robot.scene, forwardKinematics(robot.model->robot, target)) < 0.0;
    double deficit = 0.0, smallest = kInfinity;
    for (int step = 0; step < 4000; ++step) {
      robot.update(positions, damper);
      ASSERT_EQ(robot.rows.leftOut(), 0);
      const VectorXd velocity = nearestAllowed(robot.rows, towards(positions, target));
      ASSERT_LE(violation(robot.rows, velocity), 1e-9);
      for (std::size_t i = 0; i < positions.size(); ++i) positions[i] += kStep * velocity[static_cast<Eigen::Index>(i)];
      const double left = kStep * velocity.head<3>().lpNorm<1>(), right = kStep * velocity.tail<3>().lpNorm<1>();
      deficit = left_over * deficit + 0.5 * kArmLength * (left * left + right * right);
      const double distance = clearance(robot.scene, forwardKinematics(robot.model->robot, positions));
      ASSERT_GE(distance, damper.stop.links - deficit - 10 * kTolerance);
      ASSERT_LT(deficit, 2e-3);
      smallest = std::min(smallest, distance);
    }
    arrived_at_stop += smallest < damper.stop.links + 1e-3;
  }
  if (kIsSanitized) return;
  EXPECT_GT(arrived_at_stop, kRobots / 3);
  EXPECT_GT(would_overlap, kRobots * 2 / 3);
}

// Regression: each of them crashed.
TEST(WithoutAModel, NothingCanBeAsked) {
  const std::shared_ptr<const SceneModel> none;
  EXPECT_THROW(Scene{none}, std::invalid_argument);
  EXPECT_THROW(State{none}, std::invalid_argument);
  EXPECT_THROW(MotionSearch{none}, std::invalid_argument);
  EXPECT_THROW(SceneBatch{none}, std::invalid_argument);
  EXPECT_THROW(Objects{none}, std::invalid_argument);
  EXPECT_THROW(Derivatives{none}, std::invalid_argument);
  EXPECT_THROW(FreeMotion{none}, std::invalid_argument);
  EXPECT_THROW(ConstraintRows(none, 1), std::invalid_argument);
  EXPECT_THROW(ConstraintRows(none, 1, {}), std::invalid_argument);
}

/// "rail0" to "rail2" with these inequalities.
Model coupledRails(const std::string& inequalities) {
  RobotModel robot = ballsOnRails(3)->robot;
  setJointInequalities(readYaml(inequalities, ""), "", robot);
  return scene::modelOf(std::move(robot));
}

TEST(InequalityRows, LetAnExcessGrowExponentiallyTowardsZero) {
  const Model model = coupledRails("- 2*rail0 - rail1 <= 1\n- -2 <= rail2 + rail0");
  InequalityRows rows(model, {0, 1, 2});
  ASSERT_TRUE(rows.update(forwardKinematics(model->robot, {0.25, 0.0, -1.0}), {}, 4.0));
  Eigen::MatrixXd expected(2, 3);
  expected << -2, 1, 0, 1, 0, 1;
  EXPECT_EQ(rows.matrix(), expected);
  EXPECT_NEAR(rows.bounds()[0], -4.0 * 0.5, kRounding);
  EXPECT_NEAR(rows.bounds()[1], -4.0 * 1.25, kRounding);
}

TEST(InequalityRows, AskForNoMoreThanTheJointsCanDo) {
  const Model model = coupledRails("- 2*rail0 - rail1 <= 1");
  InequalityRows rows(model, {0, 1, 2});
  ASSERT_TRUE(rows.update(forwardKinematics(model->robot, {0.6, 0.0, 0.0}), {}, 4.0));
  EXPECT_NEAR(rows.bounds()[0], 4.0 * 0.2, kRounding);
  ASSERT_TRUE(rows.update(forwardKinematics(model->robot, {3.0, 0.0, 0.0}), {}, 4.0));
  EXPECT_NEAR(rows.bounds()[0], 3.0, kRounding);  // 2 m/s + 1 m/s
}

// Regression: the rows asked for half of what the joints can do, so that the sum returned more slowly than promised.
TEST(InequalityRows, LetABrokenSumReturnExponentially) {
  const Model model = coupledRails("- 2*rail0 - rail1 <= 1");
  const double rate = 4.0, step = 1e-3;
  InequalityRows rows(model, {0, 1, 2});
  const JointInequality& inequality = model->robot.inequalities.front();
  Vector3d state(0.85, 0.0, 0.0);  // an excess of 0.7 asks for 2.8 of the 3 m/s
  double allowed = inequality.excess({state[0], state[1], state[2]});
  for (int i = 0; i < 1000; ++i) {
    ASSERT_TRUE(rows.update(forwardKinematics(model->robot, {state[0], state[1], state[2]}), {}, rate));
    const double share = rows.bounds()[0] / 3.0;  // of the largest velocities, 1 m/s of each rail
    ASSERT_LE(share, 1.0);
    state += step * share * Vector3d(-1.0, 1.0, 0.0);
    allowed *= 1.0 - rate * step;
    EXPECT_LE(inequality.excess({state[0], state[1], state[2]}), allowed + 1e-9) << i;
  }
}

TEST(InequalityRows, AreOfTheColumnsThatMove) {
  const Model model = coupledRails("- 2*rail0 - rail1 <= 1\n- rail0 <= 5");
  InequalityRows rows(model, {1, 2});
  BodyPoses poses = forwardKinematics(model->robot, {0.25, 0.0, 0.0});
  ASSERT_TRUE(rows.update(poses, {}, 4.0));
  EXPECT_EQ(rows.matrix().row(0), Eigen::RowVector3d(0, 1, 0));
  EXPECT_NEAR(rows.bounds()[0], -2.0, kRounding);
  EXPECT_TRUE(rows.matrix().row(1).isZero(0.0));
  EXPECT_EQ(rows.bounds()[1], -kInfinity);
  poses[bodyOf(model->robot, "0")].reset();
  EXPECT_FALSE(rows.update(poses, {}, 4.0));
}

TEST(InequalityRows, KeepARobotWithinWhatTheyAllow) {
  const Model model = coupledRails("- 2*rail0 - rail1 + rail2 <= 1");
  InequalityRows rows(model, {0, 1, 2});
  const JointInequality& inequality = model->robot.inequalities.front();
  VectorXd state = VectorXd::Zero(3);
  const Vector3d wanted(1.0, -1.0, 1.0);
  double last = inequality.excess({0, 0, 0});
  for (int step = 0; step < 500; ++step) {
    ASSERT_TRUE(rows.update(forwardKinematics(model->robot, {state[0], state[1], state[2]}), {}, 5.0));
    const Vector3d row = rows.matrix().row(0);
    const double lack = std::max(0.0, rows.bounds()[0] - row.dot(wanted));
    state += 0.1 * (wanted + lack * row / row.squaredNorm());
    const double excess = inequality.excess({state[0], state[1], state[2]});
    EXPECT_LE(excess, 1e-12);
    EXPECT_GE(excess, last - 1e-12);
    last = excess;
  }
  EXPECT_NEAR(last, 0.0, 1e-9);
}

}  // namespace proximity_server::scene::constraint_rows_test
