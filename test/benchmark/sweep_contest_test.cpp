// ./dev bench sweep relies on this: states along edges, peers that are asked the same as we are, and spheres that
// cover.
#include "benchmark/agreement.h"
#include "benchmark/motions.h"
#include "oracle/oracle.h"
#include "peers/fcl_scene.h"
#include "peers/robots.h"
#include "peers/sweep_library.h"
#include "proximity_server/scene/model/kinematics.h"
#include "sanitized.h"

#include <gtest/gtest.h>

#include <cmath>

namespace proximity_server::benchmark::sweep_contest_test {

using namespace narrowphase;
using namespace scene;
using namespace peers;

using Eigen::Vector3d;

constexpr int kStates = kIsSanitized ? 5 : 200;
constexpr double kFclError = 3e-2;  // [m] see scene_contest_test.cpp

const NamedRobot& demo() {
  static const NamedRobot robot = demoRobot();
  return robot;
}

const SceneQuestion kQuestions[] = {SceneQuestion::AnyBelow, SceneQuestion::Minimum, SceneQuestion::Closest,
                                    SceneQuestion::Below};

TEST(EdgePositions, StepByAtMostADegreeOfTheFastestJointAndTurnAtRandomStates) {
  const PositionTable edges = edgePositions(demo().model->robot, 2000);
  int nearly_a_degree = 0, turns = 0;
  for (Eigen::Index i = 2; i < edges.rows(); ++i) {
    const Eigen::RowVectorXd step = edges.row(i) - edges.row(i - 1), before = edges.row(i - 1) - edges.row(i - 2);
    const double fastest = step.cwiseAbs().maxCoeff();
    EXPECT_LE(fastest, M_PI / 180.0 + 1e-12);
    if (fastest > 0.99 * M_PI / 180.0) ++nearly_a_degree;
    if ((step - before).norm() > 1e-9) ++turns;
  }
  EXPECT_GT(nearly_a_degree, 1500);
  EXPECT_GT(turns, 3);
  EXPECT_LT(turns, 40);
}

/// Returns the answers of a library about the same states.
std::vector<SceneAnswer> answersOf(SweepLibrary& library, SceneQuestion question) {
  library.ask(randomPositions(demo().model->robot, kStates), question);
  return library.answers();
}

TEST(SweepScene, SaysWhatTheBatchSays) {
  SweepBatch batch(demo().model);
  SweepScene scene(demo().model, std::make_unique<OurScene>(demo().model, Skipping::On));
  for (const SceneQuestion question : kQuestions) {
    const nlohmann::json found = sweepAgreement(question, answersOf(batch, question), answersOf(scene, question));
    EXPECT_EQ(found["states"], kStates);
    for (const char* key :
         {"differing", "overlaps_missed", "overlaps_claimed", "other_pairs", "below_missed", "below_claimed"})
      EXPECT_EQ(found.value(key, 0), 0) << key << found;
  }
}

class SweepFclMethods : public testing::TestWithParam<FclScene::Method> {};

TEST_P(SweepFclMethods, SayWhatTheBatchSaysButForFclsStalls) {
  SweepBatch batch(demo().model);
  SweepScene fcl(demo().model, std::make_unique<FclScene>(*demo().model, GetParam()));
  for (const SceneQuestion question : kQuestions) {
    const nlohmann::json found = sweepAgreement(question, answersOf(batch, question), answersOf(fcl, question));
    EXPECT_LE(found.value("too_near", 0.0), kFclError) << found;
    EXPECT_LE(found.value("too_far", 0.0), kFclError) << found;
    if (!kIsSanitized && question != SceneQuestion::AnyBelow) {
      EXPECT_GT(found["compared"], kStates / 2);
    }
    EXPECT_LE(found.value("below_missed", 0), kStates / 50) << found;
    EXPECT_EQ(found.value("below_claimed", 0), 0) << found;
    EXPECT_EQ(found.value("overlaps_claimed", 0), 0) << found;
  }
}

INSTANTIATE_TEST_SUITE_P(Methods, SweepFclMethods,
                         testing::Values(FclScene::Method::Triangles, FclScene::Method::HullsLibccd,
                                         FclScene::Method::HullsIndep));

/// Returns how far [m] a point lies outside of all spheres.
double outsideOf(const std::vector<SphereScene::Sphere>& spheres, const Vector3d& point) {
  double outside = std::numeric_limits<double>::infinity();
  for (const auto& sphere : spheres) outside = std::min(outside, (point - sphere.centre).norm() - sphere.radius);
  return outside;
}

TEST(SphereScene, CoversTheCornersOfHulls) {
  const SphereScene spheres(*demo().model);
  const RobotModel& robot = demo().model->robot;
  int corners = 0;
  for (const LinkPair& pair : demo().model->pairs.pairs)
    for (const Piece* piece : piecesOfLink(robot, pair.link_a)) {
      if (piece->shape.kind() != Shape::Kind::Hull || spheres.spheresOf(pair.link_a).empty()) continue;
      for (const Vector3d& vertex : piece->shape.hull().vertices()) {
        ++corners;
        EXPECT_LE(outsideOf(spheres.spheresOf(pair.link_a), piece->body_T_piece * vertex), 1e-12);
      }
    }
  EXPECT_GT(corners, 100);
}

/// Returns the distance of all spheres of two links, from the poses of the library's own kinematics.
double distanceOfSpheres(const SphereScene& spheres, const RobotModel& robot, const BodyPoses& poses,
                         const ShapeRefPair& pair) {
  double nearest = std::numeric_limits<double>::infinity();
  const auto poseOf = [&](int link) { return *poses[robot.links[link].body]; };
  for (const auto& a : spheres.spheresOf(pair.a.link()))
    for (const auto& b : spheres.spheresOf(pair.b.link()))
      nearest = std::min(
          nearest, (poseOf(pair.a.link()) * a.centre - poseOf(pair.b.link()) * b.centre).norm() - a.radius - b.radius);
  return nearest;
}

TEST(SphereScene, FindsWhatAllPairsOfItsSpheresSay) {
  SphereScene spheres(*demo().model);
  const RobotModel& robot = demo().model->robot;
  const Candidates candidates(demo().model->pairs);
  const PositionTable states = randomPositions(robot, kStates);
  int below = 0;
  for (Eigen::Index i = 0; i < states.rows(); ++i) {
    const std::vector<double> positions = positionsOf(states, i);
    const BodyPoses poses = forwardKinematics(robot, positions);
    std::vector<double> expected;
    for (const ShapeRefPair& pair : candidates) expected.push_back(distanceOfSpheres(spheres, robot, poses, pair));
    spheres.place(positions.data(), 1);
    const PairDistance minimum = spheres.minimum();
    EXPECT_NEAR(minimum.distance, expected[minimum.pair], 1e-9);
    std::sort(expected.begin(), expected.end());
    EXPECT_NEAR(minimum.distance, expected.front(), 1e-9);
    EXPECT_NEAR(spheres.closest(kClosest).back().distance, expected[kClosest - 1], 1e-9);
    EXPECT_EQ(spheres.anyBelow(kBelow), expected.front() < kBelow);
    const auto within = std::upper_bound(expected.begin(), expected.end(), kBelow) - expected.begin();
    EXPECT_EQ(spheres.below(kBelow).size(), static_cast<std::size_t>(within));
    below += expected.front() < kBelow ? 1 : 0;
  }
  if (!kIsSanitized) {
    EXPECT_GT(below, kStates / 20);
  }
}

TEST(SweepAgreement, CountsWrongVerdictsInBothDirections) {
  const std::vector<SceneAnswer> ours{{true}, {true}, {false}, {false}}, others{{true}, {false}, {true}, {false}};
  const nlohmann::json found = sweepAgreement(SceneQuestion::AnyBelow, ours, others);
  EXPECT_EQ(found, (nlohmann::json{{"states", 4}, {"below", 2}, {"below_missed", 1}, {"below_claimed", 1}}));
}

TEST(SweepAgreement, TellsErrorsInBothDirectionsOfWhatIsApart) {
  const std::vector<SceneAnswer> ours{
      {false, {{0, 0.5}}}, {false, {{0, 0.5}}}, {false, {{0, -0.1}}}, {false, {{0, 0.2}}}},
      others{{false, {{1, 0.25}}}, {false, {{0, 1.0}}}, {false, {{0, 0.1}}}, {false, {{0, -1.0}}}};
  const nlohmann::json found = sweepAgreement(SceneQuestion::Minimum, ours, others);
  EXPECT_EQ(found["compared"], 2);
  EXPECT_EQ(found["differing"], 2);
  EXPECT_EQ(found["too_near"], 0.25);
  EXPECT_EQ(found["too_far"], 0.5);
  EXPECT_EQ(found["overlaps_missed"], 1);
  EXPECT_EQ(found["overlaps_claimed"], 1);
}

}  // namespace proximity_server::benchmark::sweep_contest_test
