// Objects of all placements in motions: on paper, and at random beside states that are computed on their own.
#include "chance.h"
#include "proximity_server/scene/motion/motion_search.h"
#include "sanitized.h"
#include "scene/objects/placed_object.h"
#include "scene/posed_scene.h"
#include "scene/random_objects.h"

#include <gtest/gtest.h>
#include <unsupported/Eigen/MatrixFunctions>

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <random>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

namespace proximity_server::scene::objects_in_motion_test {

using namespace narrowphase;

using Eigen::Isometry3d;
using Eigen::Vector3d;
using ObjectFrames = RobotMotion::ObjectFrames;
using Twist = RobotMotion::Twist;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// A cube of edge 1 that slides along x, and above it at z = 10 a ball of radius 0.5, with the same joint in front of
// it.
std::shared_ptr<const SceneModel> cubeAndBall() {
  return modelOf(onRail({{"cube", box("1 1 1")}, {"ball", ball("0.5"), "0 0 10"}}));
}

Object cube(const std::string& id, const Placement& placement, double edge = 1.0) {
  return makeObject(id, {{Shape(Box{{edge, edge, edge}})}}, placement);
}

/// A closed mesh whose walls are 10 m thick.
Object solid(const std::string& id, const Placement& placement) {
  ObjectOptions options;
  options.meshes.tolerance = 0.0;
  return makeObject(id, {{scaled(bracket(), 10.0)}}, placement, options);
}

/// The cube goes `way` along x, from the origin; the ball rests.
class CubeAndBall : public testing::Test {
 protected:
  RobotMotion motion(double way, double from = 0.0) const {
    return RobotMotion::between(model_->robot, positions(from, 0.0), positions(from + way, 0.0));
  }
  std::vector<double> positions(double cube, double ball) const {
    return byJoint(model_->robot, {{"to_cube", cube}, {"to_ball", ball}});
  }
  void add(const Object& object) { change(AddObject{object}); }
  void change(const ObjectChange& change) {
    objects_ = std::make_shared<const Objects>(objects_->changed({change}));
    scene_.use(objects_);
  }
  RobotTimeOfContact contact(const RobotMotion& motion, const MotionQuestion& question = {}) {
    return scene_.timeOfContact(candidates_, motion, question);
  }
  std::string nameOfB(const PairProximity& pair) const { return objects_->object(pair.asked.b.object())->id; }

