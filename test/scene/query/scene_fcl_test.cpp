// Panda, UR5 and PR2 of example-robot-data, where they can be found, against FCL.
//
// The reference is the distance of triangle meshes, one mesh for each link: it walks a tree of boxes down to pairs of
// triangles, and so shares nothing with GJK, EPA, warm starts or our bounds. FCL's own GJK would be no judge: it stalls
// on one hull query in two hundred, with errors up to 0.2 m.
#include "proximity_server/scene/loading/joined_robots.h"
#include "proximity_server/scene/loading/load_robot_model.h"
#include "proximity_server/scene/model/kinematics.h"
#include "proximity_server/scene/query/scene.h"
#include "sanitized.h"
#include "scene/example_robots.h"

#include <fcl/geometry/bvh/BVH_model.h>
#include <fcl/math/bv/OBBRSS.h>
#include <fcl/narrowphase/distance.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <map>
#include <random>
#include <string>

namespace proximity_server::scene::scene_fcl_test {

using namespace narrowphase;

using Eigen::Isometry3d;
using Eigen::Vector3d;
using FclMesh = fcl::BVHModel<fcl::OBBRSSd>;

const int kStates = repeats(60);
constexpr double kAgreement = 1e-6;  // [m]
constexpr double kHulls = 1.0;       // [m] a mesh tolerance in which every mesh is its hull

// --- robots

double randomPosition(const Joint& joint, std::mt19937& random) {
  const double full_turn = std::acos(-1.0);
  const double lower = std::isfinite(joint.lower) ? joint.lower : -full_turn;
  const double upper = std::isfinite(joint.upper) ? joint.upper : full_turn;
  return std::uniform_real_distribution<double>(lower, upper)(random);
}

BodyPoses randomState(const RobotModel& robot, std::mt19937& random) {
  std::map<std::string, double> positions;
  for (const Joint& joint : robot.joints) positions[joint.name] = randomPosition(joint, random);
  return forwardKinematics(robot, positions);
}

// --- the same solids as triangles

/// A box as the hull of its corners.
ConvexHull polytope(const Shape& shape) {
  if (shape.kind() == Shape::Kind::Hull) return shape.hull();
  EXPECT_EQ(shape.kind(), Shape::Kind::Box) << "these robots have boxes and meshes only";
  std::vector<Vector3d> corners;
  for (const double x : {-1.0, 1.0})
    for (const double y : {-1.0, 1.0})
      for (const double z : {-1.0, 1.0}) corners.push_back(shape.halfExtents().cwiseProduct(Vector3d(x, y, z)));
  return ConvexHull(corners);
}

struct Solid {
  ConvexHull hull;
  Isometry3d body_T_hull;

  /// Whether a point, in the body's frame, lies inside.
  bool holds(const Vector3d& point) const {
    const Vector3d p = body_T_hull.inverse() * point;
    const std::vector<Vector3d>& vertices = hull.vertices();
    for (const auto& [i, j, k] : hull.triangles()) {
      const Vector3d &a = vertices[i], &b = vertices[j], &c = vertices[k];
      if ((b - a).cross(c - a).dot(p - a) > 0.0) return false;
    }
    return hull.dimension() == 3;
  }
};

/// A link as FCL sees it, in the frame of its body.
struct LinkMesh {
  int body;
  std::vector<Solid> solids;
  FclMesh mesh;

  LinkMesh(const RobotModel& robot, int link) : body(robot.links[link].body) {
    for (const int index : robot.bodies[body].pieces) {
      const Piece& piece = robot.pieces[index];
      if (robot.collisions[piece.collision].link == link) solids.push_back({polytope(piece.shape), piece.body_T_piece});
    }
    if (solids.empty()) return;
    mesh.beginModel();
    for (const Solid& solid : solids) add(solid);
    mesh.endModel();
  }

