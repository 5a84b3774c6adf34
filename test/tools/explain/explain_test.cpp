// What the executable tells of a query, and how it ends.
#include "proximity_server/narrowphase/signed_distance.h"
#include "robots/urdf.h"
#include "tools/explain/explain_command.h"
#include "tools/robot/two_sliders.h"
#include "tools/text/csv.h"

#include <algorithm>
#include <cmath>

namespace proximity_server::tools::explain_test {

using Json = nlohmann::json;

TEST(Explain, TheTableHasARowForEachStep) {
  const CommandResult result = explainCommand(kFourSteps);
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_EQ(result.errors, "");
  EXPECT_EQ(result.output.substr(0, result.output.find(" (width")), R"(a: hull of 7 points
b: hull of 1 point
b lies at (0, 0, 0) in the frame of a.

GJK: the point of the CSO, a - b, that is nearest to the origin
  step  vertex  point of a  point of b  simplex  nearest point          lower        upper
     1  A       (5, 6, 0)   (0, 0, 0)   A        (5, 6, 0)              -6           7.81024968
     2  B       (4, -4, 0)  (0, 0, 0)   A B      (4.3564, -0.43564, 0)  -0.51214752  4.37816364
     3  D       (1, 2, 0)   (0, 0, 0)   B D      (1.6, 0.8, 0)          0.796029752  1.78885438
     4  F       (2, -1, 0)  (0, 0, 0)   D F      (1.5, 0.5, 0)          1.34164079   1.58113883
     5  D       (1, 2, 0)   (0, 0, 0)   D F      (1.5, 0.5, 0)          1.58113883   1.58113883

The answer is by GJK.
  distance  1.58113883 m, from 1.58113883 to 1.58113883)");
  EXPECT_TRUE(says(result.output, "\n  normal    (-0.94868, -0.31623, 0)\n"));
  EXPECT_TRUE(says(result.output, "\n  points    (1.5, 0.5, 0) of a, (0, 0, 0) of b\n"));
  EXPECT_TRUE(says(result.output, "\n  status    converged, 5 iterations\n"));
}

TEST(Explain, EpaHasItsOwnTable) {
  const std::string table = explainCommand(kOctahedron).output;
  EXPECT_TRUE(says(table, "EPA: the face of the CSO that is closest to the origin inside\n")) << table;
  EXPECT_TRUE(says(table, "  step  faces  closest face  normal ")) << table;
  EXPECT_TRUE(says(table, "The answer is by EPA.\n")) << table;
  EXPECT_TRUE(says(table, "b: sphere (core and a margin of 0.5 m)\n")) << table;
}

TEST(Explain, TheBoundsOfTheStepsIncludeTheMargins) {
  const Json answer = explainJson(kOctahedron), last = answer["epa"].back();
  const double distance = -(3.6 / std::sqrt(17.0) + 0.5);
  EXPECT_NEAR(answer["distance"].get<double>(), distance, 1e-14);
  EXPECT_NEAR(last["lower"].get<double>(), distance, 1e-13);
  EXPECT_NEAR(last["upper"].get<double>(), distance, 1e-13);
}

TEST(Explain, JsonHasTheDigitsOfTheQuery) {
  Eigen::Isometry3d a_T_b(Eigen::Translation3d(0.3, 0.2, 0.1));
  a_T_b.linear() = Eigen::AngleAxisd(0.5, Eigen::Vector3d::UnitX()).toRotationMatrix();
  const narrowphase::SignedDistance expected =
      signedDistance(narrowphase::Cylinder{0.3, 1.0}, narrowphase::Ellipsoid{{0.4, 0.5, 0.6}}, a_T_b);
  const Json answer = explainJson("'cylinder 0.3 1' 'ellipsoid 0.4 0.5 0.6' --xyz '0.3 0.2 0.1' --rpy '0.5 0 0'");
  EXPECT_EQ(answer["distance"].get<double>(), expected.distance);
  EXPECT_EQ(answer["lower"].get<double>(), expected.lower_bound);
  EXPECT_EQ(answer["upper"].get<double>(), expected.upper_bound);
  EXPECT_EQ(answer["normal"][0].get<double>(), expected.normal.x());
  EXPECT_EQ(answer["iterations"].get<int>(), expected.iterations);
  const int steps = static_cast<int>(answer["gjk"].size() + answer["epa"].size());
  EXPECT_GE(steps, expected.iterations - 1) << "the last iteration of EPA may need no vertex";
  EXPECT_LE(steps, expected.iterations);
}

TEST(Explain, PointsAreNamedInTheOrderOfTheHulls) {
  const Json answer = explainJson(kPolygons);
  for (const Json& vertex : answer["vertices"]) {
    const std::string name = vertex["name"];
    ASSERT_EQ(name.size(), 2U);
    const std::vector<std::vector<double>> a{{0, 0, 0}, {3, -1, 0}, {4, 2, 0}, {1, 3, 0}},
        b{{7, 1, 0}, {9, 4, 0}, {6, 4, 0}};
    EXPECT_EQ(vertex["on_a"], Json(a.at(name[0] - 'A'))) << name;
    EXPECT_EQ(vertex["on_b"], Json(b.at(name[1] - 'a'))) << name;
  }
}

// The length of the translation overflows, and its coordinates do not.
TEST(Explain, ShowsLargeCoordinatesAsTheyAre) {
  const std::string table = explainCommand("'box 1 1 1' 'box 1 1 1' --xyz '1e308 1e308 0'").output;
  EXPECT_TRUE(says(table, "\nb lies at (1e+308, 1e+308, 0) in the frame of a.\n")) << table;
  EXPECT_TRUE(says(table, "The answer is by nothing: the pose is not finite, or lengths add up to more than 1e30 m.\n"))
      << table;
}

TEST(Explain, NamesTheClosedForm) {
  EXPECT_TRUE(
      says(explainCommand("'sphere 1' 'capsule 1 2' --xyz '5 0 0'").output,
           "The answer is by the closed form of points and segments, and of a point and a box.\n  distance  3 m"));
  EXPECT_TRUE(says(explainCommand("'cylinder 1 2' 'cone 1 2' --xyz '5 0 0'").output,
                   "by the closed form of solids of revolution about parallel axes.\n  distance  3 m"));
  EXPECT_TRUE(says(explainCommand("'box 2 2 2' 'box 2 2 2' --xyz '1.5 0.25 0.125' --rpy '0.3 0.2 0.1'").output,
                   "The answer is by the fifteen axes of two boxes.\n"));
}

TEST(Explain, TheThresholdsEndTheSearch) {
  const Json answer = explainJson("'box 2 2 2' 'box 2 2 2' --xyz '5 1 1' --stop-above 2.5");
  EXPECT_EQ(answer["status"], "threshold");
  EXPECT_EQ(answer["gjk"].size(), 1U);
  EXPECT_GT(answer["lower"].get<double>(), 2.5);
  EXPECT_EQ(answer["point_a"][0], nullptr);
  EXPECT_EQ(explainJson("'box 2 2 2' 'hull 1 0.25 0.125 0.5' --stop-below -0.01")["status"], "threshold");
}

// Both cubes have an inner ball of radius 1.
TEST(Explain, NamesTheBallsInsideThatDecideAThreshold) {
  const std::string table = explainCommand("'box 2 2 2' 'box 2 2 2' --xyz '1 0 0' --stop-below -0.5").output;
  EXPECT_TRUE(says(table, "\n     1  ")) << "the first vertex, which proves the lower bound: " << table;
  EXPECT_FALSE(says(table, "nan")) << table;
  EXPECT_TRUE(says(table,
                   "The answer is by balls inside of both cores, which decide the threshold.\n"
                   "  distance  -1 m, from -1 to -1 (width "))
      << table;
}

TEST(Explain, ReadsPaddedAndSweptShapesAndWholePoses) {
  const std::string quarter_turn = "0 -1 0 1 0 0 0 0 1 5 0 0";
  EXPECT_EQ(explainJson("'box 2 4 2' 'box 2 4 2' --pose '" + quarter_turn + "'")["distance"], 2.0);
  EXPECT_EQ(explainJson("'box 2 4 2 pad 0.25' 'sphere 1' --xyz '5 0 0'")["distance"], 2.75);
  EXPECT_EQ(explainJson("'box 2 4 2 sweep 1 0 0 0 1 0 0 0 1 1 0 0' 'sphere 1' --xyz '5 0 0'")["distance"], 2.0);
}

class ExplainLinks : public ::testing::Test {
 protected:
  static std::string slideAt(double position) { return " --state slide=" + shortest(position); }

