// Every pair that was once wrong, asked again and checked in full.
#include "stress/recorded_pairs.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>

#include "narrowphase/certificate.h"
#include "narrowphase/from_json.h"
#include "proximity_server/narrowphase/signed_distance.h"
#include "stress/checks.h"

namespace proximity_server::narrowphase::recorded_pairs_test {

using Eigen::Isometry3d;
using Eigen::Vector3d;

std::vector<RecordedPair> recordedPairs() {
  return readRecordedPairs(std::string(PROXIMITY_SOURCE_DIR) + "/test/data/recorded_pairs.jsonl");
}

/// A sentence of failure; empty if every promise is kept.
std::string failureOf(const StressPair& pair) {
  const Observation seen = observeWithOracle(pair);
  return seen.failure ? seen.failure->sentence : "";
}

TEST(RecordedPairs, AreThere) { EXPECT_GE(recordedPairs().size(), 169u); }

TEST(RecordedPairs, KeepEveryPromise) {
  for (const RecordedPair& recorded : recordedPairs()) EXPECT_EQ(failureOf(recorded.pair), "") << recorded.name;
}

TEST(RecordedPairs, KeepEveryPromiseSwapped) {
  for (const RecordedPair& recorded : recordedPairs()) {
    StressPair swapped = recorded.pair;
    std::swap(swapped.a, swapped.b);
    swapped.a_T_b = recorded.pair.a_T_b.inverse(Eigen::Affine);
    swapped.warm_start = {};
    EXPECT_EQ(failureOf(swapped), "") << recorded.name;
  }
}

/// [m] How far a hull falls short of the points that it was made of, in the directions between them.
double lostReach(const std::vector<Vector3d>& points) {
  const ConvexHull hull(points);
  double lost = 0.0;
  for (const Vector3d& p : points)
    for (const Vector3d& q : points) {
      if (p == q) continue;
      const Vector3d direction = (p - q).normalized();
      double reach = -std::numeric_limits<double>::infinity();
      for (const Vector3d& vertex : hull.vertices()) reach = std::max(reach, direction.dot(vertex - p));
      lost = std::max(lost, -reach);
    }
  return lost;
}

double largestCoordinate(const std::vector<Vector3d>& points) {
  double largest = 0.0;
  for (const Vector3d& p : points) largest = std::max(largest, p.cwiseAbs().maxCoeff());
  return largest;
}

TEST(RecordedPairs, HullsReachAsFarAsTheirPoints) {
  std::ifstream file(std::string(PROXIMITY_SOURCE_DIR) + "/test/data/recorded_pairs.jsonl");
  int clouds = 0;
  for (std::string line; std::getline(file, line);) {
    const nlohmann::json j = nlohmann::json::parse(line);
    for (const char* name : {"a", "b"}) {
      if (!j[name].contains("vertices")) continue;
      std::vector<Vector3d> points;
      for (const nlohmann::json& point : j[name]["vertices"]) points.push_back(vectorFrom(point));
      EXPECT_LE(lostReach(points), 3e-14 * largestCoordinate(points)) << j["name"] << ", " << name;
      ++clouds;
    }
  }
  EXPECT_GT(clouds, 50);
}

TEST(RecordedPairs, OracleKnowsTheExpectedDistance) {
  for (const RecordedPair& recorded : recordedPairs()) {
    if (!recorded.expected) continue;
    const Truth truth = signedDistanceOracle(recorded.pair.pair());
    EXPECT_GE(*recorded.expected, static_cast<double>(truth.distance) - 1e-16) << recorded.name;
    EXPECT_LE(*recorded.expected, static_cast<double>(truth.distance + truth.error_bound) + 1e-16) << recorded.name;
  }
}

TEST(RecordedPairs, ExpectedDistanceIsMetWithinTheTolerance) {
  for (const RecordedPair& recorded : recordedPairs()) {
    if (!recorded.expected) continue;
    const StressPair& p = recorded.pair;
    EXPECT_NEAR(signedDistance(p.a, p.b, p.a_T_b).distance, *recorded.expected, 1e-9) << recorded.name;
  }
}

TEST(RecordedPairs, ExpectedDistanceLiesInTheBounds) {
  for (const RecordedPair& recorded : recordedPairs()) {
    if (!recorded.expected) continue;
    const StressPair& p = recorded.pair;
    const Truth expected{*recorded.expected, 1e-16L, Vector3l::UnitX()};
    EXPECT_TRUE(enclosesTruth(p.pair(), signedDistance(p.a, p.b, p.a_T_b), expected)) << recorded.name;
  }
}

TEST(RecordedPairs, ConvergeWithinTheIterationsPromised) {
  int promised = 0;
  for (const RecordedPair& recorded : recordedPairs()) {
    if (!recorded.most_iterations) continue;
    const StressPair& p = recorded.pair;
    const SignedDistance result = signedDistance(p.a, p.b, p.a_T_b);
    EXPECT_EQ(result.status, Status::Converged) << recorded.name;
    EXPECT_LE(result.iterations, *recorded.most_iterations) << recorded.name;
    ++promised;
  }
  EXPECT_GE(promised, 42);
}

TEST(RecordedPairs, ConvergeSwappedWhereTheIterationsArePromised) {
  for (const RecordedPair& recorded : recordedPairs()) {
    if (!recorded.most_iterations) continue;
    const StressPair& p = recorded.pair;
    EXPECT_EQ(signedDistance(p.b, p.a, p.a_T_b.inverse()).status, Status::Converged) << recorded.name;
  }
}

TEST(RecordedPairs, LinesKeepEveryDigit) {
  const double infinity = std::numeric_limits<double>::infinity();
  Isometry3d pose = Isometry3d::Identity();
  pose.translation() = Vector3d(0.1, 1.0 / 3.0, 1e-300);
  const StressPair pair{Shape(Cone{0.1, 0.3}).padded(0.7),
                        ConvexHull({{0.1, 0.2, 0.3}}),
                        pose,
                        Options::above(1.0 / 7.0),
                        {Vector3d(infinity, -infinity, 0.1), {{{-1, 7}}}, 1}};
  const StressPair read = fromJsonLine(toJsonLine({"line", pair, {}, {}})).pair;
  EXPECT_EQ(read.a.halfExtents(), pair.a.halfExtents());
  EXPECT_EQ(read.a.margin(), pair.a.margin());
  EXPECT_EQ(read.b.hull().vertices(), pair.b.hull().vertices());
  EXPECT_EQ(read.a_T_b.matrix(), pair.a_T_b.matrix());
  EXPECT_EQ(read.options.stop_above, pair.options.stop_above);
  EXPECT_EQ(read.warm_start.axis, pair.warm_start.axis);
  EXPECT_EQ(read.warm_start.simplex[0].a, -1);
}

}  // namespace proximity_server::narrowphase::recorded_pairs_test
