#include "proximity_server/scene/query/scene.h"

#include "chance.h"
#include "narrowphase/certificate.h"
#include "narrowphase/same_bits.h"
#include "oracle/shape_pairs.h"
#include "proximity_server/scene/model/kinematics.h"
#include "sanitized.h"
#include "scene/posed_scene.h"
#include "scene/query/all_pairs.h"

#include <gtest/gtest.h>
#include <Eigen/SVD>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <stdexcept>
#include <string>

namespace proximity_server::scene::scene_test {

using namespace narrowphase;

using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kEpsilon = std::numeric_limits<double>::epsilon();
constexpr double kTolerance = Question().tolerance;

Isometry3d at(double x, double y, double z) { return Isometry3d(Eigen::Translation3d(x, y, z)); }

// --- robots by hand

struct PosedShape {
  Shape shape;
  Isometry3d pose;
};

/// A robot whose bodies float freely.
class RobotMaker {
 public:
  /// Returns the index of the link.
  int addBody() {
    model_.robot.bodies.push_back({linkCount(), -1, -1, {}, {}});
    return addLink(static_cast<int>(model_.robot.bodies.size()) - 1);
  }

  int addLink(int body) {
    const int link = linkCount();
    model_.robot.links.push_back({"link" + std::to_string(link), body, Isometry3d::Identity(), {}});
    model_.robot.bodies[body].links.push_back(link);
    return link;
  }

  /// A <collision>; `in_body` says where its shapes are when the whole link is asked about.
  void addCollision(int link, const std::vector<PosedShape>& shapes,
                    Representation representation = Representation::Exact) {
    Link& owner = model_.robot.links[link];
    const int index = static_cast<int>(model_.robot.collisions.size());
    Collision collision{"", "", link, static_cast<int>(owner.collisions.size()) + 1, representation, 0.0, {}};
    for (const PosedShape& shape : shapes) {
      collision.pieces.push_back(addPiece(shape, index));
      model_.robot.bodies[owner.body].pieces.push_back(collision.pieces.back());
    }
    owner.collisions.push_back(index);
    model_.robot.collisions.push_back(collision);
  }

  int addBodyOf(const Shape& shape) {
    const int link = addBody();
    addCollision(link, {{shape, Isometry3d::Identity()}});
    return link;
  }

  int addPiece(const PosedShape& shape, int collision) {
    model_.robot.pieces.push_back({shape.shape, shape.pose, collision});
    return static_cast<int>(model_.robot.pieces.size()) - 1;
  }

  void pad(int link_a, int link_b, double padding) {
    model_.pairs.pairs.push_back({link_a, link_b, PairReason::Checked, "", padding});
  }

  RobotModel& robot() { return model_.robot; }

  std::shared_ptr<const SceneModel> finish() const {
    auto model = std::make_shared<SceneModel>(model_);
    auto& pairs = model->pairs.pairs;
    std::sort(pairs.begin(), pairs.end(), [](const LinkPair& a, const LinkPair& b) {
      return std::make_pair(a.link_a, a.link_b) < std::make_pair(b.link_a, b.link_b);
    });
    for (std::size_t i = 0; i < pairs.size(); ++i) model->pairs.checked.push_back(static_cast<int>(i));
    return model;
  }

  std::shared_ptr<const SceneModel> withAllPairs() {
    for (int a = 0; a < linkCount(); ++a)
      for (int b = a + 1; b < linkCount(); ++b)
        if (model_.robot.links[a].body != model_.robot.links[b].body) pad(a, b, 0.0);
    return finish();
  }

 private:
  int linkCount() const { return static_cast<int>(model_.robot.links.size()); }

