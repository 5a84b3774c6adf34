// Real robots of example-robot-data, where they can be found.

#include "proximity_server/scene/levels/make_scene_model.h"
#include "proximity_server/scene/loading/load_robot_model.h"
#include "proximity_server/scene/query/scene.h"
#include "scene/example_robots.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <map>
#include <sstream>
#include <utility>

namespace proximity_server::scene::shared_robots_test {

using namespace narrowphase;

constexpr ExampleRobot kPanda = kExampleRobots[0], kUr5 = kExampleRobots[1], kPr2 = kExampleRobots[2];

// [m] Every mesh is its hull: quick, for what does not depend on the pieces.
constexpr double kHulls = 1.0;

class SharedRobots : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!findsExampleRobots(resolve_)) GTEST_SKIP() << kExampleRobotsMissing;
  }
  std::string read(const std::string& file) const { return readFile(exampleRobotFile(resolve_, file)); }
  RobotModel load(const ExampleRobot& files, double mesh_tolerance = kHulls) const {
    ModelOptions options = cachedLoading();
    options.mesh_tolerance = mesh_tolerance;
    return loadRobotModel(read(files.urdf), resolve_, options);
  }
  PairTable filter(const RobotModel& model, const ExampleRobot& files) const {
    return filterPairs(model, read(files.srdf));
  }

  MeshResolver resolve_ = exampleRobotsResolver();
};

std::map<PairReason, int> countReasons(const PairTable& table) {
  std::map<PairReason, int> counts;
  for (const LinkPair& pair : table.pairs) ++counts[pair.reason];
  return counts;
}

int countLinksWithGeometry(const RobotModel& model) {
  return static_cast<int>(
      std::count_if(model.links.begin(), model.links.end(), [](const Link& link) { return !link.collisions.empty(); }));
}

std::string warning(const PairTable& table, const std::string& what) {
  for (const std::string& text : table.warnings) {
    if (text.find(what) != std::string::npos) return text;
  }
  return "";
}

using Counts = std::map<PairReason, int>;

// 11 links have geometry: 55 pairs. The SRDF disables 35, one of them (hand and link 7) within a body.
TEST_F(SharedRobots, PandaKeepsTwentyOfItsPairs) {
  const RobotModel model = load(kPanda);
  EXPECT_EQ(countLinksWithGeometry(model), 11);
  const PairTable table = filter(model, kPanda);
  EXPECT_EQ(countReasons(table),
            (Counts{{PairReason::Checked, 20}, {PairReason::SrdfDisabled, 34}, {PairReason::SameBody, 1}}));
}

// 8 links have geometry: 28 pairs, of which the SRDF disables 10. It does not know ee_link, which is one body with
// wrist 3; that has geometry, so ee_link is no neighbour of wrist 2.
TEST_F(SharedRobots, Ur5KeepsSeventeenOfItsPairs) {
  const RobotModel model = load(kUr5);
  EXPECT_EQ(countLinksWithGeometry(model), 8);
  const PairTable table = filter(model, kUr5);
  EXPECT_EQ(countReasons(table),
            (Counts{{PairReason::Checked, 17}, {PairReason::SrdfDisabled, 10}, {PairReason::SameBody, 1}}));
  EXPECT_EQ(table.pairs.at(table.find(model.findLink("wrist_2_link"), model.findLink("ee_link"))).reason,
            PairReason::Checked);
}

// 32 links have geometry: 496 pairs. Of 1163 entries 906 name a link without geometry; the other 257 are different
// pairs, 5 of them within a body. They cover all neighbours.
TEST_F(SharedRobots, Pr2KeepsTwoHundredThirtyNineOfItsPairs) {
#ifdef PROXIMITY_SANITIZED
  GTEST_SKIP() << "the hulls of its meshes take minutes there";
#endif
  const RobotModel model = load(kPr2);
  EXPECT_EQ(countLinksWithGeometry(model), 32);
  const PairTable table = filter(model, kPr2);
  EXPECT_EQ(countReasons(table),
            (Counts{{PairReason::Checked, 239}, {PairReason::SrdfDisabled, 252}, {PairReason::SameBody, 5}}));
  EXPECT_NE(warning(table, "of 1163").find("a link without collision geometry (906)"), std::string::npos);
}

// Regression: each was taken for a pair of neighbours, as a joint joins their bodies, and was checked by nobody.
TEST_F(SharedRobots, WhatIsFixedToANeighbourIsChecked) {
  const auto expectChecked = [&](const std::string& urdf, const std::string& a, const std::string& b) {
    const RobotModel model = load({"", urdf.c_str(), ""});
    const PairTable table = filterPairs(model, "");
    EXPECT_EQ(table.pairs.at(table.find(model.findLink(a), model.findLink(b))).reason, PairReason::Checked)
        << a << " - " << b;
  };
  expectChecked("laikago_description/urdf/laikago.urdf", "trunk", "FL_thigh_shoulder");
#ifndef PROXIMITY_SANITIZED  // their meshes take a minute there
  expectChecked(kPr2.urdf, "head_pan_link", "double_stereo_link");
  expectChecked("hyq_description/robots/hyq_no_sensors.urdf", "lf_upperleg", "lf_foot");
#endif
}

