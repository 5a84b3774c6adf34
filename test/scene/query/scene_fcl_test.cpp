// Panda, UR5 and PR2 of example-robot-data, where they can be found, against FCL.
//
// The reference is the distance of triangle meshes, one mesh for each link: it walks a tree of boxes down to pairs of
// triangles, and so shares nothing with GJK, EPA, warm starts or our bounds. FCL's own GJK would be no judge: it stalls
// on one hull query in two hundred, with errors up to 0.2 m.
#include "peers/robots.h"
#include "proximity_server/scene/loading/load_robot_model.h"
#include "proximity_server/scene/model/kinematics.h"
#include "sanitized.h"
#include "scene/example_robots.h"
#include "scene/posed_scene.h"
#include "scene/random_states.h"
#include "tools/second_opinion/fcl_shape.h"

#include <fcl/narrowphase/distance.h>
#include <gtest/gtest.h>

#include <limits>
#include <string>

namespace proximity_server::scene::scene_fcl_test {

using namespace narrowphase;

using Eigen::Isometry3d;
using Eigen::Vector3d;

const int kStates = repeats(60);
constexpr double kAgreement = 1e-6;  // [m]
constexpr double kHulls = 1.0;       // [m] a mesh tolerance in which every mesh is its hull

// --- the same solids as triangles

/// A link as FCL sees it, in the frame of its body.
struct LinkMesh {
  int body;
  std::vector<const Piece*> pieces;
  tools::FclMesh mesh;

  LinkMesh(const RobotModel& robot, int link) : body(robot.links[link].body), pieces(peers::piecesOfLink(robot, link)) {
    if (pieces.empty()) return;
    mesh.beginModel();
    for (const Piece* piece : pieces) tools::addTriangles(mesh, piece->shape, piece->body_T_piece);
    mesh.endModel();
  }
};

/// Whether a point lies inside of a box or a hull.
bool holds(const Shape& shape, const Vector3d& p) {
  if (shape.kind() == Shape::Kind::Box) return (p.cwiseAbs().array() < shape.halfExtents().array()).all();
  const std::vector<Vector3d>& vertices = shape.hull().vertices();
  for (const auto& [i, j, k] : shape.hull().triangles()) {
    const Vector3d &a = vertices[i], &b = vertices[j], &c = vertices[k];
    if ((b - a).cross(c - a).dot(p - a) > 0.0) return false;
  }
  return shape.hull().dimension() == 3;
}

/// Whether the centre of a piece of b lies inside of a piece of a.
bool holdsPieceOf(const LinkMesh& a, const LinkMesh& b, const Isometry3d& a_T_b) {
  for (const Piece* inner : b.pieces)
    for (const Piece* outer : a.pieces)
      if (holds(outer->shape, outer->body_T_piece.inverse() * (a_T_b * inner->body_T_piece * inner->shape.centre())))
        return true;
  return false;
}

/// Distance of the surfaces; 0 where they meet or a piece of one holds one of the other.
double fclDistance(const LinkMesh& a, const LinkMesh& b, const BodyPoses& poses) {
  const Isometry3d &pose_a = *poses[a.body], &pose_b = *poses[b.body];
  const Isometry3d a_T_b = pose_a.inverse() * pose_b;
  if (holdsPieceOf(a, b, a_T_b) || holdsPieceOf(b, a, a_T_b.inverse())) return 0.0;
  fcl::DistanceResultd result;
  fcl::distance(&a.mesh, pose_a, &b.mesh, pose_b, fcl::DistanceRequestd(), result);
  return std::max(0.0, result.min_distance);
}

/// A robot with the meshes of its links. With the mesh tolerance 0 its pieces are the triangles of the mesh files; hulls
/// that are exact are the same.
struct Meshes {
  std::shared_ptr<const SceneModel> model;
  std::vector<std::unique_ptr<LinkMesh>> links;

  explicit Meshes(std::shared_ptr<const SceneModel> of_model) : model(std::move(of_model)) {
    for (std::size_t link = 0; link < model->robot.links.size(); ++link)
      links.push_back(std::make_unique<LinkMesh>(model->robot, static_cast<int>(link)));
  }
  double distance(const ShapeRefPair& pair, const BodyPoses& poses) const {
    return fclDistance(*links[pair.a.link()], *links[pair.b.link()], poses);
  }
};

class SceneAndFcl : public testing::TestWithParam<ExampleRobot> {
 protected:
  void SetUp() override {
    if (!findsExampleRobots(resolve_)) GTEST_SKIP() << kExampleRobotsMissing;
  }

  std::shared_ptr<const SceneModel> load(double mesh_tolerance) const {
    ModelOptions options = cachedLoading();
    options.mesh_tolerance = mesh_tolerance;
    return modelOf(GetParam(), resolve_, options);
  }

  const MeshResolver resolve_ = exampleRobotsResolver();
};

TEST_P(SceneAndFcl, EveryCandidatePairOfRandomStatesAgreesWhereApart) {
  const Meshes truth(load(kHulls));
  const RobotModel& robot = truth.model->robot;
  PosedScene scene(truth.model);
  Chance chance(7);
  int apart = 0, meeting = 0;
  for (int state = 0; state < kStates; ++state) {
    const BodyPoses poses = forwardKinematics(robot, randomPositions(robot, chance));
    scene.update(poses);
    double smallest = std::numeric_limits<double>::infinity();
    for (const PairProximity& pair : scene.all(scene.candidates())) {
      const double reference = truth.distance(pair.asked, poses);
      (reference > 0.0 ? apart : meeting) += 1;
      EXPECT_NEAR(std::max(0.0, pair.result.distance), reference, kAgreement)
          << robot.links[pair.asked.a.link()].name << " - " << robot.links[pair.asked.b.link()].name << " in state "
          << state;
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

/// Checks a few states against the triangles of the meshes; both are apart, or no judgement is passed.
void expectAgreement(const std::shared_ptr<const SceneModel>& model, const Meshes& truth, int states,
                     double agreement) {
  PosedScene scene(model);
  Chance chance(11);
  int apart = 0;
  for (int state = 0; state < states; ++state) {
    const BodyPoses poses = forwardKinematics(model->robot, randomPositions(model->robot, chance));
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

INSTANTIATE_TEST_SUITE_P(Robots, SceneAndFcl, testing::ValuesIn(robotsToTest()),
                         [](const auto& robot) { return std::string(robot.param.name); });

}  // namespace proximity_server::scene::scene_fcl_test
