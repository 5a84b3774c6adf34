#include "proximity_server/scene/guaranteed/guaranteed_distances.h"

#include "laws/refusals.h"
#include "proximity_server/scene/loading/joined_robots.h"
#include "proximity_server/scene/model/names.h"
#include "proximity_server/scene/motion/frames_on_links.h"
#include "sanitized.h"
#include "scene/derivative/moved_robot.h"
#include "scene/posed_scene.h"
#include "scene/random_objects.h"
#include "scene/uncertainty/uncertain_states.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace proximity_server::scene::guaranteed_distances_test {

using Eigen::Vector3d;

/// A ball of radius 0.1 on an arm: "swing" turns about z at the origin, "reach" moves it along x, the ball is at (2, 0,
/// 0.5); a post stands at (0, 3, 0.5), with a radius of 0.5.
const std::string kCrane =
    urdfOf(link("post", ball("0.5", "0 3 0.5")) + link("mast") + link("hook", ball("0.1")) +
           hinge("swing", "post", "mast", "0 0 1") + slider("reach", "mast", "hook", "1 0 0", "2 0 0.5"));
const double kCraneDistance = std::sqrt(13.0) - 0.6;

/// Two links of a robot whose joints are at 0.
struct LinksAtZero {
  LinksAtZero(const std::shared_ptr<const SceneModel>& model, const Uncertainty& uncertainty, const char* a,
              const char* b)
      : scene(model), distances(model), poses(forwardKinematics(model->robot, {})) {
    scene.update(poses);
    distances.assume(uncertainty);
    pair = scene.proximity(pairOf(*model, a, b));
  }
  PosedScene scene;
  GuaranteedDistances distances;
  BodyPoses poses;
  PairProximity pair;
};

double guaranteed(const std::shared_ptr<const SceneModel>& model, const Uncertainty& uncertainty, const char* a,
                  const char* b) {
  LinksAtZero links(model, uncertainty, a, b);
  return links.distances.of(links.scene.state, links.pair);
}

TEST(GuaranteedDistances, LosesTheWayAlongTheNormal) {
  const auto model = modelOf(kCrane);
  Uncertainty uncertainty(model->robot);
  uncertainty.positions = {1e-3, 0.0};
  // The ball moves along y by 2 mm, and the normal has 3 parts of sqrt(13) along y.
  EXPECT_NEAR(guaranteed(model, uncertainty, "hook", "post"), kCraneDistance - 2e-3 * 3.0 / std::sqrt(13.0), 2e-6);
  uncertainty.positions = {0.0, 1e-3};
  EXPECT_NEAR(guaranteed(model, uncertainty, "post", "hook"), kCraneDistance - 1e-3 * 2.0 / std::sqrt(13.0), 1e-9);
}

TEST(GuaranteedDistances, FrameLosesItsTranslationAndItsAngleTimesTheLever) {
  const auto model = modelOf(kCrane);
  Uncertainty uncertainty(model->robot);
  uncertainty.frames[0].translation = 0.003;
  EXPECT_NEAR(guaranteed(model, uncertainty, "post", "hook"), kCraneDistance - 0.003, 1e-9);
  uncertainty.frames[0] = {0.0, 1e-3};
  // The ball is at (2, 0, 0.5), and the normal (-2, 3, 0) / sqrt(13).
  const double lever = Vector3d(2.0, 0.0, 0.5).cross(Vector3d(-2.0, 3.0, 0.0) / std::sqrt(13.0)).norm();
  EXPECT_NEAR(guaranteed(model, uncertainty, "post", "hook"), kCraneDistance - 1e-3 * lever, 3e-6);
}

// A half-space behind x = -2 that turns with the mast: it comes nearer to the ball of the post, whose centre is (0, 3, 0.5).
TEST(GuaranteedDistances, HalfSpacesThatTurnLoseTheDistanceOfTheOther) {
  const auto model = modelOf(kCrane);
  const Object wall = makeObject("wall", {{HalfSpace{{1, 0, 0}, -2.0}}}, Moving{"mast"});
  const auto objects = std::make_shared<const Objects>(Objects(model).changed({AddObject{wall}}));
  PosedScene scene(model);
  scene.use(objects, carriersOnLinks(*objects));
  GuaranteedDistances distances(model);
  const BodyPoses poses = forwardKinematics(model->robot, {});
  setPoses(scene.state, poses);
  Uncertainty uncertainty(model->robot);
  uncertainty.positions = {0.1, 0.0};
  distances.assume(uncertainty);
  const PairProximity pair =
      scene.proximity({ShapeRef(model->robot.findLink("post")), ShapeRef::ofObject(objects->find("wall"))});
  ASSERT_NEAR(pair.result.distance, 1.5, 1e-9);
  const double nearest = 2.0 - 0.5 - 3.0 * std::sin(0.1);
  EXPECT_LE(distances.of(scene.state, pair, 1.3), nearest);
  EXPECT_LE(distances.of(scene.state, pair), nearest);
  EXPECT_GE(distances.of(scene.state, pair), nearest - 0.05);
}

TEST(GuaranteedDistances, SurfacesLoseTheirSwelling) {
  const auto model = modelOf(kCrane);
  Uncertainty uncertainty(model->robot);
  uncertainty.swellings = {0.002, 0.5, 0.005};
  EXPECT_NEAR(guaranteed(model, uncertainty, "post", "hook"), kCraneDistance - 0.007, 1e-9);
}

TEST(GuaranteedDistances, BallThatPassesByIsBoundedByItsClosestApproach) {
  const auto model = modelOf(urdfOf(link("post", ball("0.1")) + link("cart", ball("0.1")) +
                                    slider("pass", "post", "cart", "0.6 0 -0.8", "0 0 0.5")));
  Uncertainty uncertainty(model->robot);
  uncertainty.positions[0] = 0.45;
  // The line passes the post at 0.3; along the direction of now the ball comes down to 0.5 - 0.8 * 0.45.
  const double bound = guaranteed(model, uncertainty, "post", "cart");
  EXPECT_LE(bound, 0.3 - 0.2);
  EXPECT_GT(bound, 0.9 * (0.3 - 0.2));
}