TEST_F(SharedRobots, LaikagosShouldersThatAreInTheirThighsAreNamed) {
  const ExampleRobot laikago{"Laikago", "laikago_description/urdf/laikago.urdf", ""};
  const SceneModel model = makeSceneModel(load(laikago), "");
  const std::string text = warning(model.pairs, "in contact in each of 300 states");
  EXPECT_NE(text.find("(4): FL_thigh_shoulder - FL_thigh, "), std::string::npos) << text;
}

TEST_F(SharedRobots, PandaHasARevoluteArmAndAFingerThatMimics) {
  const RobotModel model = load(kPanda);
  EXPECT_EQ(model.joints.size(), 9U);
  EXPECT_EQ(std::count_if(model.joints.begin(), model.joints.end(),
                          [](const Joint& joint) { return joint.type == Joint::Type::Revolute; }),
            7);
  EXPECT_EQ(std::count_if(model.joints.begin(), model.joints.end(), [](const Joint& j) { return j.mimic.has_value(); }),
            1);
}

int countVertices(const RobotModel& model, const Collision& collision) {
  int vertices = 0;
  for (const int piece : collision.pieces) {
    const Shape& shape = model.pieces[piece].shape;
    vertices += shape.kind() == Shape::Kind::Hull ? shape.hull().size() : 0;
  }
  return vertices;
}

bool isMesh(const Collision& collision) { return collision.description.rfind("mesh", 0) == 0; }

/// Writes the pieces that stand for each mesh, for a table of test/benchmark/TABLES.md. A volume ratio that is NaN
/// becomes null.
nlohmann::json meshesOf(const RobotModel& model) {
  nlohmann::json meshes = nlohmann::json::array();
  for (const Collision& collision : model.collisions) {
    if (!isMesh(collision)) continue;
    meshes.push_back({{"robot", model.name},
                      {"link", model.links[collision.link].name},
                      {"representation", toString(collision.representation)},
                      {"pieces", collision.pieces.size()},
                      {"vertices", countVertices(model, collision)},
                      {"deviation", collision.deviation},
                      {"uncovered", collision.uncovered},
                      {"volume_ratio", collision.volume_ratio}});
  }
  return meshes;
}

TEST_F(SharedRobots, PiecesLieWithinTheToleranceOfTheMeshes) {
  nlohmann::json meshes = nlohmann::json::array();
  for (const ExampleRobot& files : robotsToTest()) {
    const RobotModel model = load(files, ModelOptions{}.mesh_tolerance);
    for (nlohmann::json& mesh : meshesOf(model)) meshes.push_back(std::move(mesh));
    for (const Collision& collision : model.collisions) {
      EXPECT_LE(collision.deviation, ModelOptions{}.mesh_tolerance) << collision.description;
      EXPECT_LE(collision.uncovered, 1e-9) << collision.description;
      EXPECT_NE(collision.representation, Representation::Triangles) << collision.description;
      EXPECT_TRUE(isMesh(collision) || collision.representation == Representation::Exact) << collision.description;
    }
  }
  const char* path = std::getenv("PROXIMITY_MESHES_JSON");
  if (path)
    std::ofstream(path) << nlohmann::json{{"tolerance", ModelOptions{}.mesh_tolerance}, {"meshes", meshes}}.dump(1)
                        << '\n';
}

// Meshes of 5,864 and of 66,456 triangles, which stood for themselves: their decomposition took too long.
TEST_F(SharedRobots, LargeMeshesBecomeFewPiecesWithinTheTimeBudget) {
#ifdef PROXIMITY_SANITIZED
  GTEST_SKIP() << "takes ten seconds without a sanitizer";
#endif
  const struct {
    const char* urdf;
    std::size_t most_pieces;  // a tenth of what there was
  } cases[] = {{"hyq_description/robots/hyq_no_sensors.urdf", 600}, {"b1_description/urdf/b1-z1.urdf", 6600}};
  for (const auto& robot : cases) {
    const RobotModel model = loadRobotModel(read(robot.urdf), resolve_);
    EXPECT_LT(model.pieces.size(), robot.most_pieces) << robot.urdf;
    for (const Collision& collision : model.collisions) {
      EXPECT_LE(collision.deviation, ModelOptions{}.mesh_tolerance) << collision.description;
      EXPECT_LE(collision.uncovered, 1e-9) << collision.description;
    }
    for (const std::string& text : model.warnings) EXPECT_EQ(text.find("time budget"), std::string::npos) << text;
  }
}

// Panda's meshes look convex, but their edges dent by up to half a millimetre.
TEST_F(SharedRobots, PandaMeshesAreTheirHulls) {
  for (const Collision& collision : load(kPanda).collisions) {
    if (!isMesh(collision)) continue;
    EXPECT_EQ(collision.representation, Representation::ConvexHull) << collision.description;
    EXPECT_LT(collision.deviation, 5e-4) << collision.description;
  }
}

TEST_F(SharedRobots, Ur5IsMadeOfTrianglesWhereTheToleranceIsZero) {
  const RobotModel model = load(kUr5, 0.0);
  for (const Collision& collision : model.collisions) {
    const bool triangles = collision.representation == Representation::Triangles;
    EXPECT_EQ(triangles, isMesh(collision)) << collision.description;
  }
}

}  // namespace proximity_server::scene::shared_robots_test
