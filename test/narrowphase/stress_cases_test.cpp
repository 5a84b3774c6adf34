// Hard pairs that made other libraries fail, each with an exact answer.
#include "laws/pair_laws.h"
#include "narrowphase/certificate.h"
#include "narrowphase/from_json.h"
#include "oracle/shape_pairs.h"
#include "proximity_server/narrowphase/shape/rigid_pose.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>

namespace proximity_server::narrowphase::stress_cases_test {

using Eigen::Isometry3d;
using Eigen::Vector3d;
using nlohmann::json;

/// A shape as placed in the world: the pose belongs to the hull, whose vertices round to a double.
std::vector<Vector3d> verticesInWorld(const json& c, const char* vertices, const char* size,
                                      const char* world_T_shape) {
  std::vector<Vector3d> points;
  if (c.contains(vertices)) {
    for (const json& vertex : c[vertices]) points.push_back(vectorFrom(vertex));
    return points;
  }
  const Vector3d half = 0.5 * vectorFrom(c[size]);
  for (int corner = 0; corner < 8; ++corner) {
    const Vector3d signs(corner & 1 ? 1 : -1, corner & 2 ? 1 : -1, corner & 4 ? 1 : -1);
    points.push_back(poseFrom(c[world_T_shape]) * half.cwiseProduct(signs));
  }
  return points;
}

/// The cases of a file, named from the root of the sources; an empty list where it is absent.
json casesIn(const std::string& path) {
  std::ifstream file(std::string(PROXIMITY_SOURCE_DIR) + "/" + path);
  return file ? json::parse(file)["cases"] : json::array();
}

struct StressCase : PairCase {
  double expected;
};

/// The cases as hulls in the world frame. Empty where the file is absent.
std::vector<StressCase> hullCases() {
  std::vector<StressCase> cases;
  const json file = casesIn("../shared/cases/stress_cases.json");
  for (const json& c : file) {
    const Shape a = ConvexHull(verticesInWorld(c, "verts1", "size1", "X1"));
    const Shape b = ConvexHull(verticesInWorld(c, "verts2", "size2", "X2"));
    cases.push_back({{c["name"], a, b, Isometry3d::Identity()}, c["expected_signed_distance"]});
  }
  return cases;
}

/// The box pairs as boxes, with the relative pose that the two world poses give in double, as the nearest rotation.
std::vector<StressCase> boxCases() {
  std::vector<StressCase> cases;
  const json file = casesIn("../shared/cases/stress_cases.json");
  for (const json& c : file) {
    if (c["type"] != "box-box") continue;
    const Isometry3d a_T_b = rigidPose(poseFrom(c["X1"]).inverse(Eigen::Isometry) * poseFrom(c["X2"])).value();
    cases.push_back(
        {{c["name"], Box{vectorFrom(c["size1"])}, Box{vectorFrom(c["size2"])}, a_T_b}, c["expected_signed_distance"]});
  }
  return cases;
}

#define SKIP_WITHOUT(cases) \
  if ((cases).empty()) GTEST_SKIP() << "no ../shared/cases/stress_cases.json beside the sources"

PairCase swapped(const PairCase& c) { return {c.name + " swapped", c.b, c.a, c.a_T_b.inverse()}; }

/// The expected distance is of unrounded vertices; rounding them moves each by half a unit of its last digit, and the
/// query adds its own rounding: 1e-14 of the size holds both with room.
double allowedError(const ShapePair& pair) { return 1e-14 * pair.scale(); }

/// Asked for that much: the default would allow 1e-9 m.
SignedDistance exactly(const PairCase& c) {
  Options options;
  options.distance_tolerance = allowedError(c.pair());
  return signedDistance(c.a, c.b, c.a_T_b, options);
}

TEST(StressCases, OracleKnowsTheirDistance) {
  const std::vector<StressCase> cases = hullCases();
  SKIP_WITHOUT(cases);
  for (const StressCase& c : cases) {
    const Truth truth = signedDistanceOracle(c.pair());
    EXPECT_NEAR(static_cast<double>(truth.distance), c.expected, 4e-16 * c.pair().scale()) << c.name;
  }
}

TEST(StressCases, DistanceOfHullsIsTheExpectedOneInEitherOrder) {
  const std::vector<StressCase> cases = hullCases();
  SKIP_WITHOUT(cases);
  for (const StressCase& c : cases)
    for (const PairCase& order : {PairCase(c), swapped(c)}) {
      EXPECT_NEAR(exactly(order).distance, c.expected, allowedError(c.pair())) << c.name;
      EXPECT_NEAR(signedDistance(order.a, order.b, order.a_T_b).distance, c.expected, 1e-9) << c.name;
    }
}

TEST(StressCases, DistanceIsExactForBoxes) {
  const std::vector<StressCase> cases = boxCases();
  SKIP_WITHOUT(cases);
  for (const StressCase& c : cases)
    EXPECT_LE(errorOf(exactly(c), signedDistanceOracle(c.pair())), allowedError(c.pair())) << c.name;
}

TEST(StressCases, DistanceOfBoxesIsTheExpectedOneWithinTheirPoses) {
  // A pose of ten digits is a rotation within 1e-9 only; the expected value takes it as it is, a box cannot.
  const std::vector<StressCase> cases = boxCases();
  SKIP_WITHOUT(cases);
  for (const StressCase& c : cases)
    EXPECT_NEAR(signedDistance(c.a, c.b, c.a_T_b).distance, c.expected, 1e-9 * c.pair().scale()) << c.name;
}

TEST(StressCases, EveryCaseConvergesAndKeepsEveryPromise) {
  std::vector<StressCase> cases = hullCases();
  SKIP_WITHOUT(cases);
  for (const StressCase& c : boxCases()) cases.push_back(c);
  for (const StressCase& c : cases) {
    const Observation seen = observe({c.a, c.b, c.a_T_b, {}, {}});
    EXPECT_EQ(seen.result.status, Status::Converged) << describe(c);
    EXPECT_FALSE(seen.failure) << seen.failure->sentence << " " << describe(c);
  }
}

TEST(StressCases, RigidMotionKeepsTheDistance) {
  const std::vector<StressCase> cases = hullCases();
  SKIP_WITHOUT(cases);
  Chance random(1);
  for (const StressCase& c : cases)
    for (const double reach : {0.0, 1.0, 100.0, 1e4, 1e6})
      for (int i = 0; i < 20; ++i) {
        const Isometry3d motion = randomPose(random, reach);
        std::vector<Vector3d> a, b;
        for (const Vector3d& vertex : c.a.hull().vertices()) a.push_back(motion * vertex);
        for (const Vector3d& vertex : c.b.hull().vertices()) b.push_back(motion * vertex);
        const PairCase moved{c.name, ConvexHull(a), ConvexHull(b), Isometry3d::Identity()};
        EXPECT_NEAR(exactly(moved).distance, c.expected, allowedError(moved.pair())) << describe(moved);
      }
}

}  // namespace proximity_server::narrowphase::stress_cases_test
