#include "proximity_server/scene/derivative/derivatives.h"

#include "allocations.h"
#include "proximity_server/narrowphase/shape/support.h"
#include "proximity_server/scene/loading/joined_robots.h"
#include "sanitized.h"
#include "scene/example_robots.h"
#include "scene/posed_scene.h"
#include "stress/gradient_checks.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace proximity_server::scene::derivatives_test {

using Eigen::Isometry3d;
using Eigen::Vector3d;
using Eigen::VectorXd;
using narrowphase::Box;
using narrowphase::Capsule;
using narrowphase::Cone;
using narrowphase::Cylinder;
using narrowphase::Shape;
using narrowphase::Sphere;

std::string jointOf(const std::string& name, const std::string& type, const std::string& parent,
                    const std::string& child, const std::string& more) {
  return joint(name, type, parent, child, limits("-3", "3") + more);
}

/// A scene and its derivatives.
struct Asked {
  explicit Asked(const std::shared_ptr<const SceneModel>& model) : scene(model), derivatives(model) {}

  void use(const std::shared_ptr<const Objects>& objects) { scene.use(objects); }
  void update(const BodyPoses& poses) { scene.update(poses); }

  VectorXd gradientOf(const ShapeRefPair& pair) {
    VectorXd found(scene.state.degreesOfFreedom().size());
    EXPECT_TRUE(gradient(scene.state, scene.proximity(pair), found));
    return found;
  }

  PosedScene scene;
  Derivatives derivatives;
};

// --- on paper

// The balls have a radius of 0.1. The arm of length 2 turns about z and slides along itself; the distance to the ball
// at (2, 3, 0) grows by -2 for each radian, and the slide leads along x, across the way to it.
TEST(Gradient, OfATurningArmIsItsLeverAcrossTheNormal) {
  const auto model =
      modelOf(urdfOf(link("base", ball("0.1", "2 3 0")) + link("arm") + link("tip", ball("0.1")) +
                     hinge("turn", "base", "arm", "0 0 1") + slider("slide", "arm", "tip", "1 0 0", "2 0 0")));
  Asked asked(model);
  asked.update(forwardKinematics(model->robot, std::vector<double>{0.0, 0.0}));
  const VectorXd gradient = asked.gradientOf(pairOf(*model, "base", "tip"));
  EXPECT_NEAR(gradient[0], -2.0, 1e-15);
  EXPECT_NEAR(gradient[1], 0.0, 1e-15);
  // The other way round it is the same.
  EXPECT_TRUE(asked.gradientOf(pairOf(*model, "tip", "base")).isApprox(gradient));
}

// Each wheel turns as far as it is told to: the second by -0.5 of the first, the third by 4 of the second.
TEST(Gradient, AddsWhatFollowersDoToTheColumnOfTheirLeader) {
  const std::string first = jointOf("first", "revolute", "base", "1", axis("0 0 1")),
                    next = origin("1 0 0") + axis("0 0 1");
  const auto model = modelOf(
      urdfOf(link("base", ball("0.1", "3 2 0")) + link("1") + link("2") + link("3") + link("tip", ball("0.1")) + first +
             jointOf("second", "revolute", "1", "2", next + mimic("first", "-0.5")) +
             jointOf("third", "revolute", "2", "3", next + mimic("second", "4")) + weld("mount", "3", "tip", "1 0 0")));
  Asked asked(model);
  asked.update(forwardKinematics(model->robot, std::vector<double>(3, 0.0)));
  const VectorXd gradient = asked.gradientOf(pairOf(*model, "base", "tip"));
  ASSERT_EQ(gradient.size(), 1);
  // The tip at (3, 0, 0) moves along y by 3 * 1 + 2 * (-0.5) + 1 * (-2), towards the ball.
  EXPECT_NEAR(gradient[0], 0.0, 1e-15);
  const auto lower = modelOf(urdfOf(link("base", ball("0.1", "2 2 0")) + link("1") + link("tip", ball("0.1", "1 0 0")) +
                                    first + jointOf("second", "revolute", "1", "tip", next + mimic("first", "-0.5"))));
  Asked shorter(lower);
  shorter.update(forwardKinematics(lower->robot, std::vector<double>(2, 0.0)));
  EXPECT_NEAR(shorter.gradientOf(pairOf(*lower, "base", "tip"))[0], -(2.0 - 0.5), 1e-15);
}

