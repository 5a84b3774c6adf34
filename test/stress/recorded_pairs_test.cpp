// Every pair that was once wrong, asked again and checked in full.
#include "stress/recorded_pairs.h"

#include <gtest/gtest.h>

#include <limits>

#include "narrowphase/certificate.h"
#include "proximity_server/narrowphase/signed_distance.h"
#include "stress/checks.h"

namespace proximity_server::narrowphase {
namespace {

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

TEST(RecordedPairs, AreThere) { EXPECT_GE(recordedPairs().size(), 13u); }

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

TEST(RecordedPairs, LinesKeepEveryDigit) {
  const double infinity = std::numeric_limits<double>::infinity();
  Isometry3d pose = Isometry3d::Identity();
  pose.translation() = Vector3d(0.1, 1.0 / 3.0, 1e-300);
  const StressPair pair{Shape(Cone{0.1, 0.3}).padded(0.7),
                        ConvexHull({{0.1, 0.2, 0.3}}),
                        pose,
                        Options::above(1.0 / 7.0),
                        {Vector3d(infinity, -infinity, 0.1), -1, 7}};
  const StressPair read = fromJsonLine(toJsonLine({"line", pair, {}})).pair;
  EXPECT_EQ(read.a.halfExtents(), pair.a.halfExtents());
  EXPECT_EQ(read.a.margin(), pair.a.margin());
  EXPECT_EQ(read.b.hull().vertices(), pair.b.hull().vertices());
  EXPECT_EQ(read.a_T_b.matrix(), pair.a_T_b.matrix());
  EXPECT_EQ(read.options.stop_above, pair.options.stop_above);
  EXPECT_EQ(read.warm_start.axis, pair.warm_start.axis);
  EXPECT_EQ(read.warm_start.vertex_a, -1);
}

}  // namespace
}  // namespace proximity_server::narrowphase