  const std::shared_ptr<const SceneModel> model_ = cubeAndBall();
  const Candidates candidates_{model_->pairs};
  std::shared_ptr<const Objects> objects_ = std::make_shared<const Objects>(model_);
  MotionSearch scene_{model_};
};

// --- on paper

TEST_F(CubeAndBall, FixedObjectIsMetWhenTheGapIsCovered) {
  add(cube("wall", Fixed{at(4, 0, 0)}));
  const RobotTimeOfContact found = contact(motion(6.0));
  EXPECT_EQ(found.status, Status::Converged);
  ASSERT_TRUE(found.contact);
  EXPECT_NEAR(found.t_contact, 3.0 / 6.0, 1e-6);
  EXPECT_LE(found.t_free, 0.5);
  EXPECT_EQ(nameOfB(found.pair), "wall");
  EXPECT_EQ(found.pair.collision_b, 1);
  EXPECT_NEAR(found.pair.result.normal.x(), 1.0, 1e-9);
  EXPECT_NEAR(found.pair.result.point_a.x(), 3.5, 1e-5) << "in the frame of the poses";
  EXPECT_FALSE(contact(motion(2.9)).contact);
}

// There are so many objects that they are in a tree. Two links are in contact at 0 m, a link and an object, or the wall
// alone, at 0.5 m: the cube meets the wall when it has gone 2.5 m.
TEST_F(CubeAndBall, FixedObjectsAreMetAtTheirOwnContactDistance) {
  std::vector<ObjectChange> changes;
  for (int i = 0; i < 100; ++i) changes.push_back(AddObject{cube(std::to_string(i), Fixed{at(0, 50 + 2 * i, 0)})});
  changes.push_back(AddObject{cube("wall", Fixed{at(4, 0, 0)})});
  objects_ = std::make_shared<const Objects>(objects_->changed(changes));
  scene_.use(objects_);
  PairDistances of_the_wall(0.0, 0.0);
  of_the_wall.setObject(objects_->find("wall"), 0.5);
  for (const PairDistances& thresholds : {PairDistances(0.0, 0.5), of_the_wall}) {
    MotionQuestion question;
    question.thresholds = &thresholds;
    const RobotTimeOfContact found = contact(motion(2.8), question);
    ASSERT_TRUE(found.contact);
    EXPECT_NEAR(found.t_contact, 2.5 / 2.8, 1e-6);
    EXPECT_EQ(nameOfB(found.pair), "wall");
  }
}

TEST_F(CubeAndBall, MinimumIsThatOfTheObjectBesideTheWay) {
  add(cube("beside", Fixed{at(4, 3, 0)}));
  const RobotMinimum minimum = scene_.minimum(candidates_, motion(6.0));
  EXPECT_EQ(minimum.status, Status::Converged);
  EXPECT_NEAR(minimum.upper_bound, 2.0, 1e-6);
  EXPECT_NEAR(minimum.lower_bound, 2.0, 1e-6);
  EXPECT_EQ(nameOfB(minimum.pair), "beside");
}

TEST_F(CubeAndBall, HalfSpaceIsMetByTheFaceThatIsNearest) {
  add(makeObject("slope", {{HalfSpace{{-1, 0, -1}, -4.0 * std::sqrt(2.0)}}}, Fixed{}));
  // Its edge at (x + 0.5, 0.5) has the height (8 - x - 1) / sqrt(2) above the plane x + z = 8.
  const std::vector<ShapeRefPair> of_cube{{{model_->robot.findLink("cube")}, ShapeRef::ofObject(0)}};
  const RobotTimeOfContact found = scene_.timeOfContact(of_cube, motion(8.0));
  ASSERT_TRUE(found.contact);
  EXPECT_EQ(found.status, Status::Converged);
  EXPECT_NEAR(found.t_contact, 7.0 / 8.0, 1e-6);
  EXPECT_EQ(nameOfB(found.pair), "slope");
  EXPECT_NEAR(found.pair.result.normal.dot(Vector3d(1, 0, 1).normalized()), 1.0, 1e-9) << "from the cube into it";
  EXPECT_NEAR(scene_.minimum(of_cube, motion(9.0)).upper_bound, -2.0 / std::sqrt(2.0), 1e-6);
  const RobotMinimum of_ball = scene_.minimum(candidates_, motion(9.0));
  EXPECT_NEAR(of_ball.upper_bound, -2.0 / std::sqrt(2.0) - 0.5, 1e-6) << "at z = 10";
  EXPECT_NEAR(of_ball.lower_bound, of_ball.upper_bound, 1e-6);
  EXPECT_FALSE(of_ball.pair.depth_is_lower_bound);
}

TEST_F(CubeAndBall, HalfSpaceIsNamedByItsNumberInTheObject) {
  const ObjectShape far_away{Sphere{0.1}, at(0, 50, 50)};
  add(makeObject("slope", {far_away, far_away, {HalfSpace{{-1, 0, 0}, -4.0}}}, Fixed{}));
  const RobotTimeOfContact found = contact(motion(8.0));
  ASSERT_TRUE(found.contact);
  EXPECT_EQ(found.pair.collision_a, 1);
  EXPECT_EQ(found.pair.collision_b, 3);
}

TEST_F(CubeAndBall, AttachedObjectGoesAheadOfItsLink) {
  add(cube("wall", Fixed{at(4, 0, 0)}));
  add(cube("nose", Attached{"cube", {}, at(0.75, 0, 0)}, 0.5));
  const RobotTimeOfContact found = contact(motion(6.0));
  ASSERT_TRUE(found.contact);
  EXPECT_NEAR(found.t_contact, 2.5 / 6.0, 1e-6);
  EXPECT_EQ(found.pair.asked.a.link(), -1);
}

TEST_F(CubeAndBall, MovingObjectRestsInItsFrameUnlessATwistIsGiven) {
  add(cube("pallet", Moving{"cart", at(0, 0, 0)}));
  RobotMotion rest = motion(6.0);
  rest.carryObjects({{-1, true, {}}, {RobotMotion::atRest(at(4, 0, 0))}});
  EXPECT_NEAR(contact(rest).t_contact, 0.5, 1e-6);
  RobotMotion towards = motion(3.0);
  towards.carryObjects({{-1, true, {}}, {RobotMotion::withTwist(at(4, 0, 0), {{-3, 0, 0}, {0, 0, 0}})}});
  EXPECT_NEAR(contact(towards).t_contact, 0.5, 1e-6) << "each goes 1.5 of the gap of 3";
}

TEST_F(CubeAndBall, FrameOfABodyCarriesItsObjects) {
  add(cube("on the cube", Moving{"cube", at(0, 3, 0)}));
  RobotMotion carried = motion(6.0);
  carried.carryObjects({{-1, true, {}}, {RobotMotion::atRest(Isometry3d::Identity(), bodyOf(model_->robot, "cube"))}});
  const RobotMinimum minimum = scene_.minimum(candidates_, carried);
  EXPECT_NEAR(minimum.lower_bound, 2.0, 1e-6);
  EXPECT_NEAR(minimum.upper_bound, 2.0, 1e-6);
}

// Seen from the cube, the world with its object comes to the ball.
TEST_F(CubeAndBall, WorldThatABodyCarriesTakesItsFixedObjectsAlong) {
  add(cube("before the ball", Fixed{at(-4, 0, 10)}));
  RobotMotion carried = motion(6.0);
  carried.carryObjects({RobotMotion::atRest(Isometry3d::Identity(), bodyOf(model_->robot, "cube")), {}});
  const RobotTimeOfContact found = contact(carried);
  ASSERT_TRUE(found.contact);
  EXPECT_NEAR(found.t_contact, 3.0 / 6.0, 1e-6);
  EXPECT_EQ(found.pair.asked.a.link(), model_->robot.findLink("ball"));
  EXPECT_NEAR(found.pair.result.point_b.x(), -0.5, 1e-5) << "in the frame of the poses";
}

TEST_F(CubeAndBall, MissingFrameMakesItsPairsUnknownAndCounted) {
  add(cube("pallet", Moving{"cart", at(4, 0, 0)}));
  RobotMotion missing = motion(1.0);
  for (const bool given : {false, true}) {
    if (given) missing.carryObjects({{-1, true, {}}, {RobotMotion::atRest(std::nullopt)}});
    const RobotTimeOfContact found = contact(missing);
    EXPECT_EQ(found.counts.pairs, 1 + 2);
    EXPECT_EQ(found.counts.unknown, 2);
    EXPECT_EQ(scene_.minimum(Pairs(candidates_, PairKind::WithObject), missing).status, Status::Unknown);
  }
}

TEST_F(CubeAndBall, UnknownWorldLeavesNoPairWithAnObjectKnown) {
  add(cube("wall", Fixed{at(4, 0, 0)}));
  RobotMotion lost = motion(6.0);
  lost.carryObjects({RobotMotion::atRest(std::nullopt), {}});
  const RobotTimeOfContact found = contact(lost);
  EXPECT_EQ(found.counts.unknown, 2);
  EXPECT_FALSE(found.contact);
  EXPECT_EQ(scene_.minimum(Pairs(candidates_, PairKind::WithObject), lost).lower_bound, -kInfinity);
}

TEST_F(CubeAndBall, UnknownWorldLeavesWhatIsAttachedKnown) {
  add(cube("wall", Fixed{at(4, 0, 0)}));
  add(cube("held", Attached{"cube", {}, at(0, 0, 3)}));
  RobotMotion lost = motion(6.0);
  lost.carryObjects({RobotMotion::atRest(std::nullopt), {}});
  const RobotMinimum minimum = scene_.minimum(Pairs(candidates_, PairKind::WithObject), lost);
  EXPECT_EQ(minimum.counts.pairs, 4);
  EXPECT_EQ(minimum.counts.unknown, 3) << "all with the wall";
  EXPECT_GE(minimum.counts.by_one_bound, 0);
  EXPECT_NEAR(minimum.upper_bound, 6.0, 1e-6) << "of the ball from the cube below it";
  EXPECT_LE(minimum.lower_bound, 6.0);
}

TEST_F(CubeAndBall, UnknownWorldHidesNothingThatIsInsideOfAClosedMesh) {
  add(solid("held solid", Attached{"cube", {}, at(-5, -5, 6)}));
  RobotMotion lost = motion(0.25);
  lost.carryObjects({RobotMotion::atRest(std::nullopt), {}});
  const RobotMinimum minimum = scene_.minimum(candidates_, lost);
  EXPECT_LE(minimum.lower_bound, -4.5) << "the ball is inside of it";
  EXPECT_NEAR(minimum.upper_bound, -4.5, 1e-6);
  EXPECT_TRUE(contact(lost).contact);
}

TEST_F(CubeAndBall, KindOfPairsIsHeeded) {
  add(cube("wall", Fixed{at(4, 0, 0)}));
  EXPECT_FALSE(scene_.timeOfContact(Pairs(candidates_, PairKind::OfLinks), motion(6.0)).contact);
  EXPECT_TRUE(scene_.timeOfContact(Pairs(candidates_, PairKind::WithObject), motion(6.0)).contact);
  EXPECT_EQ(scene_.timeOfContact(Pairs(candidates_, PairKind::WithObject), motion(6.0)).counts.pairs, 2);
}

TEST_F(CubeAndBall, TwinHasTheSameObjects) {
  add(cube("wall", Fixed{at(4, 0, 0)}));
  EXPECT_TRUE(scene_.forAnotherThread().timeOfContact(candidates_, motion(6.0)).contact);
  EXPECT_TRUE(MotionSearch(model_).objects()->empty());
}

TEST_F(CubeAndBall, RemovedObjectIsNotMet) {
  add(cube("wall", Fixed{at(4, 0, 0)}));
  change(RemoveObject{"wall"});
  EXPECT_FALSE(contact(motion(6.0)).contact);
}

TEST_F(CubeAndBall, BadQuestionsAreRefused) {
  EXPECT_THROW(scene_.use(std::make_shared<const Objects>(cubeAndBall())), std::invalid_argument);
  const std::vector<ShapeRefPair> nobody{{{1}, ShapeRef::ofObject(7)}};
  EXPECT_THROW(scene_.minimum(nobody, motion(1.0)), std::invalid_argument);
  add(makeObject("floor", {{HalfSpace{{0, 0, 1}}}}, Fixed{}));
  add(makeObject("ceiling", {{HalfSpace{{0, 0, -1}}}}, Fixed{}));
  EXPECT_THROW(scene_.minimum(nobody, motion(1.0)), std::invalid_argument);
  const std::vector<ShapeRefPair> both{{ShapeRef::ofObject(0), ShapeRef::ofObject(1)}};
  EXPECT_THROW(scene_.minimum(both, motion(1.0)), std::invalid_argument);
  RobotMotion frames = motion(1.0);
  frames.carryObjects({{-1, true, {}}, {RobotMotion::atRest(at(0, 0, 0))}});
  EXPECT_THROW(contact(frames), std::invalid_argument) << "no object moves with a frame";
  EXPECT_THROW(frames.carryObjects({RobotMotion::atRest(at(0, 0, 0), 99), {}}), std::invalid_argument);
  EXPECT_THROW(frames.carryObjects({{-1, true, {}}, {RobotMotion::withTwist(at(0, 0, 0), {{NAN, 0, 0}, {0, 0, 0}})}}),
               std::invalid_argument);
}

// The phases of a motion are parts of it, those of a screw too.
TEST_F(CubeAndBall, PhasesCarryObjectsAsTheWholeMotionDoes) {
  const BodyPoses start = forwardKinematics(model_->robot, positions(0.0, 0.0));
  Motion phased = motionWithinLimits(model_->robot, start, positions(20.0, 40.0)).motion;
  ASSERT_EQ(phased.pieces().size(), 3u);
  RobotMotion whole = RobotMotion::ofTravel(model_->robot, start, positions(20.0, 40.0));
  const ObjectFrames frames{RobotMotion::withTwist(at(1, 2, 3), {{1, 0, 2}, {0, 0.7, 0.2}}),
                            {RobotMotion::withTwist(at(4, 0, 1), {{-3, 1, 0}, {0.5, 0, 1}})}};
  phased.carryObjects(frames);
  whole.carryObjects(frames);
  for (const double time : {0.0, 0.1, 0.3, 0.7, 1.0}) {
    const Isometry3d found = *phased.inWorld(time).frames[0], expected = *whole.inWorld(time).frames[0];
    EXPECT_LE((found.matrix() - expected.matrix()).norm(), 1e-13) << time;
    const Isometry3d rail = *phased.inWorld(time).bodies[0], of_whole = *whole.inWorld(time).bodies[0];
    EXPECT_LE((rail.matrix() - of_whole.matrix()).norm(), 1e-13) << time;
  }
}

// --- many objects

/// A grid of 100 x 100 x 1 cubes of edge 0.1, half a metre apart, below the cube's way: 0.75 below its lower face.
Vector3d cornerOfGrid(int i) { return {0.5 * (i % 100) - 10.0, 0.5 * (i / 100) - 25.0, -1.35}; }
constexpr int kGrid = 10000;

TEST_F(CubeAndBall, OfTenThousandBoxesOnlyTheNearOnesAreExamined) {
  Boxes boxes;
  std::vector<ObjectChange> changes;
  for (int i = 0; i < kGrid; ++i) {
    const Vector3d corner = cornerOfGrid(i);
    boxes.boxes.emplace_back(corner, corner + Vector3d::Constant(0.1));
    changes.push_back(AddObject{
        cube("cube " + std::to_string(i), Fixed{at(0, 0, 0.05) * Isometry3d(Eigen::Translation3d(corner))}, 0.1)});
  }
  objects_ = std::make_shared<const Objects>(objects_->changed(changes));
  scene_.use(objects_);
  const RobotTimeOfContact many = contact(motion(6.0));
  EXPECT_FALSE(many.contact);
  EXPECT_EQ(many.status, Status::Converged);
  EXPECT_EQ(many.counts.pairs, 1 + 2 * kGrid);
  EXPECT_EQ(many.counts.unknown, 0);
  EXPECT_LT(many.counts.intervals, 300);
  EXPECT_GE(many.counts.by_one_bound, many.counts.pairs - 100);
  const RobotMinimum nearest = scene_.minimum(candidates_, motion(6.0));
  EXPECT_NEAR(nearest.upper_bound, 0.75, 1e-6);
  EXPECT_LT(nearest.counts.intervals, 3000) << "some 40 are equally near";

  objects_ =
      std::make_shared<const Objects>(Objects(model_).changed({AddObject{makeObject("map", {{boxes}}, Fixed{})}}));
  scene_.use(objects_);
  const RobotTimeOfContact map = contact(motion(6.0));
  EXPECT_FALSE(map.contact);
  EXPECT_EQ(map.counts.pairs, 1 + 2);
  EXPECT_LT(map.counts.intervals, 300);
  const RobotMinimum in_map = scene_.minimum(candidates_, motion(6.0));
  EXPECT_NEAR(in_map.upper_bound, 0.75, 1e-6);
  EXPECT_LT(in_map.counts.intervals, 3000);
}

// --- closed meshes

// The walls of the bracket are 10 m thick. The ball is 4 m above its lower face, and farther from all others.
TEST_F(CubeAndBall, WhatIsInsideOfAClosedMeshIsInContactFromTheStartAndAsDeepAsItIs) {
  add(solid("solid", Fixed{at(-5, -5, 6)}));
  for (const bool in_the_tree : {false, true}) {
    for (int i = 0; in_the_tree && i < 40; ++i) add(cube(std::to_string(i), Fixed{at(100 + i, 50, 0)}));
    EXPECT_EQ(objects_->fixed().tree().empty(), !in_the_tree);
    const RobotTimeOfContact found = contact(motion(0.25));
    EXPECT_EQ(found.status, Status::Converged);
    ASSERT_TRUE(found.contact);
    EXPECT_EQ(found.t_contact, 0.0);
    EXPECT_NEAR(found.pair.result.distance, -4.5, 1e-9);
    EXPECT_EQ(nameOfB(found.pair), "solid");
    const RobotMinimum minimum = scene_.minimum(candidates_, motion(0.25));
    EXPECT_LE(minimum.lower_bound, -4.5);
    EXPECT_NEAR(minimum.upper_bound, -4.5, 1e-6);
    EXPECT_GE(minimum.lower_bound, -4.51);
  }
}

TEST_F(CubeAndBall, OverlapWithAClosedMeshThatMayGetDeeperIsLeftOpen) {
  add(solid("solid", Fixed{at(0, -5, -5)}));  // its face is at x = 0, in the middle of the cube
  const ShapeRefPair pair{{model_->robot.findLink("cube")}, ShapeRef::ofObject(0)};
  MotionQuestion question;
  ASSERT_EQ(contact(motion(-2.0), question).t_contact, 0.0);
  question.nearer_pairs = {{pair, -0.500001}};
  const RobotTimeOfContact open = contact(motion(-2.0), question);
  EXPECT_EQ(open.status, Status::IterationLimit);
  EXPECT_EQ(open.t_free, 0.0);
  question.nearer_pairs.front().contact_distance = -kInfinity;
  const RobotTimeOfContact left_out = contact(motion(-2.0), question);
  EXPECT_EQ(left_out.status, Status::Converged);
  EXPECT_EQ(left_out.t_free, 1.0);
}

// --- far away

using Vector3l = Eigen::Matrix<long double, 3, 1>;
using Matrix3l = Eigen::Matrix<long double, 3, 3>;

/// A point of a frame, with the rotation that is nearest to the matrix of its pose.
Vector3l inParent(const Isometry3d& pose, const Vector3l& p) {
  Matrix3l rotation = pose.linear().cast<long double>();
  for (int i = 0; i < 4; ++i)
    rotation = 0.5L * rotation * (3.0L * Matrix3l::Identity() - rotation.transpose() * rotation);
  return rotation * p + pose.translation().cast<long double>();
}

// --- pairs of several pieces

/// Two links, each of balls that turn about the z axis, and an object of balls, with or without a half-space.
class PairsOfSeveralPieces : public testing::Test {
 protected:
  enum class World { Known, Unknown };