TEST(Gradient, InOverlapIsThatOfMinusTheDepth) {
  const auto model = modelOf(floatingLinks({ball("0.5"), ball("0.5")}));
  Asked asked(model);
  asked.update(posesOf(model->robot, {at(0, 0, 0), at(0.8, 0, 0)}));
  VectorXd expected(12);
  expected << -1, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0;
  EXPECT_TRUE(asked.gradientOf(pairOf(*model, "0", "1")).isApprox(expected, 1e-15));
}

TEST(Gradient, IsZeroForJointsThatAreNotBetweenTheTwo) {
  const std::string along = origin("1 0.2 0.1") + axis("0.3 0.4 1");
  const auto model = modelOf(
      urdfOf(link("base") + link("trunk") + link("a", ball("0.1")) + link("b", ball("0.1")) + link("b2", ball("0.1")) +
             jointOf("root", "revolute", "base", "trunk", along) + jointOf("to a", "continuous", "trunk", "a", along) +
             jointOf("to b", "prismatic", "trunk", "b", along) + jointOf("beyond b", "revolute", "b", "b2", along)));
  Asked asked(model);
  asked.update(forwardKinematics(model->robot, std::vector<double>{0.3, 0.5, 0.7, -0.2}));
  const VectorXd gradient = asked.gradientOf(pairOf(*model, "a", "b"));
  EXPECT_EQ(gradient[0], 0.0);
  EXPECT_NE(gradient[1], 0.0);
  EXPECT_NE(gradient[2], 0.0);
  EXPECT_EQ(gradient[3], 0.0);
}

TEST(Gradient, BetweenTwoRobotsHasTheJointsOfBothFromTheirRoots) {
  const RobotModel arm =
      robotOf(urdfOf(link("base") + link("tip", ball("0.1", "1 0 0")) + hinge("turn", "base", "tip", "0 0 1")));
  const auto model = modelOf(joined({{"left", arm}, {"right", arm}}));
  Asked asked(model);
  asked.update(
      placedAt(model->robot, forwardKinematics(model->robot, std::vector<double>(2, 0.0)), {at(0, 0, 0), at(0, 5, 0)}));
  const VectorXd gradient = asked.gradientOf(pairOf(*model, "left/tip", "right/tip"));
  EXPECT_NEAR(gradient[0], -1.0, 1e-15);
  EXPECT_NEAR(gradient[1], 1.0, 1e-15);
}

// --- failures

struct TwoBalls : testing::Test {
  const std::shared_ptr<const SceneModel> model = modelOf(floatingLinks({ball("0.1"), ball("0.1")}));
  const ShapeRefPair pair = pairOf(*model, "0", "1");
  const BodyPoses poses = posesOf(model->robot, {at(0, 0, 0), at(1, 0, 0)});
  Asked asked{model};
  VectorXd gradient = VectorXd::Zero(12);
};

TEST_F(TwoBalls, AnUnknownPairHasNoGradient) {
  asked.update(poses);
  PairProximity unknown;
  unknown.asked = pair;
  EXPECT_FALSE(scene::gradient(asked.scene.state, unknown, gradient));
  EXPECT_TRUE(gradient.array().isNaN().all());
  EXPECT_TRUE(std::isnan(asked.derivatives.rate(asked.scene.state, unknown, VectorXd::Zero(12))));
}

TEST_F(TwoBalls, APairThatIsOnlyKnownToBeFarHasNoGradient) {
  asked.update(poses);
  Question question;
  question.threshold = 0.1;
  const PairProximity far = asked.scene.proximity(pair, question);
  ASSERT_EQ(far.result.status, narrowphase::Status::Threshold);
  EXPECT_FALSE(scene::gradient(asked.scene.state, far, gradient));
  EXPECT_TRUE(gradient.array().isNaN().all());
}