TEST(GuaranteedDistances, StretchedArmLosesItsSecondOrder) {
  const auto model =
      modelOf(urdfOf(link("wall", box("0.2 4 4", "-1 0 0")) + link("upper") + link("tip", ball("0.1", "1 0 0")) +
                     hinge("shoulder", "wall", "upper", "0 0 1") + hinge("elbow", "upper", "tip", "0 0 1", "1 0 0")));
  Uncertainty uncertainty(model->robot);
  constexpr double kAngle = 0.05;
  uncertainty.positions = {kAngle, kAngle};
  const double loss = 2.0 - std::cos(kAngle) - std::cos(2.0 * kAngle);
  const double bound = guaranteed(model, uncertainty, "wall", "tip");
  EXPECT_LE(bound, 2.8 - loss);
  EXPECT_GT(bound, 2.8 - 1.25 * loss);
}

TEST(GuaranteedDistances, JointsThatCarryBothLoseNothing) {
  const auto model =
      modelOf(urdfOf(link("base") + link("table", ball("0.1", "0 0 1")) + link("lift", ball("0.1", "1 0 1")) +
                     hinge("turn", "base", "table", "0 0 1") + slider("up", "table", "lift", "1 0 0")));
  Uncertainty uncertainty(model->robot);
  uncertainty.positions = {0.5, 0.01};
  uncertainty.bases[0] = {0.5, 0.5};
  EXPECT_NEAR(guaranteed(model, uncertainty, "table", "lift"), 0.8 - 0.01, 1e-9);
}

TEST(GuaranteedDistances, FollowersOfOneLeaderMoveTogether) {
  const auto fingers = [](const char* multiplier) {
    return modelOf(urdfOf(
        link("palm") + link("left", ball("0.1")) + link("tip", ball("0.1", "0 0 0")) +
        link("wall", ball("0.1", "1 0 0")) + slider("open", "palm", "left", "1 0 0") +
        joint("follow", "prismatic", "left", "tip", axis("1 0 0") + limits("-1", "1") + mimic("open", multiplier)) +
        weld("stand", "palm", "wall")));
  };
  Uncertainty uncertainty(fingers("-1")->robot);
  uncertainty.positions[0] = 0.01;
  EXPECT_NEAR(guaranteed(fingers("-1"), uncertainty, "tip", "wall"), 0.8, 1e-9);
  EXPECT_NEAR(guaranteed(fingers("2"), uncertainty, "tip", "wall"), 0.8 - 0.03, 1e-9);
}

// The carriage follows the turn of the arm so that to first order the ball at its end stays where it is: it is at
// x = sin t - t.
TEST(GuaranteedDistances, ATurnAndASlideOfOneLeaderDoNotCancelEachOther) {
  const auto model = modelOf(urdfOf(
      link("base") + link("carriage") + link("arm", ball("0.05", "0 -1 0")) +
      link("wall", "<collision><origin xyz=\"6 0 0\"/><geometry><box size=\"2 20 20\"/></geometry></collision>") +
      joint("follow", "prismatic", "base", "carriage", axis("1 0 0") + limits("-3", "3") + mimic("turn", "-1")) +
      hinge("turn", "carriage", "arm", "0 0 1") + weld("stand", "base", "wall")));
  Uncertainty uncertainty(model->robot);
  uncertainty.positions[scene::findNamed(model->robot.joints, "turn")] = 2.0;
  EXPECT_LE(guaranteed(model, uncertainty, "arm", "wall"), 5.0 - 0.05 - (2.0 - std::sin(2.0)));
}

// Two boards 0.4 m wide face each other. They turn together, so that they stay parallel: the gap of their faces is
// 0.5 cos(t) - 0.02 at most, and no fixed direction shows it, because it cannot turn with them.
TEST(GuaranteedDistances, DirectionsOfPartsTurnWithTheBoards) {
  const auto model =
      modelOf(urdfOf(link("base") + link("left", box("0.02 0.4 0.4")) + link("right", box("0.02 0.4 0.4")) +
                     hinge("turn", "base", "left", "0 0 1") +
                     joint("follow", "revolute", "base", "right",
                           "<origin xyz=\"0.5 0 0\"/>" + axis("0 0 1") + limits("-1", "1") + mimic("turn", "1"))));
  Uncertainty uncertainty(model->robot);
  constexpr double kAngle = 0.02;
  uncertainty.positions[scene::findNamed(model->robot.joints, "turn")] = kAngle;
  LinksAtZero boards(model, uncertainty, "left", "right");
  ASSERT_NEAR(boards.pair.result.distance, 0.48, 1e-9);
  const double bound = boards.distances.of(boards.scene.state, boards.pair);
  EXPECT_LE(bound, 0.5 * std::cos(kAngle) - 0.02);
  EXPECT_GT(bound, 0.48 - 0.4 * kAngle / 8.0);
  boards.distances.forget();
  boards.distances.divideInto(0);
  EXPECT_LT(boards.distances.of(boards.scene.state, boards.pair), 0.48 - 0.4 * kAngle * 0.9);
}

// Neither end of the swing is as close to the post as a state between them.
TEST(GuaranteedDistances, ReachedStateMayBeBetweenTheEnds) {
  const auto model = modelOf(urdfOf(link("post", ball("0.1", "1 0.05 0.5")) + link("arm", ball("0.1", "1 0 0")) +
                                    hinge("swing", "post", "arm", "0 0 1")));
  Uncertainty uncertainty(model->robot);
  uncertainty.positions[0] = 0.2;
  LinksAtZero links(model, uncertainty, "post", "arm");
  const double closest = std::hypot(std::hypot(1.0, 0.05) - 1.0, 0.5) - 0.2;
  const double threshold = 0.5 * (closest + links.pair.result.distance);
  const ReachedState* const reached = links.distances.reached(links.scene.state, links.pair, threshold);
  ASSERT_NE(reached, nullptr);
  EXPECT_LT(reached->upper_bound, threshold);
  EXPECT_GE(reached->upper_bound, closest - 1e-12);
  EXPECT_NEAR(reached->displacements[0], 0.05, 0.05);
}

TEST(GuaranteedDistances, RobotsOnOtherBasesLoseBothUncertainties) {
  const std::string arm = urdfOf(link("base") + link("arm", ball("0.1", "1 0 0")) + hinge("j", "base", "arm", "0 0 1"));
  const auto model = modelOf(joined({{"left", robotOf(arm)}, {"right", robotOf(arm)}}));
  PosedScene scene(model);
  GuaranteedDistances distances(model);
  const BodyPoses poses = placedAt(model->robot, forwardKinematics(model->robot, {}), {at(0, 0, 0), at(4, 0, 0)});
  scene.update(poses);
  Uncertainty uncertainty(model->robot);
  uncertainty.bases = {{0.001, 0.0}, {0.002, 0.0}};
  distances.assume(uncertainty);
  EXPECT_NEAR(distances.of(scene.state, scene.proximity(pairOf(*model, "left/arm", "right/arm"))), 3.8 - 0.003, 1e-9);
  uncertainty.bases = {{0.0, 0.001}, {0.0, 0.002}};  // along the normal nothing turns to first order
  distances.assume(uncertainty);
  EXPECT_NEAR(distances.of(scene.state, scene.proximity(pairOf(*model, "left/arm", "right/arm"))), 3.8, 2e-5);
}