  void place(const std::vector<ObjectShape>& shapes, const Placement& placement) {
    // A fixed one, so that the world counts.
    objects_ = std::make_shared<const Objects>(
        Objects(model_).changed({AddObject{makeObject("asked", shapes, placement)},
                                 AddObject{makeObject("far", {{Shape(Sphere{0.1})}}, Fixed{at(0, 0, 50)})}}));
    moving_.use(objects_);
    still_.use(objects_);
  }

  /// Asks about the pair with all kinds of time, and checks what is said about it.
  void expectBoundsOfTheWholePair(World world) {
    const ShapeRefPair pair{{model_->robot.findLink("right")}, ShapeRef::ofObject(objects_->find("asked"))};
    const std::vector<ShapeRefPair> asked{pair};
    RobotMotion motion = RobotMotion::between(model_->robot, {real(-3, 3), real(-3, 3)}, {real(-3, 3), real(-3, 3)});
    RobotMotion::ObjectFrames frames;
    const Link& left = model_->robot.links[model_->robot.findLink("left")];
    if (!objects_->frames().empty()) frames.moving = {RobotMotion::atRest(left.body_T_link, left.body)};
    if (world == World::Unknown) frames.world = RobotMotion::atRest(std::nullopt);
    motion.carryObjects(frames);
    for (int i = 0; i < 12; ++i) {
      MotionQuestion question;
      question.contact_distance = real(-0.2, 0.6);
      const auto deadline = [i] { return std::chrono::steady_clock::now() + std::chrono::microseconds(i * i); };
      if (i < 11) question.deadline = deadline();
      const RobotTimeOfContact contact = moving_.timeOfContact(asked, motion, question);
      if (contact.contact) expectBoundsOf(contact.pair, motion, contact.t_contact);
      if (i < 11) question.deadline = deadline();
      const RobotMinimum minimum = moving_.minimum(asked, motion, question);
      if (minimum.time >= 0.0) expectBoundsOf(minimum.pair, motion, minimum.time);
      contacts_ += contact.contact ? 1 : 0;
      at_deadlines_ += minimum.time >= 0.0 && minimum.status == Status::IterationLimit ? 1 : 0;
    }
  }

