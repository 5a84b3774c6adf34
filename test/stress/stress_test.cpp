// The part of ./dev stress that every test run makes; that its checks can fail at all; and the pairs that were once
// wrong.
#include "laws/pair_laws.h"
#include "narrowphase/certificate.h"
#include "narrowphase/from_json.h"
#include "proximity_server/narrowphase/signed_distance.h"
#include "stress/campaign_test.h"
#include "stress/recorded.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <fstream>
#include <limits>
#include <set>
#include <string>

namespace proximity_server::narrowphase::stress_test {

using Eigen::Isometry3d;
using Eigen::Vector3d;

/// Families of which every pair converges; of each other one a few in a million do not.
const std::set<std::string> kConverging = {"all shape pairs", "boxes of every size",          "far in the world",
                                           "far apart",       "vertices far from the origin", "boxes off by an ulp",
                                           "large hulls"};

TEST(Stress, PairsOfEveryFamilyKeepEveryPromise) {
  for (const stress::Tally& family :
       stress::expectNoFailure(stress::pairCampaign(), "PROXIMITY_STRESS_PAIRS", repeats(200000))) {
    EXPECT_GT(family["with_oracle"], 0) << family.family;
    if (kConverging.count(family.family) > 0) {
      EXPECT_EQ(family["not_converged"], 0) << family.family;
    }
  }
}

TEST(Stress, PairsDoNotDependOnTheThreads) {
  stress::expectIndependenceOfThreads(stress::pairCampaign(), kIsSanitized ? 600 : 3000,
                                      {"pairs", "worst_gap", "most_iterations"});
}

TEST(Stress, FamiliesHoldPairsApartAndInOverlap) {
  int apart = 0, overlapping = 0;
  for (std::size_t family = 0; family < stressFamilies().size(); ++family)
    for (const StressPair& p : stressBlock(family, /*seed=*/5, /*block=*/0))
      ++(signedDistance(p.a, p.b, p.a_T_b).distance > 0.0 ? apart : overlapping);
  EXPECT_GT(apart, 200);
  EXPECT_GT(overlapping, 200);
}

TEST(Stress, ForgedResultsAreFound) {
  const Shape a = Box{{1, 1, 1}}, b = Cylinder{0.4, 1};
  const Isometry3d a_T_b = Isometry3d(Eigen::Translation3d(0.5, 1.5, 0.2));
  const ShapePair pair{a, b, a_T_b};
  const SignedDistance honest = signedDistance(a, b, a_T_b);
  ASSERT_TRUE(carriesItsProof(pair, honest));

  SignedDistance forged = honest;
  forged.lower_bound += 1e-6;
  EXPECT_FALSE(carriesItsProof(pair, forged));
  forged = honest;
  forged.normal = -honest.normal;
  EXPECT_FALSE(carriesItsProof(pair, forged));
  forged = honest;
  forged.point_a += 1e-6 * honest.normal;
  EXPECT_FALSE(carriesItsProof(pair, forged));
}

/// Returns a sentence of failure; empty if every promise is kept.
std::string failureOf(const StressPair& pair) {
  const Observation seen = observeWithOracle(pair);
  return seen.failure ? seen.failure->sentence : "";
}

TEST(RecordedPairs, AreThere) { EXPECT_GE(readRecordedPairs().size(), 169u); }

TEST(RecordedPairs, KeepEveryPromise) {
  for (const RecordedPair& recorded : readRecordedPairs()) EXPECT_EQ(failureOf(recorded.pair), "") << recorded.name;
}

TEST(RecordedPairs, KeepEveryPromiseSwapped) {
  for (const RecordedPair& recorded : readRecordedPairs()) {
    StressPair swapped = recorded.pair;
    std::swap(swapped.a, swapped.b);
    swapped.a_T_b = recorded.pair.a_T_b.inverse(Eigen::Affine);
    swapped.warm_start = {};
    EXPECT_EQ(failureOf(swapped), "") << recorded.name;
  }
}

TEST(RecordedPairs, ExpectedDistanceIsThatOfTheOracleAndOfTheLibrary) {
  for (const RecordedPair& recorded : readRecordedPairs()) {
    if (!recorded.expected) continue;
    const StressPair& p = recorded.pair;
    const Truth truth = signedDistanceOracle(p.pair());
    EXPECT_GE(*recorded.expected, static_cast<double>(truth.distance) - 1e-16) << recorded.name;
    EXPECT_LE(*recorded.expected, static_cast<double>(truth.distance + truth.error_bound) + 1e-16) << recorded.name;
    const SignedDistance result = signedDistance(p.a, p.b, p.a_T_b);
    EXPECT_NEAR(result.distance, *recorded.expected, 1e-9) << recorded.name;
    EXPECT_TRUE(enclosesTruth(p.pair(), result, Truth{*recorded.expected, 1e-16L, Vector3l::UnitX()})) << recorded.name;
  }
}

TEST(RecordedPairs, ConvergeWithinTheIterationsPromisedAndSwapped) {
  int promised = 0;
  for (const RecordedPair& recorded : readRecordedPairs()) {
    if (!recorded.most_iterations) continue;
    const StressPair& p = recorded.pair;
    const SignedDistance result = signedDistance(p.a, p.b, p.a_T_b);
    EXPECT_EQ(result.status, Status::Converged) << recorded.name;
    EXPECT_LE(result.iterations, *recorded.most_iterations) << recorded.name;
    EXPECT_EQ(signedDistance(p.b, p.a, p.a_T_b.inverse()).status, Status::Converged) << recorded.name << ", swapped";
    ++promised;
  }
  EXPECT_GE(promised, 42);
}

/// Returns how far [m] a hull falls short of the points that it was made of, in the directions between them.
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

TEST(RecordedPairs, HullsReachAsFarAsTheirPoints) {
  // The points as they were recorded: a hull keeps only its vertices.
  std::ifstream file(PROXIMITY_SOURCE_DIR "/test/data/recorded_pairs.jsonl");
  int clouds = 0;
  for (std::string line; std::getline(file, line);) {
    const nlohmann::json j = nlohmann::json::parse(line);
    for (const char* name : {"a", "b"}) {
      if (!j[name].contains("vertices")) continue;
      std::vector<Vector3d> points;
      double largest = 0.0;
      for (const nlohmann::json& point : j[name]["vertices"]) {
        points.push_back(vectorFrom(point));
        largest = std::max(largest, points.back().cwiseAbs().maxCoeff());
      }
      EXPECT_LE(lostReach(points), 3e-14 * largest) << j["name"] << ", " << name;
      ++clouds;
    }
  }
  EXPECT_GT(clouds, 50);
}

TEST(RecordedPairs, LinesKeepEveryDigit) {
  const double infinity = std::numeric_limits<double>::infinity();
  const StressPair pair{Shape(Cone{0.1, 0.3}).padded(0.7),
                        ConvexHull({{0.1, 0.2, 0.3}}),
                        Isometry3d(Eigen::Translation3d(0.1, 1.0 / 3.0, 1e-300)),
                        Options::above(1.0 / 7.0),
                        {Vector3d(infinity, -infinity, 0.1), {{{-1, 7}}}, 1}};
  const StressPair read = pairFromJsonLine(toJsonLine(RecordedPair{"line", pair, {}, {}})).pair;
  EXPECT_EQ(read.a.halfExtents(), pair.a.halfExtents());
  EXPECT_EQ(read.a.margin(), pair.a.margin());
  EXPECT_EQ(read.b.hull().vertices(), pair.b.hull().vertices());
  EXPECT_EQ(read.a_T_b.matrix(), pair.a_T_b.matrix());
  EXPECT_EQ(read.options.stop_above, pair.options.stop_above);
  EXPECT_EQ(read.warm_start.axis, pair.warm_start.axis);
  EXPECT_EQ(read.warm_start.simplex[0].a, -1);
}

}  // namespace proximity_server::narrowphase::stress_test