TEST(GuaranteedDistances, WrongValuesAreRefusedByName) {
  const auto model = modelOf(
      urdfOf(link("base", ball("0.1")) + link("cart", ball("0.1", "1 0 0")) + link("arm", ball("0.1", "2 0 0")) +
             joint("drive", "planar", "base", "cart", axis("0 0 1")) + hinge("turn", "cart", "arm", "0 0 1")));
  GuaranteedDistances distances(model);
  const auto expectRefused = [&](const char* name, const auto& spoil) {
    Uncertainty uncertainty(model->robot);
    spoil(uncertainty);
    EXPECT_TRUE(isRefused([&] { distances.assume(uncertainty); }, name));
  };
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN(), kMuch = std::numeric_limits<double>::infinity();
  expectRefused("position of joint \"turn\"", [](Uncertainty& of) { of.positions[1] = -1e-3; });
  expectRefused("joint \"drive\" is planar", [](Uncertainty& of) { of.positions[0] = 1e-3; });
  expectRefused("angle of the frame of joint \"drive\"", [](Uncertainty& of) { of.frames[0].angle = kNan; });
  expectRefused("translation of the base", [](Uncertainty& of) { of.bases[0].translation = kMuch; });
  expectRefused("surface of link \"arm\"", [](Uncertainty& of) { of.swellings[2] = -1.0; });
  expectRefused("translation of objects", [](Uncertainty& of) { of.objects.translation = kNan; });
  expectRefused("angle of object \"mug\"", [](Uncertainty& of) { of.own_objects["mug"].angle = -1.0; });
  expectRefused("2 joints", [](Uncertainty& of) { of.positions.push_back(0.0); });
}

TEST(GuaranteedDistances, NothingIsKnownWhileAPoseBetweenIsMissing) {
  const auto model = modelOf(kCrane);
  PosedScene scene(model);
  GuaranteedDistances distances(model);
  BodyPoses poses = forwardKinematics(model->robot, {});
  poses[bodyOf(model->robot, "mast")] = std::nullopt;
  scene.update(poses);
  Uncertainty uncertainty(model->robot);
  uncertainty.positions = {1e-3, 0.0};
  distances.assume(uncertainty);
  EXPECT_TRUE(std::isnan(distances.of(scene.state, scene.proximity(pairOf(*model, "post", "hook")))));
  EXPECT_EQ(distances.find(scene.scene, scene.state, {}).unknown, 1);
}

// --- random robots with objects

/// A random robot with objects around it and in its hands, in a random state.
class SomeCell {
 public:
  explicit SomeCell(Chance& chance) : model(someRobot(chance)), scene(model), displaced(model), distances(model) {
    std::vector<ObjectChange> changes;
    const Placement places[] = {Fixed{chance.pose(0.5)}, Moving{"tray", chance.pose(0.2)},
                                Attached{"5", {}, chance.pose(0.1)}};
    const char* const ids[] = {"crate", "dish", "tool"};
    for (int i = 0; i < 3; ++i)
      changes.push_back(AddObject{i == 0 && chance.below(3) == 0 ? someSolid(ids[i], places[i], chance)
                                                                 : someObject(ids[i], places[i], chance)});
    objects = std::make_shared<const Objects>(Objects(model).changed(changes));
    frames = {chance.pose(0.3)};
    poses = somePoses(model->robot, DegreesOfFreedom(model->robot), chance);
    scene.use(objects);
    scene.update(poses, frames);
  }

  /// The distance of a pair in a state, with swollen surfaces.
  narrowphase::SignedDistance in(const StateWithin& state, const ShapeRefPair& pair) {
    displaced.use(objectsWithin(*objects, distances.uncertainty(), state));
    displaced.update(posesWithin(model->robot, poses, distances.uncertainty(), state), frames);
    narrowphase::SignedDistance result = displaced.proximity(pair).result;
    result.upper_bound -= swellingOf(distances.uncertainty(), pair);
    return result;
  }

  const std::shared_ptr<const SceneModel> model;
  PosedScene scene, displaced;
  GuaranteedDistances distances;
  std::shared_ptr<const Objects> objects;
  BodyPoses poses;
  FramePoses frames;
};

/// The same with half-spaces and other objects near and far, some on frames that tf does not know, all of them checked
/// against each other.
class CrowdedCell : public SomeCell {
 public:
  explicit CrowdedCell(Chance& chance) : SomeCell(chance) {
    const auto somewhere = [&] { return chance.pose(chance.decades(-0.5, 1.5)); };
    const HalfSpace below{{0.0, 0.0, 1.0}, -0.5}, behind{chance.direction(), -1.0};
    const narrowphase::Shape solid = narrowphase::Sphere{0.1};
    ObjectRules rules;
    rules.free_objects = ObjectRules::FreeObjects::Checked;
    objects = std::make_shared<const Objects>(
        objects
            ->changed({AddObject{makeObject("floor", {{below}}, Fixed{chance.pose(0.3)})},
                       AddObject{makeObject("door", {{behind}, {solid}}, Moving{"hinge", chance.pose(0.3)})},
                       AddObject{makeObject("shelf", {{solid}}, Fixed{somewhere()})},
                       AddObject{makeObject("trolley", {{solid}}, Moving{"wheels", somewhere()})},
                       AddObject{makeObject("lost", {{solid}}, Moving{"unknown", somewhere()})}})
            .withRules(rules));
    frames.clear();
    for (const std::string& frame : objects->frames()) {
      frames.push_back(chance.pose(chance.decades(-0.5, 1.5)));
      if (frame == "unknown") frames.back() = std::nullopt;
    }
    scene.use(objects);
    scene.update(poses, frames);
  }
};