TEST_F(TwoBalls, AMissingPoseBetweenThemLeavesNoGradient) {
  asked.update(poses);
  const PairProximity answer = asked.scene.proximity(pair);
  for (const std::string link : {"frame", "0", "1"}) {
    BodyPoses some = poses;
    some[bodyOf(model->robot, link)].reset();
    asked.scene.update(some);
    EXPECT_FALSE(scene::gradient(asked.scene.state, answer, gradient)) << link;
    EXPECT_TRUE(gradient.array().isNaN().all());
  }
}

TEST_F(TwoBalls, AnotherNumberOfColumnsThrows) {
  asked.update(poses);
  const PairProximity answer = asked.scene.proximity(pair);
  VectorXd short_one(11);
  EXPECT_THROW(scene::gradient(asked.scene.state, answer, short_one), std::invalid_argument);
  EXPECT_THROW(asked.derivatives.rate(asked.scene.state, answer, short_one), std::invalid_argument);
}

TEST(Derivatives, KeepTheirModel) {
  auto model = modelOf(floatingLinks({ball("1")}));
  const std::weak_ptr<const SceneModel> kept = model;
  const Derivatives derivatives(std::exchange(model, nullptr));
  EXPECT_FALSE(kept.expired());
}

TEST_F(TwoBalls, AnObjectThatDoesNotExistThrows) {
  asked.update(poses);
  PairProximity answer = asked.scene.proximity(pair);
  answer.asked.b = ShapeRef::ofObject(7);
  EXPECT_THROW(scene::gradient(asked.scene.state, answer, gradient), std::invalid_argument);
}

// --- against differences of the distance

void expectGradients(const GradientFamily& family, int samples) {
  using Kind = GradientObservation::Kind;
  GradientObserver observer(family);
  int judged = 0, moved = 0, overlaps = 0;
  for (int i = 0; i < samples; ++i) {
    const GradientObservation seen = observer.observe(static_cast<unsigned>(i));
    moved += static_cast<int>(seen.kind != Kind::Unmoved);
    if (seen.kind != Kind::Judged && seen.kind != Kind::Unresolved) continue;
    EXPECT_LE(seen.error, kGradientError + seen.allowed)
        << family.name << ", sample " << i << ", distance " << seen.distance;
    judged += static_cast<int>(seen.kind == Kind::Judged);
    overlaps += static_cast<int>(seen.distance < 0.0);
  }
  if (kIsSanitized) return;
  EXPECT_GT(moved, samples * 9 / 10) << family.name;
  EXPECT_GT(judged, moved * 9 / 10) << family.name;
  if (family.is_pair_of_solids) return;
  EXPECT_GT(overlaps, samples / 100) << family.name;
}

TEST(Gradient, OfEveryPairOfShapesIsTheDerivativeOfTheDistance) {
  for (const GradientFamily& family : pairsOfShapes()) expectGradients(family, repeats(150));
}

TEST(Gradient, OfTheDemoRobotIsTheDerivativeOfTheDistance) {
  for (const GradientFamily& family : demoRobots()) expectGradients(family, repeats(1000));
}

TEST(Gradient, OfTheExampleRobotsIsTheDerivativeOfTheDistance) {
  const std::vector<GradientFamily> families = exampleRobots();
  if (families.empty()) GTEST_SKIP() << kExampleRobotsMissing;
  for (const GradientFamily& family : families) expectGradients(family, repeats(500));
}

// --- the rate where the witness points are not unique

/// A shape that is turned so that a face, an edge or a corner of it is the highest part, and around the origin.
struct Facing {
  std::string name;
  Shape shape;
  Isometry3d pose;
  int dimension;
};

Facing facing(const std::string& name, const Shape& shape, const Vector3d& direction) {
  const Vector3d up = direction.normalized();
  int vertex = 0;
  Vector3d middle = supportPoint(shape, up, vertex);
  const auto feature = supportFeature(shape, up, 1e-12, vertex);
  Vector3d along = up.unitOrthogonal();
  if (feature.dimension == 1) {
    along = feature.along.normalized();
    middle -= along.dot(middle - shape.centre()) * along;
  }
  if (feature.dimension == 2) middle = shape.centre() + up.dot(middle - shape.centre()) * up;
  Isometry3d pose = Isometry3d::Identity();
  pose.linear() << along, up.cross(along), up;  // columns
  pose.linear().transposeInPlace();
  pose.translation() = -(pose.linear() * (middle + shape.margin() * up));
  return {name, shape, pose, feature.dimension};
}