  std::string robot() const { return " --urdf " + urdf_; }

  scene::TemporaryFiles files_;
  std::string urdf_ = files_.write("robot.urdf", kTwoSliders);
};

TEST_F(ExplainLinks, AreAskedAboutInTheState) {
  EXPECT_EQ(explainJson("base 'sled, left'" + robot())["distance"], 1.0);
  EXPECT_EQ(explainJson("base 'sled, left'" + robot() + slideAt(0.5))["distance"], 1.5);
  EXPECT_EQ(explainJson("'sled, left' ball" + robot() + slideAt(0.5))["distance"], 2.75) << "the ball follows";
  EXPECT_EQ(explainJson("base 'sled, left'" + robot() + slideAt(0.5))["a"], "base, box 1 x 1 x 1");
}

TEST_F(ExplainLinks, AreExplainedByTheirClosestPieces) {
  using namespace robots;
  urdf_ = files_.write("pieces.urdf", urdfOf(link("base", box("1 1 1", "-5 0 0") + ball("0.5", "5 0 0")) +
                                             link("ball", ball("0.25")) + slider("slide", "base", "ball", "1 0 0")));
  const Json left = explainJson("base ball" + robot() + slideAt(-2.0)),
             right = explainJson("base ball" + robot() + slideAt(2.0));
  EXPECT_EQ(left["a"], "base, box 1 x 1 x 1");
  EXPECT_EQ(left["distance"], 2.25);
  EXPECT_EQ(right["a"], "base, sphere, radius 0.5");
  EXPECT_EQ(right["distance"], 2.25);
}

TEST_F(ExplainLinks, MayHaveTheGeometryOfTheirVisuals) {
  urdf_ = files_.write("seen.urdf", R"(<robot name="seen">
    <link name="base"><collision><geometry><box size="1 1 1"/></geometry></collision></link>
    <link name="ball"><visual><geometry><sphere radius="0.25"/></geometry></visual></link>
    <joint name="slide" type="prismatic"><parent link="base"/><child link="ball"/><axis xyz="1 0 0"/>
      <limit lower="-9" upper="9" effort="1" velocity="1"/></joint></robot>)");
  const std::string srdf =
      files_.write("seen.srdf", "<robot name='seen'><group name='all_but'><joint name='slide'/></group></robot>");
  const std::string config = files_.write("cell.yaml", "collision_from_visual: [all_but]");
  const Json answer = explainJson("base ball" + robot() + slideAt(2.0) + " --config " + config + " --srdf " + srdf);
  EXPECT_EQ(answer["b"], "ball, sphere, radius 0.25, of its <visual>");
  EXPECT_EQ(answer["distance"], 1.25);
}

}  // namespace proximity_server::tools::explain_test