TEST(GuaranteedDistances, NoStateWithinIsCloser) {
  Chance chance(38), corners(47), limits(48);
  int pairs = 0, tight = 0, overlaps = 0, states = 0;
  for (int i = 0; i < repeats(150); ++i) {
    SomeCell cell(chance);
    const double size = chance.decades(-4, -0.7);
    cell.distances.assume(someUncertainty(cell.model->robot, size, 0.3 * size, chance));
    const std::vector<PairProximity> all = cell.scene.all(cell.scene.candidates());
    for (int k = 0; k < 6; ++k) {
      const PairProximity& pair = chance.oneOf(all);
      if (pair.result.status == narrowphase::Status::Unknown) continue;
      // Coarse bounds, which may be enough for a question, hold as well.
      const double enough = pair.result.lower_bound - limits.decades(-4, 0);
      const double coarse = cell.distances.of(cell.scene.state, pair, enough),
                   bound = cell.distances.of(cell.scene.state, pair);
      ASSERT_LE(bound, pair.result.lower_bound);
      const auto in = [&](const StateWithin& state) {
        ++states;
        return cell.in(state, pair.asked).upper_bound;
      };
      const double worst = std::min({pair.result.upper_bound - swellingOf(cell.distances.uncertainty(), pair.asked),
                                     smallestOfSome(12, cell.model->robot, cell.objects.get(), chance, in),
                                     smallestOfCorners(cell.model->robot, cell.objects.get(), corners, in)});
      ASSERT_GE(worst, coarse) << i << ", enough " << enough;
      ASSERT_GE(worst, bound) << i << ": " << nameOf(pair.asked.a, cell.model->robot, cell.objects.get()) << ", "
                              << nameOf(pair.asked.b, cell.model->robot, cell.objects.get());
      ++pairs;
      overlaps += pair.result.distance < 0.0;
      tight += pair.result.upper_bound - worst > 0.3 * (pair.result.upper_bound - bound);
    }
  }
  RecordProperty("states", states);
  if (kIsSanitized) return;
  EXPECT_GT(pairs, 800);
  EXPECT_GT(overlaps, 80);
  EXPECT_GT(tight, 250);
}

TEST(GuaranteedDistances, WithoutUncertaintyTheyAreTheLowerBoundsOfTheScene) {
  Chance chance(39);
  for (int i = 0; i < repeats(20); ++i) {
    SomeCell cell(chance);
    for (const PairProximity& pair : cell.scene.all(cell.scene.candidates()))
      EXPECT_EQ(cell.distances.of(cell.scene.state, pair), pair.result.lower_bound);
  }
}

TEST(GuaranteedDistances, ReachedStatesAreWithinTheUncertaintyAndAsClose) {
  Chance chance(40);
  int reached = 0, missed = 0;
  for (int i = 0; i < repeats(100); ++i) {
    SomeCell cell(chance);
    const double size = chance.decades(-3, -1);
    const Uncertainty uncertainty = someUncertainty(cell.model->robot, size, 0.3 * size, chance);
    cell.distances.assume(uncertainty);
    const RobotModel& robot = cell.model->robot;
    for (const PairProximity& pair : std::vector<PairProximity>(cell.scene.all(cell.scene.candidates()))) {
      const double bound = cell.distances.of(cell.scene.state, pair);
      const double threshold = bound + 0.5 * (pair.result.lower_bound - bound);
      EXPECT_EQ(cell.distances.reached(cell.scene.state, pair, bound), nullptr);
      const ReachedState* state = cell.distances.reached(cell.scene.state, pair, threshold);
      if (pair.result.lower_bound - bound > 1e-5) ++(state ? reached : missed);
      if (!state) continue;
      EXPECT_LT(state->upper_bound, threshold);
      for (std::size_t joint = 0; joint < robot.joints.size(); ++joint) {
        const Joint::Mimic leader = robot.leaderOf(static_cast<int>(joint));
        EXPECT_LE(std::abs(state->displacements[joint]),
                  std::abs(leader.multiplier) * uncertainty.positions[leader.joint] * (1.0 + 1e-12));
        if (leader.joint != static_cast<int>(joint) && hasOnePosition(robot.joints[leader.joint])) {
          EXPECT_NEAR(state->displacements[joint], leader.multiplier * state->displacements[leader.joint], 1e-15);
        }
      }
      if (!pair.asked.areLinks()) continue;
      cell.displaced.update(state->poses);
      EXPECT_LT(cell.displaced.proximity(pair.asked).result.lower_bound - swellingOf(uncertainty, pair.asked),
                threshold);
    }
  }
  if (!kIsSanitized) {
    EXPECT_GT(reached, 3 * missed);
  }
}

TEST(GuaranteedDistances, ReachedStateOfTheCraneIsThatOfTheWorstCorner) {
  const auto model = modelOf(kCrane);
  PosedScene scene(model);
  GuaranteedDistances distances(model);
  const BodyPoses poses = forwardKinematics(model->robot, {});
  scene.update(poses);
  Uncertainty uncertainty(model->robot);
  uncertainty.positions = {1e-3, 2e-3};
  distances.assume(uncertainty);
  const PairProximity pair = scene.proximity(pairOf(*model, "post", "hook"));
  const ReachedState* state = distances.reached(scene.state, pair, kCraneDistance - 2.5e-3);
  ASSERT_NE(state, nullptr);
  EXPECT_EQ(state->displacements, (std::vector<double>{1e-3, -2e-3}));
  EXPECT_NEAR(state->upper_bound, kCraneDistance - (2e-3 * 3.0 + 2e-3 * 2.0) / std::sqrt(13.0), 1e-5);
  EXPECT_EQ(distances.reached(scene.state, pair, kCraneDistance - 2.9e-3), nullptr);
}

TEST(GuaranteedDistances, MinimumOfASceneIsThatOfAllItsPairs) {
  Chance chance(41);
  for (int i = 0; i < repeats(60); ++i) {
    SomeCell cell(chance);
    const double size = chance.decades(-4, -1);
    cell.distances.assume(someUncertainty(cell.model->robot, size, 0.3 * size, chance));
    PairDistances thresholds(chance.between(0, 0.1), chance.between(0, 0.1));
    const GuaranteedMinimum found = cell.distances.find(cell.scene.scene, cell.scene.state, thresholds);
    double lowest = std::numeric_limits<double>::infinity();
    for (const PairProximity& pair : std::vector<PairProximity>(cell.scene.all(cell.scene.candidates())))
      lowest = std::min(lowest, cell.distances.of(cell.scene.state, pair) - thresholds.of(pair.asked));
    EXPECT_NEAR(found.excess, lowest, 1e-8);
    EXPECT_EQ(found.unknown, 0);
  }
}