/// A hull with a hexagon at the bottom and a roof.
Shape frustum() {
  std::vector<Vector3d> points{{0.1, 0.2, 0.4}, {-0.1, 0.15, 0.38}, {0.05, -0.2, 0.42}};
  for (int i = 0; i < 6; ++i)
    points.emplace_back(0.3 * std::cos(i + 0.1 * i * i), 0.35 * std::sin(i + 0.1 * i * i), 0.0);
  return narrowphase::ConvexHull(points);
}

std::vector<Facing> facings() {
  const Shape box = Box{{0.6, 0.8, 0.5}}, cylinder = Cylinder{0.3, 0.7}, cone = Cone{0.35, 0.6};
  return {facing("face of a box", box, {0, 0, 1}),
          facing("edge of a box", box, {1, 0.6, 0}),
          facing("corner of a box", box, {1, 0.8, 0.7}),
          facing("face of a padded box", Shape(Box{{0.4, 0.3, 0.5}}).padded(0.1), {1, 0, 0}),
          facing("end of a cylinder", cylinder, {0, 0, -1}),
          facing("side of a cylinder", cylinder, {0.6, 0.8, 0}),
          facing("rim of a cylinder", cylinder, {0.6, 0, 0.8}),
          facing("base of a cone", cone, {0, 0, -1}),
          facing("side of a cone", cone, {0.6, 0, 0.35}),
          facing("side of a capsule", Capsule{0.2, 0.6}, {0, 1, 0}),
          facing("ball", Sphere{0.3}, {0, 0, 1}),
          facing("face of a hull", frustum(), {0, 0, -1})};
}

/// Whether the way out of a shallow overlap is across the plane between the two: not for two ridges.
bool hasWayOutAcross(const Facing& a, const Facing& b) {
  const auto isSharp = [](const Facing& f) {
    return f.name == "edge of a box" || f.name == "corner of a box" || f.name == "rim of a cylinder";
  };
  return !isSharp(a) || !isSharp(b);
}

struct Rates {
  int judged = 0, choices = 0, below_gradient = 0;
};

/// Two free shapes, the second upside down over the first, with the distance given.
class Meeting {
 public:
  Meeting(const Facing& a, const Facing& b)
      : a_(a), b_(b), model_(modelOf(floatingLinks({"", ""}))), asked_(model_), exact_(model_) {
    const auto objects = std::make_shared<const Objects>(
        Objects(model_).changed({AddObject{makeObject("a", {{a.shape}}, Attached{"0"})},
                                 AddObject{makeObject("b", {{b.shape}}, Attached{"1"})}}));
    asked_.use(objects);
    exact_.use(objects);
    pair_ = {ShapeRef::ofObject(objects->find("a")), ShapeRef::ofObject(objects->find("b"))};
  }

  void expectRate(double distance, Chance& chance, Rates& seen) {
    Posture posture(model_->robot);
    place(posture, distance, chance);
    const GradientSample sample{posture, pair_};
    const DegreesOfFreedom& columns = asked_.scene.state.degreesOfFreedom();
    VectorXd velocity(12), gradient(12);
    for (Eigen::Index i = 0; i < velocity.size(); ++i) velocity[i] = chance.between(-0.5, 0.5);
    asked_.update(posture.poses());
    const PairProximity answer = asked_.scene.proximity(pair_);
    ASSERT_NEAR(answer.result.distance, distance, 1e-9) << a_.name << ", " << b_.name;
    ASSERT_TRUE(scene::gradient(asked_.scene.state, answer, gradient));
    const double rate = asked_.derivatives.rate(asked_.scene.state, answer, velocity), along = gradient.dot(velocity);
    EXPECT_LE(rate, along);
    if (answer.result.unique) {
      EXPECT_EQ(rate, along);
    }
    seen.choices += static_cast<int>(!answer.result.unique);
    seen.below_gradient += static_cast<int>(rate < along - 1e-3);
    const auto difference = forwardDifference(DistanceAlong(exact_, columns, sample, velocity));
    if (!difference) return;
    ++seen.judged;
    EXPECT_NEAR(rate, difference->value, 1e-7 + difference->error)
        << a_.name << ", " << b_.name << ", distance " << distance << ", gradient " << along
        << (answer.result.unique ? ", unique" : ", a choice");
  }