  SceneModel model_;
};

PosedScene sceneOf(const Shape& a, const Shape& b, double padding = 0.0) {
  RobotMaker maker;
  const int link_a = maker.addBodyOf(a), link_b = maker.addBodyOf(b);
  maker.pad(link_a, link_b, padding);
  return PosedScene(maker.finish());
}

const ShapeRefPair kFirstTwo{{0, 0}, {1, 0}};

// --- what a result looks like

/// point_b = point_a + distance * normal, |normal| = 1; the points are at most `reach` from the frame's origin.
void expectIdentity(const SignedDistance& result, double reach) {
  EXPECT_NEAR(result.normal.norm(), 1.0, 4.0 * kEpsilon);
  EXPECT_LE((result.point_a + result.distance * result.normal - result.point_b).norm(), 4.0 * kEpsilon * reach);
}

bool sameNumbers(const SignedDistance& a, const SignedDistance& b) {
  return a.status == b.status && areSameBits(a.distance, b.distance) && areSameBits(a.lower_bound, b.lower_bound) &&
         areSameBits(a.upper_bound, b.upper_bound) && areSameBits(a.normal, b.normal) && a.iterations == b.iterations;
}

// --- geometry on paper

// Centres (1, 2, 3) and (1, 2, 3) + 5 * (0, 0.6, 0.8), radii 1 and 2: the gap is 2.
TEST(Scene, DistanceOfTwoSpheresIsThatOnPaperInTheFrameOfThePoses) {
  PosedScene scene = sceneOf(Sphere{1.0}, Sphere{2.0});
  Isometry3d turned = at(1, 5, 7);
  turned.rotate(Eigen::AngleAxisd(1.0, Vector3d::UnitX()));
  scene.update({at(1, 2, 3), turned});
  const SignedDistance result = scene.proximity(kFirstTwo).result;
  EXPECT_EQ(result.status, Status::Converged);
  EXPECT_NEAR(result.distance, 2.0, 1e-14);
  EXPECT_LE((result.normal - Vector3d(0, 0.6, 0.8)).norm(), 1e-15);
  EXPECT_LE((result.point_a - Vector3d(1, 2.6, 3.8)).norm(), 1e-14);
  EXPECT_LE((result.point_b - Vector3d(1, 3.8, 5.4)).norm(), 1e-14);
  expectIdentity(result, 8.0);
}

// Two bars of two boxes each, 0.2 thick: a's at x = 0 and 1, b's at x = 1.5 and 2.5. The nearest are the second of a
// and the first of b: 0.5 - 0.2.
TEST(Scene, DistanceOfLinksIsThatOfTheirClosestPieces) {
  const Shape box = Box{{0.2, 0.2, 0.2}};
  RobotMaker maker;
  for (int link = 0; link < 2; ++link) {
    maker.addBody();
    maker.addCollision(link, {{box, at(0, 0, 0)}});
    maker.addCollision(link, {{box, at(1, 0, 0)}});
  }
  PosedScene scene(maker.finish());
  scene.update({at(0, 0, 0), at(1.5, 0, 0)});
  const PairProximity found = scene.proximity(kFirstTwo);
  EXPECT_NEAR(found.result.distance, 0.3, kTolerance);
  EXPECT_EQ(found.collision_a, 2);
  EXPECT_EQ(found.collision_b, 1);
}

// Spheres of radius 1 at x = 0 and y = 3 against one of radius 1 at (0, 1.2, 0): depths 0.8 and 0.2.
TEST(Scene, DepthOfLinksIsThatOfTheirDeepestPieces) {
  RobotMaker maker;
  maker.addBody();
  maker.addCollision(0, {{Sphere{1.0}, at(0, 3, 0)}});
  maker.addCollision(0, {{Sphere{1.0}, at(0, 0, 0)}});
  maker.addBodyOf(Sphere{1.0});
  PosedScene scene(maker.finish());
  scene.update({at(0, 0, 0), at(0, 1.2, 0)});
  const PairProximity found = scene.proximity(kFirstTwo);
  EXPECT_NEAR(found.result.distance, -0.8, kTolerance);
  EXPECT_EQ(found.collision_a, 2);
}

TEST(Scene, OneCollisionIsMeasuredWithoutTheOthersOfItsLink) {
  RobotMaker maker;
  maker.addBody();
  maker.addCollision(0, {{Sphere{0.5}, at(0, 0, 0)}});
  maker.addCollision(0, {{Sphere{0.5}, at(-4, 0, 0)}});
  maker.addBodyOf(Sphere{0.5});
  PosedScene scene(maker.finish());
  scene.update({at(0, 0, 0), at(2, 0, 0)});
  const PairProximity found = scene.proximity({{0, 2}, {1, 0}});
  EXPECT_NEAR(found.result.distance, 5.0, kTolerance);
  EXPECT_EQ(found.collision_a, 2);
  EXPECT_EQ(found.asked.a.collision(), 2);
}

// A body that holds a capsule instead of the cylinder and the two spheres that it is made of.
TEST(Scene, WholeLinkIsMeasuredByThePiecesOfItsBody) {
  RobotMaker maker;
  maker.addBody();
  maker.addCollision(0, {{Cylinder{0.5, 2.0}, at(0, 0, 0)}});
  maker.addCollision(0, {{Sphere{0.5}, at(0, 0, 1)}});
  maker.addCollision(0, {{Sphere{0.5}, at(0, 0, -1)}});
  maker.robot().bodies[0].pieces = {maker.addPiece({Capsule{0.5, 2.0}, at(0, 0, 0)}, 0)};
  maker.addBodyOf(Sphere{0.5});
  PosedScene scene(maker.finish());
  scene.update({at(0, 0, 0), at(0, 0, 3)});
  EXPECT_NEAR(scene.proximity(kFirstTwo).result.distance, 1.0, kTolerance);
  EXPECT_EQ(scene.proximity(kFirstTwo).collision_a, 1);
  EXPECT_NEAR(scene.proximity({{0, 1}, {1, 0}}).result.distance, 1.5, kTolerance);
  EXPECT_NEAR(scene.proximity({{0, 3}, {1, 0}}).result.distance, 3.0, kTolerance);
}

TEST(Scene, ShapesOfOneBodyKeepTheirDistance) {
  RobotMaker maker;
  maker.addBody();
  maker.addLink(0);
  maker.addCollision(0, {{Box{{1, 1, 1}}, at(0, 0, 0)}});
  maker.addCollision(1, {{Box{{1, 1, 1}}, at(2.5, 0.3, 0)}});
  PosedScene scene(maker.finish());
  Chance random(1);
  for (int i = 0; i < 100; ++i) {
    scene.update({randomPose(random, 10.0)});
    EXPECT_NEAR(scene.proximity(kFirstTwo).result.distance, 1.5, kTolerance);
  }
}

TEST(Scene, RepresentationIsTheLessExactOfTheTwo) {
  RobotMaker maker;
  maker.addBodyOf(Sphere{1.0});
  maker.addBody();
  maker.addCollision(1, {{Sphere{1.0}, at(9, 0, 0)}});
  maker.addCollision(1, {{Sphere{1.0}, at(0, 0, 0)}}, Representation::ConvexHull);
  PosedScene scene(maker.finish());
  scene.update({at(0, 0, 0), at(5, 0, 0)});
  EXPECT_EQ(scene.proximity(kFirstTwo).representation, Representation::ConvexHull);
  EXPECT_EQ(scene.proximity({{0, 0}, {1, 1}}).representation, Representation::Exact);
}

TEST(Scene, CandidatesAreTheCheckedPairsOfTheFilter) {
  RobotMaker maker;
  for (int i = 0; i < 3; ++i) maker.addBodyOf(Sphere{1.0});
  SceneModel model = *maker.withAllPairs();
  model.pairs.checked = {0, 2};
  const PosedScene scene(std::make_shared<SceneModel>(model));
  ASSERT_EQ(scene.candidates().size(), 2u);
  EXPECT_EQ(scene.candidates()[0].b.link(), 1);
  EXPECT_EQ(scene.candidates()[1].a.link(), 1);
  EXPECT_EQ(scene.candidates()[1].b.link(), 2);
  EXPECT_EQ(scene.candidates()[1].b.collision(), 0);
}

// --- what is not known is never far

TEST(Scene, AMissingPoseMakesItsPairsUnknownAndCounted) {
  RobotMaker maker;
  for (int i = 0; i < 3; ++i) maker.addBodyOf(Sphere{1.0});
  PosedScene scene(maker.withAllPairs());
  scene.update({at(0, 0, 0), at(3, 0, 0), std::nullopt});

  const std::vector<PairProximity> all = scene.all(scene.candidates());
  ASSERT_EQ(all.size(), 3u);
  EXPECT_EQ(all[0].result.status, Status::Converged);
  for (const int unknown : {1, 2}) {
    EXPECT_EQ(all[unknown].result.status, Status::Unknown);
    EXPECT_TRUE(std::isnan(all[unknown].result.distance));
    EXPECT_EQ(all[unknown].asked.b.link(), 2);
  }
  EXPECT_EQ(scene.counts().unknown, 2);

  const PairProximity* minimum = scene.minimum(scene.candidates());
  ASSERT_TRUE(minimum);
  EXPECT_EQ(minimum->asked.b.link(), 1);
  EXPECT_EQ(scene.counts().unknown, 2);
  EXPECT_EQ(scene.counts().total, 3);
}

TEST(Scene, EveryPairIsUnknownBeforeTheFirstPoses) {
  PosedScene scene = sceneOf(Sphere{1.0}, Sphere{1.0});
  EXPECT_EQ(scene.proximity(kFirstTwo).result.status, Status::Unknown);
  EXPECT_EQ(scene.minimum(scene.candidates()), nullptr);
  EXPECT_EQ(scene.counts().unknown, 1);
}

TEST(Scene, LinkWithoutGeometryIsUnknown) {
  RobotMaker maker;
  maker.addBodyOf(Sphere{1.0});
  maker.addBody();
  PosedScene scene(maker.finish());
  scene.update({at(0, 0, 0), at(5, 0, 0)});
  EXPECT_EQ(scene.proximity(kFirstTwo).result.status, Status::Unknown);
  EXPECT_EQ(scene.counts().unknown, 1);
}

// Regression: such a pair was left out of the answer, and counted as computed.
TEST(Scene, PairThatIsTooFarToComputeIsUnknown) {
  RobotMaker maker;
  maker.addBodyOf(Sphere{1.0});
  maker.addBodyOf(Sphere{1.0});
  PosedScene scene(maker.withAllPairs());
  for (const double far : {1e31, 1e160}) {
    scene.update({at(0, 0, 0), at(far, 0, 0)});
    EXPECT_EQ(scene.all(scene.candidates()).at(0).result.status, Status::Unknown) << far;
    EXPECT_EQ(scene.counts().unknown, 1) << far;
    EXPECT_EQ(scene.minimum(scene.candidates()), nullptr) << far;
    EXPECT_EQ(scene.counts().unknown, 1) << far;
    EXPECT_EQ(scene.counts().computed, 0) << far;
  }
}

TEST(Scene, RefusesShapesThatDoNotExist) {
  PosedScene scene = sceneOf(Sphere{1.0}, Sphere{1.0});
  scene.update({at(0, 0, 0), at(5, 0, 0)});
  EXPECT_THROW(scene.proximity({{0, 0}, {2, 0}}), std::invalid_argument);
  EXPECT_THROW(scene.proximity({{-1, 0}, {1, 0}}), std::invalid_argument);
  EXPECT_THROW(scene.minimum(std::vector<ShapeRefPair>{{{0, 2}, {1, 0}}}), std::invalid_argument);
  EXPECT_THROW(scene.minimum(Candidates(PairTable())), std::invalid_argument);  // those of another robot
  EXPECT_NEAR(scene.proximity(kFirstTwo).result.distance, 3.0, kTolerance);
}

TEST(Scene, RefusesPosesOfAnotherNumberOfBodies) {
  PosedScene scene = sceneOf(Sphere{1.0}, Sphere{1.0});
  EXPECT_THROW(scene.update({at(0, 0, 0)}), std::invalid_argument);
}

/// U V^T of the singular value decomposition.
Matrix3d nearestRotation(const Matrix3d& matrix) {
  const Eigen::JacobiSVD<Matrix3d> svd(matrix, Eigen::ComputeFullU | Eigen::ComputeFullV);
  return svd.matrixU() * svd.matrixV().transpose();
}

Isometry3d inSinglePrecision(Isometry3d pose) {
  pose.linear() = pose.linear().cast<float>().cast<double>();
  return pose;
}

TEST(Scene, MatrixInSinglePrecisionIsTakenForItsNearestRotation) {
  PosedScene scene = sceneOf(Box{{0.9, 0.7, 0.5}}, Box{{0.4, 0.8, 1.0}});
  Chance random(2);
  double largest_difference = 0.0;
  for (int i = 0; i < 200; ++i) {
    Isometry3d a = inSinglePrecision(randomPose(random, 0.1)), b = inSinglePrecision(randomPose(random, 2.0));
    scene.update({a, b});
    const SignedDistance rounded = scene.proximity(kFirstTwo).result;
    const Matrix3d off = a.linear();
    a.linear() = nearestRotation(a.linear());
    b.linear() = nearestRotation(b.linear());
    largest_difference = std::max(largest_difference, (a.linear() - off).norm());
    scene.update({a, b});
    const SignedDistance exact = scene.proximity(kFirstTwo).result;
    EXPECT_EQ(rounded.status, Status::Converged);
    EXPECT_LE(rounded.lower_bound, exact.upper_bound);
    EXPECT_GE(rounded.upper_bound, exact.lower_bound);
    expectIdentity(rounded, 4.0);
  }
  EXPECT_GT(largest_difference, 1e-8);
}

// --- padding of a pair

// Radii 1 and 1, centres 3 apart along y, padding 0.4: distance 0.6, each surface 0.2 farther out.
// Regression: the first bounds of the pair were the answer, Converged.
TEST(Scene, ToleranceThatIsNotANumberCountsAsZero) {
  RobotMaker maker;
  const int a = maker.addBodyOf(Ellipsoid{{0.3, 0.2, 0.1}}), b = maker.addBodyOf(Cylinder{0.2, 0.5});
  PosedScene scene(maker.withAllPairs());
  BodyPoses poses(2, Isometry3d::Identity());
  poses[1] = at(0.6, 0.3, 0.2);
  scene.update(poses);
  Question question;
  question.tolerance = kNaN;
  const PairProximity nan = scene.proximity({{a}, {b}}, question), fine = scene.proximity({{a}, {b}});
  EXPECT_NE(nan.result.status, Status::Converged);
  EXPECT_NEAR(nan.result.lower_bound, fine.result.lower_bound, 1e-9);
  EXPECT_NEAR(nan.result.upper_bound, fine.result.upper_bound, 1e-9);
}

TEST(Scene, PairPaddingMovesBothSurfacesByHalf) {
  PosedScene scene = sceneOf(Sphere{1.0}, Sphere{1.0}, 0.4);
  scene.update({at(0, 0, 0), at(0, 3, 0)});
  const SignedDistance result = scene.proximity(kFirstTwo).result;
  EXPECT_NEAR(result.distance, 0.6, 1e-14);
  EXPECT_LE((result.point_a - Vector3d(0, 1.2, 0)).norm(), 1e-14);
  EXPECT_LE((result.point_b - Vector3d(0, 1.8, 0)).norm(), 1e-14);
  EXPECT_LE(result.lower_bound, 0.6 + 1e-14);
  EXPECT_GE(result.upper_bound, 0.6 - 1e-14);
  EXPECT_LE(result.upper_bound - result.lower_bound, kTolerance);
}

TEST(Scene, PairPaddingCountsInEitherOrderAndForSingleCollisions) {
  PosedScene scene = sceneOf(Sphere{1.0}, Sphere{1.0}, 0.4);
  scene.update({at(0, 0, 0), at(0, 3, 0)});
  EXPECT_NEAR(scene.proximity({{1, 0}, {0, 0}}).result.distance, 0.6, 1e-14);
  EXPECT_NEAR(scene.proximity({{0, 1}, {1, 1}}).result.distance, 0.6, 1e-14);
}

TEST(Scene, ThresholdIsComparedWithThePaddedDistance) {
  PosedScene scene = sceneOf(Box{{1, 1, 1}}, Box{{1, 1, 1}}, 0.4);
  scene.update({at(0, 0, 0), at(2, 0, 0)});
  Question question;
  question.threshold = 0.61;
  EXPECT_EQ(scene.below(scene.candidates(), question).size(), 1u);
  EXPECT_NEAR(scene.below(scene.candidates(), question).front().result.distance, 0.6, kTolerance);
  question.threshold = 0.59;
  EXPECT_EQ(scene.below(scene.candidates(), question).size(), 0u);
}

/// Shapes with half of the padding as their margin have the padded distance.
TEST(Scene, PairPaddingIsTheMarginOfBothShapes) {
  const std::vector<NamedShape> shapes = solidShapes();
  Chance random(3);
  int overlaps = 0, total = 0;
  for (const NamedShape& a : shapes)
    for (const NamedShape& b : shapes) {
      PosedScene padded_pair = sceneOf(a.shape, b.shape, 0.1),
                 padded_shapes = sceneOf(a.shape.padded(0.05), b.shape.padded(0.05));
      for (int i = 0; i < 20; ++i) {
        const BodyPoses poses{randomPose(random, 0.9), randomPose(random, 0.9)};
        padded_pair.update(poses);
        padded_shapes.update(poses);
        const SignedDistance pair = padded_pair.proximity(kFirstTwo).result;
        EXPECT_NEAR(pair.distance, padded_shapes.proximity(kFirstTwo).result.distance, 2.0 * kTolerance);
        overlaps += pair.distance < 0.0;
        ++total;
      }
    }
  EXPECT_GT(overlaps, total / 4);
  EXPECT_LT(overlaps, 3 * total / 4);
}

// --- thresholds

TEST(Scene, BeyondTheThresholdOnlyTheProofIsLeft) {
  PosedScene scene = sceneOf(Box{{1, 1, 1}}, Cylinder{0.5, 1.0});
  for (const double x : {1.2, 1.5, 40.0}) {
    scene.update({at(0, 0, 0), at(x, 0, 0)});
    Question question;
    question.threshold = 0.15;
    const SignedDistance result = scene.proximity(kFirstTwo, question).result;
    EXPECT_EQ(result.status, Status::Threshold);
    EXPECT_GT(result.lower_bound, 0.15);
    EXPECT_LE(result.lower_bound, x - 1.0);
    EXPECT_EQ(result.distance, result.lower_bound);
    EXPECT_FALSE(result.has_points);
    EXPECT_TRUE(result.point_a.hasNaN() && result.point_b.hasNaN());
  }
}

// Boxes 1 m apart, thresholds within rounding of that: the status may be either, but has to be what the bounds say.
TEST(Scene, ThresholdWithinRoundingOfTheDistanceIsDecidedByTheBounds) {
  PosedScene scene = sceneOf(Box{{1, 1, 1}}, Box{{1, 1, 1}});
  scene.update({at(0, 0, 0), at(2, 0.3, 0.2)});
  int beyond = 0, near = 0;
  for (int ulps = -1000; ulps <= 1000; ulps += 10) {
    Question question;
    question.threshold = 1.0 + ulps * kEpsilon;
    const SignedDistance result = scene.proximity(kFirstTwo, question).result;
    const bool is_beyond = result.lower_bound > question.threshold;
    EXPECT_EQ(result.status, is_beyond ? Status::Threshold : Status::Converged) << ulps;
    (is_beyond ? beyond : near) += 1;
  }
  EXPECT_GT(beyond, 20);
  EXPECT_GT(near, 100);
}

TEST(Scene, OverlapWithoutDepthIsReportedAsSuch) {
  PosedScene scene = sceneOf(Box{{1, 1, 1}}, Cylinder{0.5, 1.0});
  scene.update({at(0, 0, 0), at(0.4, 0.1, 0)});
  Question question;
  question.depth = Question::Depth::NotWanted;
  const SignedDistance result = scene.proximity(kFirstTwo, question).result;
  EXPECT_EQ(result.status, Status::Threshold);
  EXPECT_LE(result.upper_bound, 0.0);
}

// --- order

// Six spheres around one, all at the same distance to the last bit.
TEST(Scene, EqualDistancesComeInTheOrderOfThePairs) {
  RobotMaker maker;
  for (int i = 0; i < 7; ++i) maker.addBodyOf(Sphere{0.25});
  PosedScene scene(maker.finish());
  scene.update({at(0, 0, 0), at(1, 0, 0), at(-1, 0, 0), at(0, 1, 0), at(0, -1, 0), at(0, 0, 1), at(0, 0, -1)});
  std::vector<ShapeRefPair> pairs;
  for (const int other : {4, 2, 6, 1, 5, 3}) pairs.push_back({{0, 0}, {other, 0}});
  EXPECT_EQ(scene.minimum(pairs)->asked.b.link(), 4);
  const std::vector<PairProximity> three = scene.closest(pairs, 3);
  ASSERT_EQ(three.size(), 3u);
  EXPECT_EQ(three[0].asked.b.link(), 4);
  EXPECT_EQ(three[1].asked.b.link(), 2);
  EXPECT_EQ(three[2].asked.b.link(), 6);
  EXPECT_EQ(scene.closest(pairs, 9).size(), 6u);
  EXPECT_TRUE(scene.closest(pairs, 0).empty());
}

TEST(Scene, NoPairsHaveNoMinimum) {
  PosedScene scene = sceneOf(Sphere{1.0}, Sphere{1.0});
  scene.update({at(0, 0, 0), at(5, 0, 0)});
  EXPECT_EQ(scene.minimum(std::vector<ShapeRefPair>{}), nullptr);
  EXPECT_EQ(scene.counts().total, 0);
}

// --- random scenes

/// Links of every kind of shape, some of several pieces and some on one body.
std::shared_ptr<const SceneModel> randomRobot(unsigned seed) {
  Chance random(seed);
  std::uniform_int_distribution<int> pieces(1, 4);
  const std::vector<NamedShape> shapes = allShapes();
  std::uniform_int_distribution<std::size_t> shape(0, shapes.size() - 1);
  RobotMaker maker;
  for (int body = 0; body < 9; ++body) {
    const int link = maker.addBody();
    for (int collision = 0; collision < pieces(random) - 1; ++collision)
      maker.addCollision(link, {{shapes[shape(random)].shape, randomPose(random, 1.0)},
                                {shapes[shape(random)].shape, randomPose(random, 1.0)}});
    maker.addCollision(link, {{shapes[shape(random)].shape, randomPose(random, 1.0)}});
    if (body % 3 == 0) maker.addCollision(maker.addLink(body), {{shapes[shape(random)].shape, at(0, 0, 1)}});
  }
  maker.pad(0, 5, 0.2);
  maker.pad(3, 4, -0.1);
  SceneModel model = *maker.finish();
  for (LinkPair& pair : model.pairs.pairs) pair.reason = PairReason::Adjacent;
  model.pairs.checked.clear();
  return std::make_shared<SceneModel>(model);
}

/// All pairs of links, of one body too, and some single <collision>s.
std::vector<ShapeRefPair> manyPairs(const RobotModel& robot) {
  std::vector<ShapeRefPair> pairs;
  const int links = static_cast<int>(robot.links.size());
  for (int a = 0; a < links; ++a)
    for (int b = a + 1; b < links; ++b)
      pairs.push_back((a + b) % 2 ? ShapeRefPair{{a, 0}, {b, 0}} : ShapeRefPair{{b, 0}, {a, 0}});
  for (int a = 1; a < links; ++a) pairs.push_back({{0, 1}, {a, 1}});
  return pairs;
}

BodyPoses randomPoses(Chance& random, std::size_t bodies, double reach) {
  BodyPoses poses;
  for (std::size_t i = 0; i < bodies; ++i) poses.push_back(randomPose(random, reach));
  return poses;
}

class RandomScene : public testing::TestWithParam<unsigned> {
 protected:
  static constexpr int kStates = kIsSanitized ? 100 : 400;