TEST(GuaranteedDistances, MinimumOfACrowdedSceneIsThatOfAllItsPairs) {
  Chance chance(51);
  int of_free_objects = 0;
  for (int i = 0; i < repeats(60); ++i) {
    CrowdedCell cell(chance);
    cell.distances.assume(someUncertainty(cell.model->robot, 0.1, 0.03, chance));
    const PairDistances thresholds(chance.between(0, 0.1), chance.between(0, 0.1));
    const std::vector<PairProximity> all = cell.scene.all(cell.scene.candidates());
    double lowest = std::numeric_limits<double>::infinity();
    for (const PairProximity& pair : all) {
      const double bound = cell.distances.of(cell.scene.state, pair);
      if (!std::isnan(bound)) lowest = std::min(lowest, bound - thresholds.of(pair.asked));
    }
    const GuaranteedMinimum found = cell.distances.find(cell.scene.scene, cell.scene.state, thresholds);
    EXPECT_NEAR(found.excess, lowest, 1e-8);
    EXPECT_GT(found.unknown, 0);
    of_free_objects += found.pair.asked.a.isObject() && found.pair.asked.b.isObject();
    // A list may have pairs that are not checked, too.
    std::vector<ShapeRefPair> list;
    for (const PairProximity& pair : all) list.push_back(pair.asked);
    const auto unchecked = std::make_shared<const Objects>(cell.objects->withRules({}));
    cell.scene.use(unchecked);
    cell.scene.update(cell.poses, cell.frames);
    EXPECT_NEAR(cell.distances.find(cell.scene.scene, cell.scene.state, Pairs(list), thresholds).excess, lowest, 1e-8);
  }
  if (!kIsSanitized) {
    EXPECT_GT(of_free_objects, 10);
  }
}

TEST(GuaranteedDistances, MinimumIsThatOfASceneWhereItIsNotEnough) {
  Chance chance(48);
  int improved = 0;
  for (int i = 0; i < repeats(60); ++i) {
    SomeCell cell(chance);
    const double size = chance.decades(-4, -1);
    cell.distances.assume(someUncertainty(cell.model->robot, size, 0.3 * size, chance));
    const PairDistances thresholds(chance.between(0, 0.1), chance.between(0, 0.1));
    const GuaranteedMinimum best = cell.distances.find(cell.scene.scene, cell.scene.state, thresholds);
    const double enough = best.excess + chance.between(-0.1, 0.1);
    cell.distances.forget();
    const Pairs pairs(cell.scene.candidates());
    const GuaranteedMinimum found =
        cell.distances.find(cell.scene.scene, cell.scene.state, pairs, thresholds, {}, enough);
    EXPECT_NEAR(std::min(found.excess, enough), std::min(best.excess, enough), 1e-12);
    EXPECT_LE(found.excess, best.excess + 1e-12);
    improved += best.excess < enough;
  }
  if (!kIsSanitized) {
    EXPECT_GT(improved, 20);
  }
}

ListedPairs listOf(const std::vector<PairProximity>& pairs, double others) {
  return {pairs.data(), pairs.data() + pairs.size(), others};
}

TEST(GuaranteedDistances, MinimumOfListedPairsIsThatOfTheScene) {
  Chance chance(44);
  for (int i = 0; i < repeats(60); ++i) {
    SomeCell cell(chance);
    const double size = chance.decades(-4, -1);
    cell.distances.assume(someUncertainty(cell.model->robot, size, 0.3 * size, chance));
    const PairDistances thresholds(chance.between(0, 0.1), chance.between(0, 0.1));
    const PairKind kind = chance.oneOf(std::vector<PairKind>{PairKind::Any, PairKind::OfLinks, PairKind::WithObject});
    const Pairs pairs(cell.scene.candidates(), kind);
    const double excess = cell.distances.find(cell.scene.scene, cell.scene.state, pairs, thresholds).excess;
    for (const int most : {1, 3, 10}) {
      const std::vector<PairProximity>& closest = cell.scene.closest(cell.scene.candidates(), most);
      const double others = closest.empty() ? std::numeric_limits<double>::infinity()
                                            : closest.back().result.lower_bound - Question().tolerance;
      const double found =
          cell.distances.find(cell.scene.scene, cell.scene.state, pairs, thresholds, listOf(closest, others)).excess;
      if (std::isfinite(excess)) {
        EXPECT_NEAR(found, excess, 1e-12);
      } else {
        EXPECT_EQ(found, excess);
      }
    }
    Question question;
    question.threshold = chance.between(0.0, 0.5);
    const ListedPairs below = listOf(cell.scene.below(cell.scene.candidates(), question), question.threshold);
    const double found = cell.distances.find(cell.scene.scene, cell.scene.state, pairs, thresholds, below).excess;
    if (std::isfinite(excess)) {
      EXPECT_NEAR(found, excess, 1e-12);
    }
  }
}

TEST(GuaranteedDistances, MinimumDoesNotDependOnStatesThatAreForgotten) {
  Chance chance(45);
  for (int i = 0; i < repeats(30); ++i) {
    SomeCell cell(chance);
    const double size = chance.decades(-4, -1);
    cell.distances.assume(someUncertainty(cell.model->robot, size, 0.3 * size, chance));
    for (int k = 0; k < 5; ++k) {
      const BodyPoses poses = somePoses(cell.model->robot, DegreesOfFreedom(cell.model->robot), chance);
      cell.scene.update(poses, cell.frames);
      GuaranteedDistances fresh(cell.model);
      fresh.assume(cell.distances.uncertainty());
      cell.distances.forget();
      EXPECT_EQ(cell.distances.find(cell.scene.scene, cell.scene.state, {}).excess,
                fresh.find(cell.scene.scene, cell.scene.state, {}).excess);
    }
  }
}

TEST(GuaranteedDistances, BoundIsTheSameUpToWhatIsEnough) {
  Chance chance(46);
  int improved = 0;
  for (int i = 0; i < repeats(60); ++i) {
    SomeCell cell(chance);
    const double size = chance.decades(-3, -1);
    cell.distances.assume(someUncertainty(cell.model->robot, size, 0.3 * size, chance));
    for (const PairProximity& pair : std::vector<PairProximity>(cell.scene.all(cell.scene.candidates()))) {
      const double bound = cell.distances.of(cell.scene.state, pair);
      const double enough = bound + chance.between(-1.0, 1.0) * (pair.result.lower_bound - bound);
      cell.distances.forget();
      const double sufficient = cell.distances.of(cell.scene.state, pair, enough);
      EXPECT_NEAR(std::min(sufficient, enough), std::min(bound, enough), 1e-12);
      EXPECT_LE(sufficient, pair.result.lower_bound);
      EXPECT_EQ(cell.distances.of(cell.scene.state, pair), std::max(bound, sufficient));
      improved += enough > bound;
    }
  }
  if (!kIsSanitized) {
    EXPECT_GT(improved, 100);
  }
}