  std::vector<ObjectShape> ballsOfAnObject() {
    std::vector<ObjectShape> shapes;
    for (int i = 0; i < kBalls; ++i)
      shapes.push_back({Shape(Sphere{real(0.05, 0.2)}), Isometry3d(Eigen::Translation3d(point(0.5)))});
    return shapes;
  }
  ObjectShape someHalfSpace() { return {HalfSpace{{0.3, -0.2, 1.0}, real(-0.6, -0.3)}}; }

  double real(double from, double to) { return std::uniform_real_distribution<double>(from, to)(generator_); }
  Vector3d point(double size) { return {real(-size, size), real(-size, size), real(-size, size)}; }

  Chance generator_{5};
  int contacts_ = 0, at_deadlines_ = 0;

 private:
  static constexpr int kBalls = 4;

  /// The world is where the poses are, or what is asked does not stand in it.
  void expectBoundsOf(const PairProximity& said, RobotMotion motion, double time) {
    constexpr double kRounding = 1e-12;
    motion.carryObjects({{-1, true, {}}, motion.objectFrames().moving});
    const RobotMotion::State state = motion.inWorld(time);
    still_.update(state.bodies, state.frames);
    const SignedDistance truth = still_.proximity(said.asked).result;
    EXPECT_LE(said.result.lower_bound, truth.upper_bound + kRounding);
    EXPECT_GE(said.result.upper_bound, truth.lower_bound - kRounding);
  }
  std::shared_ptr<const SceneModel> randomModel() {
    std::string parts = link("root");
    for (const std::string name : {"left", "right"}) {
      std::string balls;
      for (int i = 0; i < kBalls; ++i) {
        std::ostringstream centre;
        centre << point(0.5).transpose();
        balls += ball(std::to_string(real(0.05, 0.2)), centre.str());
      }
      parts += link(name, balls) + hinge("to_" + name, "root", name, "0 0 1");
    }
    return modelOf(urdfOf(parts));
  }

