// The part of ./dev stress points that every test run makes; and distances from the triangles of meshes.
#include "oracle/point_oracle.h"
#include "proximity_server/scene/mesh/mesh.h"
#include "proximity_server/scene/points/point_search.h"
#include "scene/example_robots.h"
#include "scene/random_states.h"
#include "stress/campaign_test.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <string>
#include <vector>

namespace proximity_server::scene::point_stress_test {

using Eigen::Vector3d;

TEST(PointStress, PointsAndRaysAroundEveryRobotKeepEveryPromise) {
  const std::vector<stress::Tally> robots =
      stress::expectNoFailure(stress::pointCampaign(), "PROXIMITY_STRESS_POINTS", repeats(25000));
  for (const stress::Tally& robot : robots) {
    EXPECT_GT(robot["hits"], robot["rays"] / 4) << robot.family;
    EXPECT_LT(robot["hits"], robot["rays"]) << robot.family;
    EXPECT_GT(robot["inside"], robot["points"] / 20) << robot.family;
    EXPECT_LT(robot["inside"], robot["points"] / 2) << robot.family;
  }
  if (kIsSanitized) return;  // what follows is of the whole test
  const stress::Tally all = stress::sumOf(robots);
  for (const char* number : {"near", "beyond", "from_inside"}) EXPECT_GT(all[number], 0) << number;
  EXPECT_LT(all["grazing"], all["hits"] / 10);
  if (!findsExampleRobots(exampleRobotsResolver())) GTEST_SKIP() << kExampleRobotsMissing;
  EXPECT_EQ(robots.size(), 25u);
  EXPECT_GT(all["in_mesh"], 0);
}

using Corners = std::array<Vector3d, 3>;

/// The triangles of a mesh, one by one.
struct Soup {
  explicit Soup(const TriangleMesh& mesh) {
    for (const std::array<int, 3>& t : mesh.triangles)
      triangles.push_back({mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]});
    for (const Vector3d& vertex : mesh.vertices) box.extend(vertex);
  }

  double distance(const Vector3d& p) const {
    double squared = std::numeric_limits<double>::infinity();
    for (const Corners& t : triangles) squared = std::min(squared, (p - narrowphase::nearestOf(t, p)).squaredNorm());
    return std::sqrt(squared);
  }

  /// How often closed triangles surround a point: the sum of their solid angles over that of a sphere.
  /// Source: Van Oosterom, Strackee, The Solid Angle of a Plane Triangle, 1983.
  double windingNumber(const Vector3d& p) const {
    double sum = 0.0;
    for (const Corners& t : triangles) {
      const Vector3d a = t[0] - p, b = t[1] - p, c = t[2] - p;
      const double la = a.norm(), lb = b.norm(), lc = c.norm();
      sum += 2.0 * std::atan2(a.dot(b.cross(c)), la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb);
    }
    return sum / (4.0 * M_PI);
  }

  std::vector<Corners> triangles;
  Eigen::AlignedBox3d box;
};

/// A robot whose meshes have no scale.
class MeshesOfRobot {
 public:
  MeshesOfRobot(const std::string& urdf, const MeshResolver& resolve) : resolve_(resolve), chance_(23) {
    RobotModel robot = loadRobotModel(readFile(resolve(urdf)), resolve, quickLoading());
    model_ = std::make_shared<const SceneModel>(SceneModel{robot, filterPairs(robot, "")});
  }

  void expectDistancesOfTriangles(int points) {
    State state(model_);
    state.set(placedAt(model_->robot, forwardKinematics(model_->robot, randomPositions(model_->robot, chance_)),
                       {chance_.pose(1.0)}));
    std::vector<const Collision*> meshes;
    for (const Collision& collision : model_->robot.collisions)
      if (collision.description.rfind("mesh ", 0) == 0) meshes.push_back(&collision);
    ASSERT_FALSE(meshes.empty());
    for (const Collision* mesh : meshes) {
      SCOPED_TRACE(model_->robot.links[mesh->link].name);
      const Soup soup(loadMesh(resolve_(mesh->description.substr(5)), Vector3d::Ones()));
      for (std::size_t i = 0; i < points / meshes.size() + 1; ++i) expectDistance(state, *mesh, soup);
    }
  }

  int inside = 0, outside = 0;

 private:
  void expectDistance(const State& state, const Collision& mesh, const Soup& soup) {
    const Vector3d point = soup.box.center() + 0.7 * soup.box.sizes().cwiseProduct(somewhere());
    const Eigen::Isometry3d& body_T_mesh = model_->robot.pieces[mesh.pieces.front()].body_T_piece;
    const Vector3d place = *state.poseOf(mesh.link) * (body_T_mesh * point);
    PointSearch search(model_);
    const PairProximity answer = search.closest(state, {{place}, {}, {ShapeRef(mesh.link, mesh.number)}}).front();
    const double distance = answer.result.distance, of_triangles = soup.distance(point);
    const double rounding = 2e-9;  // tolerance and places
    const bool is_closed = !std::isnan(mesh.volume_ratio);
    const bool is_inside = is_closed && std::abs(soup.windingNumber(point)) > 0.5;
    const auto failHere = [&](const char* what) {
      ADD_FAILURE() << what << ": " << distance << ", of the triangles " << of_triangles << ", deviation "
                    << mesh.deviation << ", uncovered " << mesh.uncovered << " at " << point.transpose();
    };
    ++(is_inside ? inside : outside);
    if (is_inside && distance > -of_triangles + mesh.uncovered + rounding)
      failHere("the depth inside of a closed mesh is too small");
    if (!is_inside && distance >= 0.0 && of_triangles > distance + mesh.deviation + rounding)
      failHere("the distance is too small");
    if (!is_inside && distance > of_triangles + mesh.uncovered + rounding) failHere("the distance is too large");
    if (!is_inside && is_closed && distance < 0.0 && of_triangles > mesh.deviation + rounding)
      failHere("a point outside is inside");
  }

  /// Within the cube of size 2.
  Vector3d somewhere() {
    const double x = chance_.between(-1, 1), y = chance_.between(-1, 1), z = chance_.between(-1, 1);
    return {x, y, z};
  }

  const MeshResolver resolve_;
  Chance chance_;
  std::shared_ptr<const SceneModel> model_;
};

TEST(PointStress, DistancesAreThoseOfTheMeshesWithinTheirDeviation) {
  const MeshResolver resolve = exampleRobotsResolver();
  if (!findsExampleRobots(resolve)) GTEST_SKIP() << kExampleRobotsMissing;
  std::vector<std::string> urdfs{"package://example-robot-data/robots/panda_description/urdf/panda.urdf"};
  if (!kIsSanitized)
    urdfs.insert(urdfs.end(), {"package://example-robot-data/robots/ur_description/urdf/ur5_robot.urdf",
                               "package://example-robot-data/robots/kinova_description/robots/kinova.urdf",
                               "package://public_robots/gen3/gen3.urdf", "package://public_robots/iiwa14/iiwa14.urdf"});
  int inside = 0, outside = 0;
  for (const std::string& urdf : urdfs) {
    SCOPED_TRACE(urdf);
    MeshesOfRobot robot(urdf, resolve);
    robot.expectDistancesOfTriangles(repeats(1000));
    inside += robot.inside;
    outside += robot.outside;
  }
  EXPECT_GT(inside, 100);
  EXPECT_GT(outside, 100);
}

}  // namespace proximity_server::scene::point_stress_test