TEST(GuaranteedDistances, LargestLossIsThatOfTheTwoArmsThatLoseTheMost) {
  const auto model =
      modelOf(urdfOf(link("base") + link("left", ball("0.1", "1 0 0")) + link("tip", ball("0.1", "2 0 0")) +
                     link("right", ball("0.1", "0 1 0")) + link("head", ball("0.1", "0 0 1")) +
                     slider("a", "base", "left", "1 0 0") + slider("b", "left", "tip", "1 0 0") +
                     slider("c", "base", "right", "0 1 0") + slider("d", "base", "head", "0 0 1")));
  PosedScene scene(model);
  GuaranteedDistances distances(model);
  scene.update(forwardKinematics(model->robot, {}));
  Uncertainty uncertainty(model->robot);
  uncertainty.positions = {0.01, 0.02, 0.04, 0.005};
  distances.assume(uncertainty);
  EXPECT_NEAR(distances.largestLoss(scene.state), 0.07, 1e-9);
  uncertainty.positions = {0.01, 0.02, 0.04, 0.05};
  distances.assume(uncertainty);
  EXPECT_NEAR(distances.largestLoss(scene.state), 0.09, 1e-9);
}

TEST(GuaranteedDistances, NoPairLosesMoreThanTheLargestLoss) {
  Chance chance(42);
  for (int i = 0; i < repeats(60); ++i) {
    SomeCell cell(chance);
    cell.distances.assume(someUncertainty(cell.model->robot, 0.1, 0.03, chance));
    const double largest = cell.distances.largestLoss(cell.scene.state);
    for (const PairProximity& pair : std::vector<PairProximity>(cell.scene.all(cell.scene.candidates())))
      EXPECT_GE(cell.distances.of(cell.scene.state, pair), pair.result.lower_bound - largest);
  }
}

TEST(GuaranteedDistances, NoPairOfAnyKindLosesMoreThanTheLargestLoss) {
  Chance chance(52);
  int of_links = 0, of_free_objects = 0, close = 0;
  for (int i = 0; i < repeats(60); ++i) {
    CrowdedCell cell(chance);
    cell.distances.assume(someUncertainty(cell.model->robot, 0.1, 0.03, chance));
    const double largest = cell.distances.largestLoss(cell.scene.state);
    double most = 0.0;
    for (const PairProximity& pair : std::vector<PairProximity>(cell.scene.all(cell.scene.candidates()))) {
      if (pair.result.status == narrowphase::Status::Unknown) continue;
      const auto in = [&](const StateWithin& state) { return cell.in(state, pair.asked).upper_bound; };
      const double worst = smallestOfSome(8, cell.model->robot, cell.objects.get(), chance, in);
      EXPECT_GE(worst, pair.result.lower_bound - largest)
          << nameOf(pair.asked.a, cell.model->robot, cell.objects.get()) << ", "
          << nameOf(pair.asked.b, cell.model->robot, cell.objects.get());
      EXPECT_GE(cell.distances.of(cell.scene.state, pair), pair.result.lower_bound - largest);
      most = std::max(most, pair.result.lower_bound - cell.distances.of(cell.scene.state, pair));
      ++(pair.asked.a.isLink() ? of_links : of_free_objects);
    }
    close += most > 0.3 * largest;
  }
  if (kIsSanitized) return;
  EXPECT_GT(of_links, 500);
  EXPECT_GT(of_free_objects, 300);
  EXPECT_GT(close, 20);
}

// The floor is level within 0.1 rad, and a trolley stands 30 m away from where that was measured.
TEST(GuaranteedDistances, LargestLossOfAMotionLeavesOutWhatNoJointMoves) {
  const auto model = modelOf(kCrane);
  const Object floor = makeObject("floor", {{HalfSpace{{0, 0, 1}, -1.0}}}, Fixed{at(0, 0, 0)});
  const Object trolley = makeObject("trolley", {{narrowphase::Shape(narrowphase::Sphere{0.5})}}, Moving{"wheels"});
  ObjectRules rules;
  rules.free_objects = ObjectRules::FreeObjects::Checked;
  PosedScene scene(model);
  GuaranteedDistances distances(model);
  scene.use(
      std::make_shared<const Objects>(Objects(model).changed({AddObject{floor}, AddObject{trolley}}).withRules(rules)));
  scene.update(forwardKinematics(model->robot, {}), {at(30, 0, 0)});
  Uncertainty uncertainty(model->robot);
  uncertainty.own_objects["floor"] = {0.0, 0.1};
  distances.assume(uncertainty);
  EXPECT_NEAR(distances.largestLoss(scene.state), 0.1 * 30.5, 1e-9);
  const double farthest = std::hypot(3.0, 0.5) + 0.5;  // of the post; nothing moves the hook that far
  EXPECT_NEAR(distances.largestLoss(scene.state, {0.0, 0.0}), 0.1 * farthest, 1e-9);
}

// The mast turns the hook away from where the chain of known poses ends.
TEST(GuaranteedDistances, LargestLossOfAMotionIsNotKnownWhileAPoseBetweenIsMissing) {
  const auto model =
      modelOf(urdfOf(link("post", ball("0.5", "0 3 0.5")) + link("mast") + link("hook", ball("0.1")) +
                     hinge("swing", "post", "mast", "0 0 1") + hinge("reach", "mast", "hook", "0 0 1", "2 0 0.5")));
  PosedScene scene(model);
  GuaranteedDistances distances(model);
  BodyPoses poses = forwardKinematics(model->robot, {});
  poses[bodyOf(model->robot, "mast")] = std::nullopt;
  scene.update(poses);
  Uncertainty uncertainty(model->robot);
  uncertainty.bases[0].angle = 0.1;
  distances.assume(uncertainty);
  EXPECT_TRUE(std::isfinite(distances.largestLoss(scene.state)));
  EXPECT_TRUE(std::isfinite(distances.largestLoss(scene.state, {0.0, 1.0})));
  EXPECT_EQ(distances.largestLoss(scene.state, {1.0, 0.0}), std::numeric_limits<double>::infinity());
  // What is only shifted loses the same wherever the others are.
  const Object floor = makeObject("floor", {{HalfSpace{{0, 0, 1}, -1.0}}}, Fixed{at(0, 0, 0)});
  scene.use(std::make_shared<const Objects>(Objects(model).changed({AddObject{floor}})));
  uncertainty.bases[0].angle = 0.0;
  uncertainty.own_objects["floor"] = {0.02, 0.0};
  distances.assume(uncertainty);
  EXPECT_NEAR(distances.largestLoss(scene.state, {1.0, 0.0}), 0.02, 1e-9);
}