  const std::shared_ptr<const SceneModel> model_ = randomModel();
  std::shared_ptr<const Objects> objects_;
  MotionSearch moving_{model_};
  PosedScene still_{model_};
};

// Regression: where the pose of the world is not known, the lower bounds of pairs with held objects were those of two
// pieces.
TEST_F(PairsOfSeveralPieces, HaveTheBoundsOfAllOfThemInTheWorldAndWithoutIt) {
  for (int i = 0; i < repeats(60); ++i) {
    for (const bool with_half_space : {false, true}) {
      std::vector<ObjectShape> shapes = ballsOfAnObject();
      if (with_half_space) shapes.insert(shapes.begin() + 1, someHalfSpace());
      place(shapes, Fixed{Isometry3d(Eigen::Translation3d(point(0.5)))});
      expectBoundsOfTheWholePair(World::Known);
    }
    const Isometry3d left_T_object(Eigen::Translation3d(point(0.5)));
    for (const Placement& placement :
         {Placement(Attached{"left", {}, left_T_object}), Placement(Moving{"left", left_T_object})}) {
      place(ballsOfAnObject(), placement);
      expectBoundsOfTheWholePair(World::Known);
      expectBoundsOfTheWholePair(World::Unknown);
    }
  }
  EXPECT_GT(contacts_, 0);
  EXPECT_GT(at_deadlines_, 0);
}

TEST_F(PairsOfSeveralPieces, HaveTheBoundsOfAllOfThemAboveASingleHalfSpace) {
  for (int i = 0; i < repeats(60); ++i) {
    place({someHalfSpace()}, Fixed{Isometry3d(Eigen::Translation3d(point(0.5)))});
    expectBoundsOfTheWholePair(World::Known);
  }
  EXPECT_GT(contacts_, 0);
}

// The links have several parts and stand so far away that their rounding is more than the tolerance.
TEST(FarInMotion, APairWhoseBoundsAreWiderThanTheToleranceHasNotConverged) {
  const std::string balls = ball("0.1", "0.3 0.2 0.1") + ball("0.1", "-0.1 0.2 0.3");
  const auto model = modelOf(floatingLinks({balls, balls}));
  MotionSearch scene(model);
  const std::vector<ShapeRefPair> pairs{pairOf(*model, "0", "1")};
  Chance chance(4);
  for (int i = 0; i < 60; ++i) {
    const Isometry3d far(Eigen::Translation3d(1e6 * chance.direction()));
    const BodyPoses start{far, far, far * Eigen::Translation3d(chance.direction())};
    MotionQuestion question;
    question.tolerance = 1e-9;
    question.contact_distance = 2.0;
    const RobotTimeOfContact contact = scene.timeOfContact(pairs, RobotMotion::ofTwists(start, {{}, {}, {}}), question);
    ASSERT_TRUE(contact.contact);
    const SignedDistance& result = contact.pair.result;
    EXPECT_GT(result.upper_bound - result.lower_bound, question.tolerance);
    EXPECT_NE(result.status, Status::Converged);
  }
}

TEST(FarInMotion, BoundsHoldWhereverTheOriginsOfThePosesAndOfTheWorldAre) {
  const auto model = modelOf(floatingLinks({ball("0.1", "0.3 0.2 0.1"), ball("0.1", "-0.1 0.2 0.3")}));
  const ShapeRef a{model->robot.findLink("0")}, b{model->robot.findLink("1")}, fixed = ShapeRef::ofObject(0);
  Chance chance(3);
  for (int i = 0; i < 60; ++i) {
    const Vector3d far = std::pow(10.0, chance.between(0.0, 6.0)) * chance.direction();
    const Isometry3d pose_a = Eigen::Translation3d(far) * chance.pose(0.5),
                     pose_b = Eigen::Translation3d(far) * chance.pose(0.5),
                     poses_T_world = Eigen::Translation3d(chance.below(2) * far) * chance.pose(1.0),
                     world_T_object = poses_T_world.inverse() * (Eigen::Translation3d(far) * chance.pose(0.5));
    const auto objects = std::make_shared<const Objects>(
        Objects(model).changed({AddObject{makeObject("ball", {{Shape(Sphere{0.1})}}, Fixed{world_T_object})}}));
    const Vector3l centre_a = inParent(pose_a, {0.3, 0.2, 0.1}), centre_b = inParent(pose_b, {-0.1, 0.2, 0.3}),
                   centre_of_object = inParent(poses_T_world, inParent(world_T_object, Vector3l::Zero()));
    MotionSearch scene(model);
    scene.use(objects);
    RobotMotion motion = RobotMotion::ofTwists(posesOf(model->robot, {pose_a, pose_b}), std::vector<Twist>(3));
    motion.carryObjects({RobotMotion::atRest(poses_T_world), {}});
    MotionQuestion question;
    question.tolerance = 1e-12;
    const auto check = [&](const ShapeRefPair& pair, const Vector3l& from, const Vector3l& to) {
      // The coordinates of the <collision> are those of the file, rounded by the reader.
      const long double distance = (to - from).norm() - 0.2L;
      const RobotMinimum found = scene.minimum(std::vector<ShapeRefPair>{pair}, motion, question);
      EXPECT_LE(found.lower_bound, distance) << i << " at " << far.norm();
      EXPECT_GE(found.upper_bound, distance) << i << " at " << far.norm();
      EXPECT_NEAR(found.upper_bound, found.lower_bound, 1e-12 + 1e-12 * far.norm());
    };
    check({a, b}, centre_a, centre_b);
    check({a, fixed}, centre_a, centre_of_object);
    check({b, fixed}, centre_b, centre_of_object);
  }
}

// --- at random, beside states in between

/// exp() of a twist [m, rad] at the origin `at`, times a pose: the definition of a screw, without its closed form.
Isometry3d screwed(const Isometry3d& start, const Twist& twist, double time) {
  Eigen::Matrix4d generator = Eigen::Matrix4d::Zero();
  generator.block<3, 3>(0, 0) << 0, -twist.angular.z(), twist.angular.y(), twist.angular.z(), 0, -twist.angular.x(),
      -twist.angular.y(), twist.angular.x(), 0;
  generator.block<3, 1>(0, 3) = twist.linear - twist.angular.cross(start.translation());
  const Eigen::Matrix4d moved = (time * generator).exp() * start.matrix();
  return Isometry3d(moved);
}

/// A motion of the arm with its objects, and the state at each time, computed from the definitions.
struct MotionAtRandom {
  RobotMotion motion;
  /// The poses of the bodies in the frame of the motion's poses, of the world there, and of the frames in the world.
  std::function<BodyPoses(double)> bodies;
  std::function<Isometry3d(const BodyPoses&)> world;
  std::function<FramePoses(double, const BodyPoses&)> frames;