 private:
  void add(const Solid& solid) {
    std::vector<Vector3d> points;
    for (const Vector3d& vertex : solid.hull.vertices()) points.push_back(solid.body_T_hull * vertex);
    std::vector<fcl::Triangle> triangles;
    for (const auto& [i, j, k] : solid.hull.triangles())
      triangles.emplace_back(static_cast<std::size_t>(i), static_cast<std::size_t>(j), static_cast<std::size_t>(k));
    mesh.addSubModel(points, triangles);
  }
};

/// Whether a solid of b lies inside one of a, as far as its first vertex can tell.
bool holdsSolidOf(const LinkMesh& a, const LinkMesh& b, const Isometry3d& a_T_b) {
  for (const Solid& inner : b.solids)
    for (const Solid& outer : a.solids)
      if (outer.holds(a_T_b * inner.body_T_hull * inner.hull.vertices().front())) return true;
  return false;
}

/// Distance of the surfaces; 0 where they meet or one solid holds another.
double fclDistance(const LinkMesh& a, const LinkMesh& b, const BodyPoses& poses) {
  const Isometry3d &pose_a = *poses[a.body], &pose_b = *poses[b.body];
  const Isometry3d a_T_b = pose_a.inverse() * pose_b;
  if (holdsSolidOf(a, b, a_T_b) || holdsSolidOf(b, a, a_T_b.inverse())) return 0.0;
  fcl::DistanceResultd result;
  fcl::distance(&a.mesh, pose_a, &b.mesh, pose_b, fcl::DistanceRequestd(), result);
  return std::max(0.0, result.min_distance);
}

class SceneAndFcl : public testing::TestWithParam<ExampleRobot> {
 protected:
  void SetUp() override {
    if (!findsExampleRobots(resolve_)) GTEST_SKIP() << kExampleRobotsMissing;
    model_ = load(kHulls);
    const std::shared_ptr<const SceneModel>& model = model_;
    for (std::size_t link = 0; link < model->robot.links.size(); ++link)
      meshes_.push_back(std::make_unique<LinkMesh>(model->robot, static_cast<int>(link)));
  }

  std::shared_ptr<const SceneModel> load(double mesh_tolerance) const {
    ModelOptions options = cachedLoading();
    options.mesh_tolerance = mesh_tolerance;
    return modelOf(GetParam(), resolve_, options);
  }

  const LinkMesh& meshOf(const ShapeRef& subject) const { return *meshes_[subject.link()]; }

  const MeshResolver resolve_ = exampleRobotsResolver();
  std::shared_ptr<const SceneModel> model_;
  std::vector<std::unique_ptr<LinkMesh>> meshes_;
};

TEST_P(SceneAndFcl, EveryCandidatePairOfRandomStatesAgreesWhereApart) {
  Scene scene(model_);
  std::mt19937 random(7);
  int apart = 0, meeting = 0;
  for (int state = 0; state < kStates; ++state) {
    const BodyPoses poses = randomState(model_->robot, random);
    scene.update(poses);
    double smallest = std::numeric_limits<double>::infinity();
    for (const PairProximity& pair : scene.all(scene.candidates())) {
      const double reference = fclDistance(meshOf(pair.asked.a), meshOf(pair.asked.b), poses);
      (reference > 0.0 ? apart : meeting) += 1;
      EXPECT_NEAR(std::max(0.0, pair.result.distance), reference, kAgreement)
          << model_->robot.links[pair.asked.a.link()].name << " - " << model_->robot.links[pair.asked.b.link()].name
          << " in state " << state;
      EXPECT_EQ(pair.result.status, Status::Converged);
      smallest = std::min(smallest, reference);
    }
    const PairProximity* minimum = scene.minimum(scene.candidates());
    ASSERT_TRUE(minimum);
    EXPECT_NEAR(std::max(0.0, minimum->result.distance), smallest, kAgreement);
  }
  EXPECT_GT(apart, kStates * static_cast<int>(scene.candidates().size()) / 2);
  EXPECT_GT(meeting, 0);
}

/// The mesh files as they are: with tolerance zero the pieces are their triangles. Hulls that are exact are the same.
struct Meshes {
  std::shared_ptr<const SceneModel> model;
  std::vector<std::unique_ptr<LinkMesh>> links;