TEST(GuaranteedDistances, NoPairLosesMoreDuringAMotionThanTheLargestLossOfIt) {
  Chance chance(44);
  const auto model = modelOf(kCrane);
  PosedScene scene(model);
  GuaranteedDistances distances(model);
  for (int i = 0; i < 100; ++i) {
    distances.assume(someUncertainty(model->robot, 0.1, 0.03, chance));
    const std::vector<double> start{chance.between(-3, 3), chance.between(-1, 1)};
    const std::vector<double> travel{chance.between(0, 2), chance.between(0, 1)};
    scene.update(forwardKinematics(model->robot, start));
    const double largest = distances.largestLoss(scene.state, travel);
    EXPECT_GE(largest, distances.largestLoss(scene.state));
    for (int k = 0; k < 10; ++k) {
      const BodyPoses later =
          forwardKinematics(model->robot, std::vector<double>{start[0] + chance.between(-1, 1) * travel[0],
                                                              start[1] + (k % 2 ? 1.0 : -1.0) * travel[1]});
      scene.update(later);
      const PairProximity pair = scene.proximity(pairOf(*model, "post", "hook"));
      const double bound = distances.of(scene.state, pair);
      if (bound > 0.0) {
        EXPECT_GE(bound, pair.result.lower_bound - largest);
      }
    }
  }
}

// The gripper is a tf frame on the hook that the URDF does not have. The same of an object that another one stands beside.
TEST(GuaranteedDistances, NoPairOfAnObjectInTheFrameOfALinkLosesMoreThanTheLargestLoss) {
  Chance chance(45);
  const auto model = modelOf(kCrane);
  const narrowphase::Shape sphere(narrowphase::Sphere{0.1});
  const Object tool = makeObject("tool", {{sphere}}, Moving{"gripper"}),
               box = makeObject("box", {{sphere}}, Fixed{at(1, 1, 0)});
  ObjectRules rules;
  rules.free_objects = ObjectRules::FreeObjects::Checked;
  const auto objects =
      std::make_shared<const Objects>(Objects(model).changed({AddObject{tool}, AddObject{box}}).withRules(rules));
  const int hook = model->robot.links[model->robot.findLink("hook")].body;
  PosedScene scene(model);
  GuaranteedDistances distances(model);
  scene.use(objects, {-1, {hook}});
  int pairs = 0;
  for (int i = 0; i < 200; ++i) {
    distances.assume(someUncertainty(model->robot, 0.1, 0.03, chance));
    const std::vector<double> start{chance.between(-3, 3), chance.between(-1, 1)};
    const std::vector<double> travel{chance.between(0, 1), chance.between(0, 1)};
    const BodyPoses poses = forwardKinematics(model->robot, start);
    scene.update(poses, {*poses[hook] * at(1, 0, 0.5)});
    const double largest = distances.largestLoss(scene.state, travel);
    ASSERT_TRUE(std::isfinite(largest));
    const BodyPoses later = forwardKinematics(
        model->robot, std::vector<double>{start[0] + chance.between(-1, 1) * travel[0], start[1] + travel[1]});
    scene.update(later, {*later[hook] * at(1, 0, 0.5)});
    for (const PairProximity& pair : scene.closest(scene.candidates(), 4)) {
      const double bound = distances.of(scene.state, pair);
      if (!(bound > 0.0)) continue;
      EXPECT_GE(bound, pair.result.lower_bound - largest);
      ++pairs;
    }
  }
  EXPECT_GT(pairs, 200);
}

// Regression: the reach of the objects of a frame that was far away for one state stayed.
TEST(GuaranteedDistances, LargestLossIsThatOfThePresentPlaceOfAFrame) {
  Chance chance(46);
  const auto model = modelOf(kCrane);
  const Object tool = makeObject("tool", {{narrowphase::Shape(narrowphase::Sphere{0.1})}}, Moving{"gripper"});
  const auto objects = std::make_shared<const Objects>(Objects(model).changed({AddObject{tool}}));
  const int hook = model->robot.links[model->robot.findLink("hook")].body;
  PosedScene scene(model);
  GuaranteedDistances distances(model);
  scene.use(objects, {-1, {hook}});
  distances.assume(someUncertainty(model->robot, 0.1, 0.03, chance));
  const BodyPoses poses = forwardKinematics(model->robot, std::vector<double>{0.5, 0.2});
  const auto lossAt = [&](double x) {
    scene.update(poses, {*poses[hook] * at(x, 0, 0.5)});
    return distances.largestLoss(scene.state);
  };
  const double near = lossAt(1.0);
  EXPECT_GT(lossAt(30.0), 2.0 * near);
  EXPECT_EQ(lossAt(1.0), near);
}

/// Limits the work to so many steps, by their number or as time.
void limitSteps(std::int64_t most, GuaranteeEnd by, GuaranteedDistances& distances) {
  GuaranteeLimits limits;
  (by == GuaranteeEnd::Steps ? limits.most_steps : limits.steps_to_deadline) = most;
  distances.limit(limits);
}