  void place(PosedScene& scene, double time) const {
    BodyPoses poses = bodies(time);
    const Isometry3d world_T_poses = world(poses).inverse();
    for (auto& pose : poses) pose = world_T_poses * *pose;
    scene.update(poses, frames(time, poses));
  }
};

enum class Meshes : unsigned char { None, Solid };
enum class Moved : unsigned char { ByJoints, ByJointsInAMovingWorld, ByTwists };

class Motions {
 public:
  Motions(std::shared_ptr<const SceneModel> model, Moved moved)
      : model_(std::move(model)), moved_(moved), chance_(static_cast<unsigned>(moved) + 3) {}

  std::shared_ptr<const Objects> someObjects(int count, Meshes meshes) {
    Objects objects(model_);
    ObjectRules rules;
    if (chance_.below(2)) rules.free_objects = ObjectRules::FreeObjects::Checked;
    objects = objects.withRules(rules);
    space_ = 1.1 * std::cbrt(count / 5.0);
    for (int i = 0; i < count; ++i) {
      const Placement placement = somePlacement(count);
      const bool is_solid = meshes == Meshes::Solid && chance_.below(3) == 0;
      Object object = (is_solid ? someSolid : someObject)("object " + std::to_string(i), placement, chance_);
      // Many half-spaces leave no room.
      while (shapesOf(object).front().description == "half-space" && chance_.below(count) > 3)
        object = someObject(object.id, placement, chance_);
      objects = objects.changed({AddObject{object}});
    }
    return std::make_shared<const Objects>(objects);
  }

  /// For objects with this number of frames.
  MotionAtRandom next(std::size_t frames) {
    MotionAtRandom result = moved_ == Moved::ByTwists ? ofTwists() : ofJoints();
    ObjectFrames carried;
    result.world = [](const BodyPoses&) { return Isometry3d::Identity(); };
    if (moved_ == Moved::ByJointsInAMovingWorld) {
      const int body = chance_.below(static_cast<int>(model_->robot.bodies.size()));
      const Isometry3d body_T_world = chance_.pose(0.5);
      carried.world = RobotMotion::atRest(body_T_world, body);
      result.world = [body, body_T_world](const BodyPoses& poses) { return *poses[body] * body_T_world; };
    }
    std::vector<std::function<Isometry3d(double, const BodyPoses&)>> each;
    for (std::size_t i = 0; i < frames; ++i) {
      const Isometry3d start = chance_.pose(0.8);
      const Twist twist = someTwist(1.0);
      const int body = chance_.below(static_cast<int>(model_->robot.bodies.size()));
      switch (chance_.below(3)) {
        case 0:
          carried.moving.push_back(RobotMotion::atRest(start));
          each.emplace_back([start](double, const BodyPoses&) { return start; });
          break;
        case 1:
          carried.moving.push_back(RobotMotion::withTwist(start, twist));
          each.emplace_back([start, twist](double time, const BodyPoses&) { return screwed(start, twist, time); });
          break;
        default:
          carried.moving.push_back(RobotMotion::atRest(start, body));
          each.emplace_back([start, body](double, const BodyPoses& in_world) { return *in_world[body] * start; });
      }
    }
    result.frames = [each](double time, const BodyPoses& in_world) {
      FramePoses poses;
      for (const auto& frame : each) poses.emplace_back(frame(time, in_world));
      return poses;
    };
    result.motion.carryObjects(carried);
    return result;
  }