  explicit Meshes(std::shared_ptr<const SceneModel> exact) : model(std::move(exact)) {
    for (std::size_t link = 0; link < model->robot.links.size(); ++link)
      links.push_back(std::make_unique<LinkMesh>(model->robot, static_cast<int>(link)));
  }
  double distance(const ShapeRefPair& pair, const BodyPoses& poses) const {
    const auto mesh = [this](const ShapeRef& s) -> const LinkMesh& { return *links[s.link()]; };
    return fclDistance(mesh(pair.a), mesh(pair.b), poses);
  }
};

/// Checks a few states against the triangles of the meshes; both are apart, or no judgement is passed.
void expectAgreement(std::shared_ptr<const SceneModel> model, const Meshes& truth, int states, double agreement) {
  Scene scene(model);
  std::mt19937 random(11);
  int apart = 0;
  for (int state = 0; state < states; ++state) {
    const BodyPoses poses = randomState(model->robot, random);
    scene.update(poses);
    const Candidates& pairs = scene.candidates();
    for (std::size_t i = 0; i < pairs.size(); i += 5) {
      const double reference = truth.distance(pairs[i], poses);
      if (!(reference > agreement)) continue;
      ++apart;
      EXPECT_NEAR(scene.proximity(pairs[i]).result.distance, reference, agreement)
          << "pair " << i << ", state " << state;
    }
  }
  EXPECT_GT(apart, states);
}

TEST_P(SceneAndFcl, TrianglesAgreeWithTheMeshesWhereApart) {
  const Meshes truth(load(0.0));
  expectAgreement(truth.model, truth, 2, kAgreement);
}

// Each of the two may lie its tolerance from its mesh.
TEST_P(SceneAndFcl, DecompositionsAgreeWithTheMeshesWithinTwiceTheirTolerance) {
  constexpr double kTolerance = 0.005;
  const Meshes truth(load(0.0));
  expectAgreement(load(kTolerance), truth, 10, 2.0 * kTolerance);
}

// --- two Pandas in one cell

TEST(TwoPandasAndFcl, EveryPairBetweenThemAgreesWhereApartInRandomStates) {
  const MeshResolver resolve = exampleRobotsResolver();
  if (!findsExampleRobots(resolve)) GTEST_SKIP() << kExampleRobotsMissing;
  const ExampleRobot& panda = kExampleRobots[0];
  const std::string urdf = readFile(exampleRobotFile(resolve, panda.urdf));
  const std::string srdf = readFile(exampleRobotFile(resolve, panda.srdf));
  ModelOptions options = cachedLoading();
  options.mesh_tolerance = kHulls;
  auto model = std::make_shared<SceneModel>();
  model->robot = loadRobots({{"left", urdf}, {"right", urdf}}, resolve, options);
  model->pairs = filterPairs(model->robot, std::vector<std::string>{srdf, srdf});
  const Meshes truth(model);
  Scene scene(model);
  std::mt19937 random(5);
  std::uniform_real_distribution<double> apart_by(0.3, 1.0), angle(-3.0, 3.0);
  int apart = 0, meeting = 0;
  for (int state = 0; state < kStates; ++state) {
    const Isometry3d right =
        Eigen::Translation3d(apart_by(random), 0.1, 0.0) * Eigen::AngleAxisd(angle(random), Vector3d::UnitZ());
    const BodyPoses poses = placedAt(model->robot, randomState(model->robot, random), {Isometry3d::Identity(), right});
    scene.update(poses);
    for (const PairProximity& pair : scene.all(scene.candidates())) {
      if (model->robot.robotOf(pair.asked.a.link()).name == model->robot.robotOf(pair.asked.b.link()).name) continue;
      const double reference = truth.distance(pair.asked, poses);
      (reference > 0.0 ? apart : meeting) += 1;
      EXPECT_NEAR(std::max(0.0, pair.result.distance), reference, kAgreement) << "state " << state;
    }
  }
  // Eleven links of each have geometry.
  EXPECT_EQ(apart + meeting, 121 * kStates);
  EXPECT_GT(apart, 100 * kStates);
  if (!kIsSanitized) {
    EXPECT_GT(meeting, kStates / 10);
  }
}

INSTANTIATE_TEST_SUITE_P(Robots, SceneAndFcl, testing::ValuesIn(robotsToTest()),
                         [](const auto& robot) { return std::string(robot.param.name); });

}  // namespace proximity_server::scene::scene_fcl_test