// A limit at any step, of pairs one by one and of their minimum. Bounds without limits are compared with states above.
TEST(GuaranteedDistances, HoldWhereverALimitEndsThem) {
  Chance chance(53);
  int same = 0, coarser = 0, coarser_minima = 0;
  for (int i = 0; i < repeats(100); ++i) {
    CrowdedCell cell(chance);
    cell.distances.assume(someUncertainty(cell.model->robot, 0.1, 0.03, chance));
    const std::vector<PairProximity> all = cell.scene.all(cell.scene.candidates());
    std::vector<double> whole;
    for (const PairProximity& pair : all) whole.push_back(cell.distances.of(cell.scene.state, pair));
    const PairDistances thresholds(chance.between(0, 0.1), chance.between(0, 0.1));
    cell.distances.forget();
    const double excess = cell.distances.find(cell.scene.scene, cell.scene.state, thresholds).excess;
    const auto most = static_cast<std::int64_t>(chance.decades(1.0, 6.0));
    for (const GuaranteeEnd by : {GuaranteeEnd::Steps, GuaranteeEnd::Time}) {
      cell.distances.forget();
      limitSteps(most, by, cell.distances);
      for (std::size_t k = 0; k < all.size(); ++k) {
        if (std::isnan(whole[k])) continue;
        const double bound = cell.distances.of(cell.scene.state, all[k]);
        EXPECT_LE(bound, whole[k]);
        if (cell.distances.end() == GuaranteeEnd::None) {
          EXPECT_EQ(bound, whole[k]);
          ++same;
        }
        coarser += bound < whole[k];
      }
      if (cell.distances.end() != GuaranteeEnd::None) {
        EXPECT_EQ(cell.distances.end(), by);
      }
      cell.distances.forget();
      limitSteps(most, by, cell.distances);
      const GuaranteedMinimum found = cell.distances.find(cell.scene.scene, cell.scene.state, thresholds);
      EXPECT_LE(found.excess, excess + 1e-12);
      EXPECT_EQ(std::isinf(found.excess), std::isinf(excess)) << "a limit does not make a bound of none";
      EXPECT_NEAR(found.guaranteed - thresholds.of(found.pair.asked), found.excess, 1e-12);
      coarser_minima += found.excess < excess - 1e-12;
      // The same once more, as in a replay.
      cell.distances.forget();
      limitSteps(cell.distances.end() == GuaranteeEnd::Time ? cell.distances.steps() : most, by, cell.distances);
      const GuaranteedMinimum again = cell.distances.find(cell.scene.scene, cell.scene.state, thresholds);
      EXPECT_EQ(again.excess, found.excess);
      EXPECT_TRUE(again.pair.asked.isSameAs(found.pair.asked));
    }
  }
  if (kIsSanitized) return;
  EXPECT_GT(same, 500);
  EXPECT_GT(coarser, 500);
  EXPECT_GT(coarser_minima, 20);
}

// The closest pairs lose little; that of the floor and the trolley, which is 2 m above it, loses the most. A search that
// ends after the closest pairs has to count it.
TEST(GuaranteedDistances, MinimumThatALimitEndsHoldsForPairsThatWereNotLookedAt) {
  const auto model = modelOf(kCrane);
  const Object floor = makeObject("floor", {{HalfSpace{{0, 0, 1}, -0.2}}}, Fixed{at(0, 0, 0)});
  const Object trolley = makeObject("trolley", {{narrowphase::Shape(narrowphase::Sphere{0.1})}}, Moving{"wheels"});
  ObjectRules rules;
  rules.free_objects = ObjectRules::FreeObjects::Checked;
  const auto objects =
      std::make_shared<const Objects>(Objects(model).changed({AddObject{floor}, AddObject{trolley}}).withRules(rules));
  PosedScene scene(model);
  GuaranteedDistances distances(model);
  scene.use(objects);
  scene.update(forwardKinematics(model->robot, {}), {at(30, 0, 2)});
  Uncertainty uncertainty(model->robot);
  uncertainty.own_objects["floor"] = {0.0, 0.09};
  distances.assume(uncertainty);
  const double excess = distances.find(scene.scene, scene.state, {}).excess;
  EXPECT_NEAR(excess, 2.1 - 0.09 * 30.1, 0.1);
  const std::vector<PairProximity> closest = scene.closest(scene.candidates(), 2);
  for (const GuaranteeEnd by : {GuaranteeEnd::Steps, GuaranteeEnd::Time}) {
    limitSteps(0, by, distances);
    distances.forget();
    EXPECT_LE(distances.find(scene.scene, scene.state, {}).excess, excess);
    const GuaranteedMinimum found =
        distances.find(scene.scene, scene.state, scene.candidates(), {}, listOf(closest, 1.0));
    EXPECT_LE(found.excess, excess);
    EXPECT_NEAR(found.guaranteed, found.excess, 1e-12);
    EXPECT_EQ(distances.end(), by);
  }
}

// With a half-space that a joint carries, the largest loss is infinite, and so says nothing about pairs that were not listed.
TEST(GuaranteedDistances, MinimumThatALimitEndsIsFiniteBesideAHalfSpaceThatALinkCarries) {
  const auto model = modelOf(kCrane);
  const Object tool = makeObject("tool", {{HalfSpace{{0, 0, 1}, -10.0}}}, Moving{"gripper"});
  const auto objects = std::make_shared<const Objects>(Objects(model).changed({AddObject{tool}}));
  PosedScene scene(model);
  GuaranteedDistances distances(model);
  scene.use(objects, {-1, {model->robot.links[model->robot.findLink("hook")].body}});
  scene.update(forwardKinematics(model->robot, {}), {at(2, 0, 1.5)});
  distances.assume(uncertaintyOfJoints(model->robot, 1e-3));
  EXPECT_EQ(distances.largestLoss(scene.state), std::numeric_limits<double>::infinity());
  const double excess = distances.find(scene.scene, scene.state, {}).excess;
  for (const GuaranteeEnd by : {GuaranteeEnd::Steps, GuaranteeEnd::Time}) {
    limitSteps(0, by, distances);
    distances.forget();
    const double coarse = distances.find(scene.scene, scene.state, {}).excess;
    EXPECT_LE(coarse, excess);
    EXPECT_GT(coarse, excess - 0.1);
  }
}

TEST(GuaranteedDistances, ADeadlineThatHasPassedLeavesTheCoarsestBounds) {
  LinksAtZero links(modelOf(kCrane), uncertaintyOfJoints(modelOf(kCrane)->robot, 0.1), "post", "hook");
  const double whole = links.distances.of(links.scene.state, links.pair);
  links.distances.forget();
  GuaranteeLimits limits;
  limits.deadline = std::chrono::steady_clock::now();
  links.distances.limit(limits);
  // The hook moves by 0.1 m along x, and by 0.1 rad with a radius of 2.1 m at most.
  EXPECT_NEAR(links.distances.of(links.scene.state, links.pair), links.pair.result.lower_bound - 0.1 - 0.21, 1e-9);
  EXPECT_LT(links.distances.of(links.scene.state, links.pair), whole);
  EXPECT_EQ(links.distances.end(), GuaranteeEnd::Time);
}

}  // namespace proximity_server::scene::guaranteed_distances_test