 private:
  Placement somePlacement(int count) {
    switch (chance_.below(count)) {
      case 0: {
        const char* const links[] = {"hand", "fore", "camera", "base", "wrist"};
        return Attached{links[chance_.below(5)], {links[chance_.below(5)]}, chance_.pose(0.2)};
      }
      case 1:
      case 2:
        return Moving{"frame " + std::to_string(chance_.below(3)), chance_.pose(0.2)};
      default:
        return Fixed{chance_.pose(space_)};
    }
  }

  Twist someTwist(double speed) { return {speed * chance_.direction(), speed * chance_.direction()}; }

  MotionAtRandom ofJoints() {
    std::vector<double> from, travel;
    for (std::size_t i = 0; i < model_->robot.joints.size(); ++i) {
      from.push_back(chance_.between(-3.0, 3.0));
      travel.push_back(chance_.between(-1.5, 1.5));
    }
    const Isometry3d base = chance_.pose(0.3);
    const auto poses = [model = model_, from, travel, base](double time) {
      std::vector<double> positions = from;
      for (std::size_t i = 0; i < from.size(); ++i) positions[i] += time * travel[i];
      BodyPoses bodies = forwardKinematics(model->robot, positions);
      for (auto& pose : bodies) pose = base * *pose;
      return bodies;
    };
    return {RobotMotion::ofTravel(model_->robot, poses(0.0), travel), poses, {}, {}};
  }

  /// Each body on its own, the base too.
  MotionAtRandom ofTwists() {
    std::vector<double> positions;
    for (std::size_t i = 0; i < model_->robot.joints.size(); ++i) positions.push_back(chance_.between(-3.0, 3.0));
    const BodyPoses start = forwardKinematics(model_->robot, positions);
    std::vector<Twist> twists;
    for (std::size_t i = 0; i < start.size(); ++i) twists.push_back(someTwist(0.6));
    const auto poses = [start, twists](double time) {
      BodyPoses bodies = start;
      for (std::size_t i = 0; i < bodies.size(); ++i) bodies[i] = screwed(*start[i], twists[i], time);
      return bodies;
    };
    return {RobotMotion::ofTwists(start, twists), poses, {}, {}};
  }