 private:
  void place(Posture& posture, double distance, Chance& chance) const {
    // A line is along x, and lies over another line; a point lies over what it meets.
    const bool has_face = a_.dimension == 2 || b_.dimension == 2, has_point = a_.dimension == 0 && b_.dimension == 0;
    const double spin = has_face ? chance.between(-M_PI, M_PI) : 0.0;
    const double along = has_point ? 0.0 : chance.between(-0.1, 0.1);
    const double across = has_face ? chance.between(-0.1, 0.1) : 0.0;
    const Isometry3d upside_down = turned(M_PI, {1, 0, 0});
    const Isometry3d over =
        Eigen::Translation3d(along, across, distance) * turned(spin, {0, 0, 1}) * upside_down * b_.pose;
    const Isometry3d world = chance.pose(1.0);
    posture.setMotion(0, world * a_.pose);
    posture.setMotion(1, world * over);
  }

  const Facing& a_;
  const Facing& b_;
  std::shared_ptr<const SceneModel> model_;
  Asked asked_;
  PosedScene exact_;
  ShapeRefPair pair_;
};

TEST(Rate, OfFacesAndEdgesThatAreParallelIsTheOneSidedDerivative) {
  const std::vector<Facing> all = facings();
  const int samples = repeats(30);
  Chance chance(3);
  Rates seen;
  int asked = 0;
  for (std::size_t i = 0; i < all.size(); ++i) {
    for (std::size_t j = i; j < all.size(); ++j) {
      Meeting meeting(all[i], all[j]);
      for (int k = 0; k < samples; ++k, ++asked) {
        const bool overlap = k % 2 == 1 && hasWayOutAcross(all[i], all[j]);
        meeting.expectRate(overlap ? -chance.between(0.002, 0.02) : chance.between(0.02, 0.3), chance, seen);
        if (testing::Test::HasFatalFailure()) return;
      }
    }
  }
  if (kIsSanitized) return;
  EXPECT_GT(seen.judged, asked * 9 / 10);
  EXPECT_GT(seen.choices, asked * 4 / 10);
  EXPECT_GT(seen.below_gradient, asked * 3 / 10);
}

/// Any velocity of two bodies that float freely.
VectorXd anyVelocity(Chance& chance, Eigen::Index size) {
  VectorXd velocity(size);
  for (Eigen::Index i = 0; i < size; ++i) velocity[i] = chance.between(-0.5, 0.5);
  return velocity;
}

/// The rate of a pair in a posture is the one-sided derivative, whatever the velocity.
void expectRates(const std::shared_ptr<const SceneModel>& model, const std::shared_ptr<const Objects>& objects,
                 const GradientSample& sample) {
  Asked asked(model);
  PosedScene exact(model);
  if (objects) {
    asked.use(objects);
    exact.use(objects);
  }
  asked.update(sample.posture.poses());
  const PairProximity answer = asked.scene.proximity(sample.pair);
  ASSERT_FALSE(answer.result.unique);
  const DegreesOfFreedom& columns = asked.scene.state.degreesOfFreedom();
  Chance chance(17);
  int judged = 0, below_gradient = 0;
  const int samples = repeats(60);
  for (int i = 0; i < samples; ++i) {
    const VectorXd velocity = anyVelocity(chance, columns.size());
    const double rate = asked.derivatives.rate(asked.scene.state, answer, velocity);
    below_gradient += static_cast<int>(rate < asked.gradientOf(sample.pair).dot(velocity) - 1e-3);
    const auto difference = forwardDifference(DistanceAlong(exact, columns, sample, velocity));
    if (!difference) continue;
    ++judged;
    EXPECT_NEAR(rate, difference->value, 1e-7 + difference->error);
  }
  if (kIsSanitized) return;
  EXPECT_GT(judged, samples * 9 / 10);
  EXPECT_GT(below_gradient, samples / 3);
}