  BodyPoses nextPoses() { return randomPoses(random_, model_->robot.bodies.size(), spread_(random_)); }

  const std::shared_ptr<const SceneModel> model_ = randomRobot(GetParam());
  const std::vector<ShapeRefPair> pairs_ = manyPairs(model_->robot);
  Chance random_{GetParam()};
  std::uniform_real_distribution<double> spread_{1.0, 12.0};
};

/// Each of two searches that converged may be off by the tolerance.
constexpr double kAgreement = 2.0 * kTolerance;

void expectCountsAddUp(const PairCounts& counts, std::size_t total) {
  EXPECT_EQ(counts.total, static_cast<int>(total));
  EXPECT_EQ(counts.total, counts.unknown + counts.at_rest + counts.by_motion + counts.by_bounds + counts.computed);
}

TEST_P(RandomScene, SkippingNeverChangesAnAnswer) {
  PosedScene scene(model_), reference(model_, Skipping::Off);
  long skipped = 0, overlapping = 0;
  for (int state = 0; state < kStates; ++state) {
    const BodyPoses poses = nextPoses();
    scene.update(poses);
    reference.update(poses);
    const AllPairs brute_force(reference.all(pairs_), kAgreement);
    EXPECT_EQ(reference.counts().computed, static_cast<int>(pairs_.size()));
    overlapping += static_cast<long>(brute_force.countBelow(0.0));

    const PairProximity* minimum = scene.minimum(pairs_);
    ASSERT_TRUE(minimum);
    brute_force.expectClosest({*minimum});
    expectCountsAddUp(scene.counts(), pairs_.size());
    skipped += scene.counts().by_bounds;

    const std::vector<PairProximity>& closest = scene.closest(pairs_, 7);
    ASSERT_EQ(closest.size(), 7u);
    brute_force.expectClosest(closest);
    expectCountsAddUp(scene.counts(), pairs_.size());
  }
  const long asked = static_cast<long>(pairs_.size()) * kStates;
  EXPECT_GT(skipped, asked / 2);
  EXPECT_GT(overlapping, asked / 50);
  EXPECT_LT(overlapping, asked / 2);
}

TEST_P(RandomScene, ThresholdsDivideThePairsAsBruteForceDoes) {
  PosedScene scene(model_), reference(model_, Skipping::Off);
  std::uniform_real_distribution<double> threshold(-0.3, 2.0);
  long near = 0, far = 0;
  for (int state = 0; state < kStates; ++state) {
    const BodyPoses poses = nextPoses();
    scene.update(poses);
    reference.update(poses);
    const AllPairs brute_force(reference.all(pairs_), kAgreement);
    Question question;
    question.threshold = threshold(random_);
    const std::size_t surely = brute_force.countBelow(question.threshold - kAgreement);
    const std::size_t perhaps = brute_force.countBelow(question.threshold + kAgreement);

    const std::vector<PairProximity> below = scene.below(pairs_, question);
    brute_force.expectCount(below.size(), question.threshold);
    brute_force.expectClosest(below);
    expectCountsAddUp(scene.counts(), pairs_.size());

    const PairsBelow some = scene.closestBelow(pairs_, 3, question);
    brute_force.expectCount(some.count, question.threshold);
    EXPECT_EQ(some.closest.size(), std::min<std::size_t>(3, some.count));
    brute_force.expectClosest(some.closest);
    expectCountsAddUp(scene.counts(), pairs_.size());

    const PairProximity* first = scene.first(pairs_, question);
    EXPECT_TRUE(first ? perhaps > 0 : surely == 0);
    if (first) {
      EXPECT_LE(brute_force.of(first->asked), question.threshold + kAgreement);
    }
    expectCountsAddUp(scene.counts(), pairs_.size());

    const PairProximity* minimum = scene.minimum(pairs_, question);
    EXPECT_TRUE(minimum ? perhaps > 0 : surely == 0);
    if (minimum) brute_force.expectClosest({*minimum});

    for (const PairProximity& pair : scene.all(pairs_, question)) {
      const double distance = brute_force.of(pair.asked);
      EXPECT_LE(pair.result.lower_bound, distance + kTolerance);
      const bool is_far = pair.result.status == Status::Threshold;
      (is_far ? far : near) += 1;
      if (is_far) {
        EXPECT_GT(pair.result.lower_bound, question.threshold);
        EXPECT_GT(distance, question.threshold - kAgreement);
      } else {
        EXPECT_NEAR(pair.result.distance, distance, kAgreement);
        EXPECT_LE(distance, question.threshold + kAgreement);
      }
    }
    expectCountsAddUp(scene.counts(), pairs_.size());
  }
  EXPECT_GT(near, 1000);
  EXPECT_GT(far, 1000);
}

TEST_P(RandomScene, StatusFitsTheBoundsAtLooseTolerances) {
  PosedScene scene(model_), reference(model_, Skipping::Off);
  std::uniform_real_distribution<double> threshold(-0.3, 2.0);
  Question question;
  question.tolerance = 0.05;
  int within_tolerance = 0;
  for (int state = 0; state < kStates; ++state) {
    const BodyPoses poses = nextPoses();
    scene.update(poses);
    reference.update(poses);
    const AllPairs brute_force(reference.all(pairs_), kAgreement);
    question.threshold = threshold(random_);
    for (const PairProximity& pair : scene.all(pairs_, question)) {
      const SignedDistance& result = pair.result;
      const double distance = brute_force.of(pair.asked);
      EXPECT_EQ(result.status, result.lower_bound > question.threshold ? Status::Threshold : Status::Converged);
      EXPECT_LE(result.lower_bound, distance + kTolerance);
      EXPECT_GE(result.upper_bound, distance - kTolerance);
      if (result.status == Status::Converged) {
        EXPECT_LE(result.upper_bound - result.lower_bound, question.tolerance);
      }
      within_tolerance += std::abs(distance - question.threshold) < question.tolerance;
    }
  }
  EXPECT_GT(within_tolerance, 100);
}

TEST_P(RandomScene, WithoutDepthAnyOverlapIsTheMinimum) {
  PosedScene scene(model_), reference(model_, Skipping::Off);
  Question question;
  question.depth = Question::Depth::NotWanted;
  int overlaps = 0;
  for (int state = 0; state < kStates; ++state) {
    const BodyPoses poses = nextPoses();
    scene.update(poses);
    reference.update(poses);
    const AllPairs brute_force(reference.all(pairs_), kAgreement);
    const PairProximity* minimum = scene.minimum(pairs_, question);
    ASSERT_TRUE(minimum);
    if (brute_force.smallest(0) > kAgreement) {
      EXPECT_NEAR(minimum->result.distance, brute_force.smallest(0), kAgreement);
    } else {
      ++overlaps;
      EXPECT_LE(brute_force.of(minimum->asked), kAgreement);
      EXPECT_LE(minimum->result.upper_bound, kAgreement);
      EXPECT_LE(minimum->result.lower_bound, brute_force.of(minimum->asked) + kTolerance);
    }
    const std::size_t found = scene.below(pairs_, {kTolerance, 0.5, Question::Depth::NotWanted}).size();
    brute_force.expectCount(found, 0.5);
  }
  EXPECT_GT(overlaps, 10);
}

// Regression: without depth, every overlap was below the negative threshold of its pair.
TEST_P(RandomScene, WithoutDepthPairsBelowTheirOwnThresholdsAreFound) {
  PosedScene scene(model_), reference(model_, Skipping::Off);
  std::uniform_real_distribution<double> own(-0.5, 0.1);
  PairDistances thresholds(-0.1, 0.0);
  for (const ShapeRefPair& pair : pairs_)
    if (pair.a.link() != pair.b.link()) thresholds.setPair(pair.a.link(), pair.b.link(), own(random_));
  Question question;
  question.depth = Question::Depth::NotWanted;
  question.threshold = 0.0;
  question.thresholds = &thresholds;
  std::size_t below = 0, overlapping = 0;
  for (int state = 0; state < kStates / 4; ++state) {
    const BodyPoses poses = nextPoses();
    scene.update(poses);
    reference.update(poses);
    const std::vector<PairProximity> all = reference.all(pairs_);
    const AllPairs brute_force(all, kAgreement, thresholds);
    brute_force.expectCount(scene.below(pairs_, question).size(), 0.0);
    brute_force.expectCount(reference.below(pairs_, question).size(), 0.0);
    EXPECT_LE(scene.first(pairs_, question) != nullptr, brute_force.countBelow(kAgreement) > 0);
    EXPECT_GE(scene.first(pairs_, question) != nullptr, brute_force.countBelow(-kAgreement) > 0);
    below += brute_force.countBelow(0.0);
    overlapping += AllPairs(all, kAgreement).countBelow(0.0);
  }
  EXPECT_GT(below, kStates / 4u);
  EXPECT_GT(overlapping, below + kStates / 4u);
}

// --- far from the origin

/// Coordinates that are multiples of 2^-20 m, so that a shift by 2^20 m is exact in 53 bits.
BodyPoses onGrid(BodyPoses poses) {
  for (auto& pose : poses)
    for (int i = 0; i < 3; ++i) {
      double& x = pose->translation()[i];
      x = std::ldexp(std::round(std::ldexp(x, 20)), -20);
    }
  return poses;
}

BodyPoses shifted(BodyPoses poses, const Vector3d& shift) {
  for (auto& pose : poses) pose->pretranslate(shift);
  return poses;
}

TEST_P(RandomScene, AShiftThatDoublesCanHoldChangesNoBit) {
  const double million = std::ldexp(1.0, 20);
  PosedScene near(model_), far(model_);
  for (int state = 0; state < 20; ++state) {
    const BodyPoses poses = onGrid(nextPoses());
    near.update(poses);
    far.update(shifted(poses, {million, -million, million}));
    const std::vector<PairProximity>&here = near.all(pairs_), &there = far.all(pairs_);
    for (std::size_t i = 0; i < pairs_.size(); ++i) EXPECT_TRUE(sameNumbers(here[i].result, there[i].result));
    Question question;
    question.threshold = 0.1;
    near.all(pairs_, question);
    far.all(pairs_, question);
    for (std::size_t i = 0; i < pairs_.size(); ++i) EXPECT_TRUE(sameNumbers(here[i].result, there[i].result));
  }
}

INSTANTIATE_TEST_SUITE_P(Scene, RandomScene, testing::Range(1u, 1u + static_cast<unsigned>(repeats(6))));

}  // namespace proximity_server::scene::scene_test