  const std::shared_ptr<const SceneModel> model_;
  const Moved moved_;
  Chance chance_;
  double space_ = 1.1;  ///< [m] in which fixed objects stand
};

/// All checked pairs, one by one.
std::vector<ShapeRefPair> listOf(const Candidates& candidates, const Objects& objects) {
  std::vector<ShapeRefPair> pairs = candidates.list();
  for (const int number : objects.numbers()) {
    for (int link = 0; link < static_cast<int>(objects.model().robot.links.size()); ++link)
      if (objects.isChecked(link, ShapeRef::ofObject(number))) pairs.push_back({link, ShapeRef::ofObject(number)});
    for (const int other : objects.numbers()) {
      if (other < number && objects.isChecked(ShapeRef::ofObject(other), ShapeRef::ofObject(number)))
        pairs.push_back({ShapeRef::ofObject(other), ShapeRef::ofObject(number)});
    }
  }
  return pairs;
}

bool isAttached(const Objects& objects, const ShapeRefPair& pair) {
  const auto is_attached = [&](const ShapeRef& ref) {
    return ref.isObject() && std::holds_alternative<Attached>(objects.object(ref.object())->placement);
  };
  return is_attached(pair.a) || is_attached(pair.b);
}

/// Objects and a motion, if possible one that does not begin in contact. The scene takes the objects.
enum class Start : unsigned char { Any, Apart };
std::pair<std::shared_ptr<const Objects>, MotionAtRandom> nextOf(Motions& motions, PosedScene& scene, int count,
                                                                 Meshes meshes, Start start) {
  for (int tries = 0;; ++tries) {
    const std::shared_ptr<const Objects> objects = motions.someObjects(count, meshes);
    const MotionAtRandom random = motions.next(objects->frames().size());
    scene.use(objects);
    random.place(scene, 0.0);
    if (start == Start::Any || tries == 30 || scene.minimum(scene.candidates())->result.lower_bound > 0.02)
      return {objects, random};
  }
}

/// Thresholds of single pairs: the contact is the earliest of all searches that are each about one pair.
void expectTheEarliestOfAllPairs(MotionSearch& moving, const Candidates& candidates,
                                 const std::vector<ShapeRefPair>& list, const RobotMotion& motion, Chance& chance) {
  PairDistances thresholds(chance.between(0.0, 0.03), chance.between(0.0, 0.03));
  for (const ShapeRefPair& pair : list) {
    if (chance.below(2) == 0) continue;
    if (pair.areLinks())
      thresholds.setPair(pair.a.link(), pair.b.link(), chance.between(0.0, 0.15));
    else if (pair.a.isLink())
      thresholds.setWithObjects(pair.a.link(), chance.between(0.0, 0.15));
    if (pair.b.isObject() && chance.below(3) == 0) thresholds.setObject(pair.b.object(), chance.between(0.0, 0.15));
  }
  MotionQuestion question;
  question.thresholds = &thresholds;
  const RobotTimeOfContact contact = moving.timeOfContact(candidates, motion, question);
  double earliest = kInfinity;
  for (const ShapeRefPair& pair : list) {
    MotionQuestion alone;
    alone.contact_distance = thresholds.of(pair);
    const RobotTimeOfContact of_pair = moving.timeOfContact(std::vector<ShapeRefPair>{pair}, motion, alone);
    ASSERT_EQ(of_pair.status, Status::Converged);
    if (of_pair.contact) earliest = std::min(earliest, of_pair.t_contact);
  }
  ASSERT_EQ(contact.status, Status::Converged);
  ASSERT_EQ(contact.contact, earliest < kInfinity);
  if (!contact.contact) return;
  ASSERT_NEAR(contact.t_contact, earliest, 2e-3);
  ASSERT_LE(contact.pair.result.lower_bound, thresholds.of(contact.pair.asked) + 1e-6);
}

struct Case {
  const char* name;
  Moved moved;
  int objects, motions, states;
  Meshes meshes = Meshes::None;
};

struct Answers {
  RobotTimeOfContact contact;
  RobotMinimum minimum;
};

Answers answersOf(MotionSearch& moving, const Pairs& pairs, const Motion& motion, const MotionQuestion& question) {
  return {moving.timeOfContact(pairs, motion, question), moving.minimum(pairs, motion, question)};
}

/// Pairs that are skipped change nothing: two searches differ only where the distance is within the tolerance of that of
/// contact.
void expectTheSame(const Answers& answers, const Answers& of_list) {
  ASSERT_EQ(of_list.contact.status, Status::Converged);
  ASSERT_EQ(answers.contact.contact, of_list.contact.contact);
  if (answers.contact.contact) {
    ASSERT_NEAR(answers.contact.t_contact, of_list.contact.t_contact, 2e-3);
  }
  ASSERT_LE(answers.minimum.lower_bound, of_list.minimum.upper_bound);
  ASSERT_LE(of_list.minimum.lower_bound, answers.minimum.upper_bound);
}

/// No state on the way is closer than the bounds say, and the answers are those of the states that they name.
void expectWhatStatesSay(const Answers& answers, const MotionAtRandom& random, const MotionQuestion& question,
                         int states, PosedScene& scene) {
  const auto& [contact, minimum] = answers;
  double closest = kInfinity;
  for (int k = 0; k <= states; ++k) {
    const double time = static_cast<double>(k) / states;
    random.place(scene, time);
    const SignedDistance found = scene.minimum(scene.candidates())->result;
    closest = std::min(closest, found.upper_bound);
    if (time < contact.t_free) {
      ASSERT_GT(found.upper_bound, question.contact_distance - 1e-9) << time;
    }
  }
  ASSERT_GE(closest, minimum.lower_bound - 1e-9);
  if (minimum.status == Status::Converged) {
    ASSERT_LE(minimum.upper_bound - minimum.lower_bound, question.tolerance);
    ASSERT_LE(minimum.upper_bound, closest + question.tolerance);
  }
  random.place(scene, minimum.time);
  const double then = scene.proximity(minimum.pair.asked).result.distance;
  ASSERT_LE(then, minimum.upper_bound + 1e-9);
  ASSERT_GE(then, minimum.lower_bound - 1e-9);
  if (!contact.contact) return;
  random.place(scene, contact.t_contact);
  ASSERT_LE(scene.proximity(contact.pair.asked).result.lower_bound, question.contact_distance + question.tolerance);
}

class ObjectsInMotion : public testing::TestWithParam<Case> {};

TEST_P(ObjectsInMotion, ComeNoCloserOnTheWayThanTheBoundsSay) {
  const std::shared_ptr<const SceneModel> model = arm();
  Motions motions(model, GetParam().moved);
  MotionSearch moving(model);
  PosedScene scene(model);
  const Candidates& candidates = scene.candidates();
  Chance chance(3);
  int contacts = 0, with_object = 0, with_attached = 0, from_the_beginning = 0, undecided = 0;
  for (int i = 0; i < GetParam().motions && !HasFatalFailure(); ++i) {
    SCOPED_TRACE("motion " + std::to_string(i));
    const auto [objects, random] =
        nextOf(motions, scene, GetParam().objects, GetParam().meshes, i % 10 == 0 ? Start::Any : Start::Apart);
    moving.use(objects);
    MotionQuestion question;
    question.contact_distance = i % 2 == 0 ? 0.0 : 0.02;
    const std::vector<ShapeRefPair> list = listOf(candidates, *objects);
    const Answers answers = answersOf(moving, candidates, random.motion, question);
    const RobotTimeOfContact& contact = answers.contact;
    ASSERT_EQ(contact.status, Status::Converged);
    ASSERT_EQ(contact.counts.pairs, static_cast<int>(list.size()));
    ASSERT_EQ(contact.counts.unknown, 0);
    expectTheSame(answers, answersOf(moving, list, random.motion, question));
    if (i % 10 == 1) expectTheEarliestOfAllPairs(moving, candidates, list, random.motion, chance);
    expectWhatStatesSay(answers, random, question, GetParam().states, scene);
    // The depth of some overlaps stays wider than the tolerance, and so does that inside of closed meshes.
    undecided += answers.minimum.status != Status::Converged;
    contacts += contact.contact;
    from_the_beginning += contact.contact && contact.t_contact == 0.0;
    with_object += contact.contact && contact.pair.asked.b.link() < 0;
    with_attached += contact.contact && contact.pair.asked.b.link() < 0 && isAttached(*objects, contact.pair.asked);
  }
  if (kIsSanitized) return;  // what follows is of the whole test
  EXPECT_GT(contacts - from_the_beginning, GetParam().motions / 20);
  EXPECT_GT(with_object, GetParam().motions / 20);
  EXPECT_GE(with_attached, GetParam().motions / 100);
  EXPECT_LT(contacts, GetParam().motions);
  EXPECT_LE(undecided, GetParam().meshes == Meshes::Solid ? GetParam().motions / 2 : GetParam().motions / 100);
}

INSTANTIATE_TEST_SUITE_P(Motions, ObjectsInMotion,
                         testing::Values(Case{"ByJoints", Moved::ByJoints, 5, repeats(600), repeats(100)},
                                         Case{"InAMovingWorld", Moved::ByJointsInAMovingWorld, 5, repeats(600),
                                              repeats(100)},
                                         Case{"ByTwists", Moved::ByTwists, 5, repeats(600), repeats(100)},
                                         Case{"Many", Moved::ByJoints, 60, repeats(100), repeats(100)},
                                         Case{"Solids", Moved::ByJoints, 5, repeats(100), repeats(100), Meshes::Solid},
                                         Case{"SolidsInAMovingWorld", Moved::ByJointsInAMovingWorld, 5, repeats(100),
                                              repeats(100), Meshes::Solid}),
                         [](const testing::TestParamInfo<Case>& test) { return test.param.name; });

}  // namespace proximity_server::scene::objects_in_motion_test