// The plate of 1 m lies over two boxes of one link, whose far ends decide; between them is nothing.
TEST(Rate, IsTheSmallestOverAllPiecesInThePlaneOfTheContact) {
  const auto model = modelOf(floatingLinks(
      {box("0.2 0.3 0.2", "-0.3 0 -0.1") + box("0.2 0.4 0.6", "0.4 0 -0.3"), box("1 0.2 0.1", "0 0 0.05")}));
  for (const double distance : {0.1, -0.003}) {
    Posture posture(model->robot);
    posture.setMotion(0, turned(0.3, {1, 2, 3}));
    posture.setMotion(1, turned(0.3, {1, 2, 3}) * at(0.02, 0.01, distance));
    expectRates(model, nullptr, {posture, pairOf(*model, "0", "1")});
  }
}

TEST(Rate, OverAHalfSpaceIsTheSmallestOverTheFaceOfTheOther) {
  const auto model = modelOf(floatingLinks({box("0.3 0.4 0.5"), ""}));
  const auto objects = std::make_shared<const Objects>(
      Objects(model).changed({AddObject{makeObject("floor", {{HalfSpace{{1, 1, 1}, 0.2}}}, Fixed{})}}));
  const Vector3d up = Vector3d(1, 1, 1).normalized();
  const ShapeRef link{model->robot.findLink("0")}, floor = ShapeRef::ofObject(objects->find("floor"));
  for (const double distance : {0.1, -0.003}) {
    Posture posture(model->robot);
    Isometry3d pose = Isometry3d::Identity();
    pose.linear() = turnFromZ(up).toRotationMatrix();
    pose.translation() = (0.2 + 0.25 + distance) * up;
    posture.setMotion(0, pose);
    expectRates(model, objects, {posture, {link, floor}});
    expectRates(model, objects, {posture, {floor, link}});
  }
}

// Regression: where rounding made the flagstone the closest one, only what is over it counted.
TEST(Rate, CountsAHalfSpaceInThePlaneOfAPieceOfTheSameObject) {
  const auto model = modelOf(floatingLinks({box("0.3 0.4 0.5"), ""}));
  int closest[3] = {0, 0, 0};
  for (int i = 0; i < 20; ++i) {
    const Isometry3d pose = turned(0.1 * i, {1, 2, 3});
    // By so little one of the two is the closest.
    const double above = i % 2 == 0 ? 1e-13 : -1e-13;
    const std::vector<ObjectShape> shapes{{HalfSpace{{0, 0, 1}, 0.0}},
                                          {Box{{0.1, 0.1, 0.04}}, at(0.05, 0.03, above - 0.02)}};
    const auto objects = std::make_shared<const Objects>(
        Objects(model).changed({AddObject{makeObject("paved floor", shapes, Fixed{pose})}}));
    const ShapeRef link{model->robot.findLink("0")}, paved_floor = ShapeRef::ofObject(0);
    Posture posture(model->robot);
    posture.setMotion(0, pose * at(0, 0, 0.35));
    PosedScene scene(model);
    scene.use(objects);
    scene.update(posture.poses());
    ++closest[scene.proximity({link, paved_floor}).collision_b];
    expectRates(model, objects, {posture, {link, paved_floor}});
    expectRates(model, objects, {posture, {paved_floor, link}});
  }
  EXPECT_GT(closest[1], 2);
  EXPECT_GT(closest[2], 2);
}

// 3 cm of padding for each link, and 2 cm for their pair.
TEST(Rate, AllowsForPaddings) {
  auto model = std::make_shared<SceneModel>();
  model->robot = floatingLinks({box("0.3 0.4 0.5"), box("0.5 0.2 0.3")});
  for (Piece& piece : model->robot.pieces) piece.shape = piece.shape.padded(0.03);
  PairFilterOptions filter;
  filter.pair_padding = {{{"0", "1"}, 0.02}};
  model->pairs = filterPairs(model->robot, "", filter);
  Posture posture(model->robot);
  posture.setMotion(1, at(0.05, 0.02, 0.9));
  expectRates(model, nullptr, {posture, pairOf(*model, "0", "1")});
}

// Each of the six ways out of a cube is as short, and the distance is the largest of the six.
TEST(Rate, OfConcentricShapesIsALowerBound) {
  const auto model = modelOf(floatingLinks({box("1 1 1"), ball("0.2")}));
  const ShapeRefPair pair = pairOf(*model, "0", "1");
  Asked asked(model);
  asked.update(Posture(model->robot).poses());
  const PairProximity answer = asked.scene.proximity(pair);
  ASSERT_FALSE(answer.result.unique);
  Chance chance(7);
  int lower = 0;
  for (int i = 0; i < 20; ++i) {
    const VectorXd velocity = anyVelocity(chance, 12);
    const double rate = asked.derivatives.rate(asked.scene.state, answer, velocity);
    // The ball moves as seen from the cube, and the nearest face on its way decides.
    const double truth = (velocity.segment<3>(6) - velocity.head<3>()).cwiseAbs().maxCoeff();
    EXPECT_LE(-truth - 1e-12, rate);
    EXPECT_LE(rate, truth + 1e-12);
    lower += static_cast<int>(rate < truth - 1e-3);
  }
  EXPECT_GT(lower, 5);
}

TEST(Rate, OfAMovingObjectNeedsItsPoseWhereAFaceMeetsAFace) {
  const auto model = modelOf(floatingLinks({box("0.3 0.4 0.5"), ""}));
  const auto objects = std::make_shared<const Objects>(
      Objects(model).changed({AddObject{makeObject("tray", {{Box{{0.2, 0.2, 0.1}}}}, Moving{"frame of the tray"})}}));
  const ShapeRefPair pair{{model->robot.findLink("0")}, ShapeRef::ofObject(objects->find("tray"))};
  const BodyPoses poses = posesOf(model->robot, {at(0, 0, 0)});
  Asked asked(model);
  asked.use(objects);
  asked.scene.update(poses, {at(0, 0, 0.5)});
  const PairProximity answer = asked.scene.proximity(pair);
  ASSERT_FALSE(answer.result.unique);
  VectorXd turn = VectorXd::Zero(12);
  turn[3] = 1.0;  // of the link about x: its face rises by y
  asked.scene.update(poses);
  EXPECT_TRUE(std::isnan(asked.derivatives.rate(asked.scene.state, answer, turn)));
  asked.scene.update(poses, {at(0, 0, 0.5)});
  EXPECT_NEAR(asked.derivatives.rate(asked.scene.state, answer, turn), -0.1, 1e-8);  // half of the tray
}

TEST(Derivatives, AllocateNothingAfterTheFirstQuestion) {
  const auto model = modelOf(floatingLinks({box("0.3 0.4 0.5"), cylinder("0.3", "0.5")}));
  const auto objects = std::make_shared<const Objects>(
      Objects(model).changed({AddObject{makeObject("hull", {{frustum()}}, Fixed{})},
                              AddObject{makeObject("tray", {{Box{{0.2, 0.2, 0.1}}}}, Moving{"tray"})}}));
  Asked asked(model);
  asked.use(objects);
  const BodyPoses poses = posesOf(model->robot, {at(0, 0, -0.6), at(0, 0, -1.7)});
  const FramePoses frames{at(0.02, 0, -1.15)};
  asked.scene.update(poses, frames);
  const ShapeRef tray = ShapeRef::ofObject(objects->find("tray")), hull = ShapeRef::ofObject(objects->find("hull"));
  const ShapeRef block{model->robot.findLink("0")}, can{model->robot.findLink("1")};
  std::vector<PairProximity> answers;
  for (const ShapeRefPair& pair : {ShapeRefPair{block, can}, ShapeRefPair{can, tray}, ShapeRefPair{hull, block}})
    answers.push_back(asked.scene.proximity(pair));
  asked.scene.update(poses, frames);
  VectorXd gradient(12);
  const VectorXd velocity = VectorXd::Ones(12);
  asked.derivatives.rate(asked.scene.state, answers.front(), velocity);
  const long before = allocations();
  for (const PairProximity& answer : answers) {
    asked.scene.update(poses, frames);
    EXPECT_TRUE(scene::gradient(asked.scene.state, answer, gradient));
    EXPECT_FALSE(answer.result.unique);
    EXPECT_FALSE(std::isnan(asked.derivatives.rate(asked.scene.state, answer, velocity)));
  }
  EXPECT_EQ(allocations(), before);
}

}  // namespace proximity_server::scene::derivatives_test
