// The run of ./dev stress that every test run makes; and that its checks can fail at all.
#include <gtest/gtest.h>

#include <thread>

#include "from_environment.h"
#include "narrowphase/certificate.h"
#include "proximity_server/narrowphase/signed_distance.h"
#include "sanitized.h"
#include "stress/run.h"

namespace proximity_server::narrowphase::stress_test {

StressRun aRun(std::int64_t pairs, unsigned threads) {
  StressRun run;
  run.pairs = pairs;
  run.threads = threads;
  return run;
}

std::vector<FamilySummary> summariesOf(const StressRun& run) {
  std::atomic<std::int64_t> done{0};
  return runStress(run, done);
}

TEST(Stress, PairsOfEveryFamilyKeepEveryPromise) {
  const std::int64_t pairs = fromEnvironment("PROXIMITY_STRESS_PAIRS", repeats(200000));
  for (const FamilySummary& family : summariesOf(aRun(pairs, std::max(1u, std::thread::hardware_concurrency())))) {
    EXPECT_GT(family.pairs_with_oracle, 0) << family.name;
    EXPECT_EQ(family.failed, 0) << family.name << ": " << family.failures.front().failure.sentence
                                << "\n./dev stress records it";
  }
}

TEST(Stress, PairsDoNotDependOnTheThreads) {
  const int pairs = kIsSanitized ? 600 : 3000;
  const std::vector<FamilySummary> one = summariesOf(aRun(pairs, 1)), three = summariesOf(aRun(pairs, 3));
  for (std::size_t i = 0; i < one.size(); ++i) {
    EXPECT_EQ(one[i].pairs, three[i].pairs);
    EXPECT_EQ(one[i].worst_gap, three[i].worst_gap);
    EXPECT_EQ(one[i].most_iterations, three[i].most_iterations);
  }
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
  Eigen::Isometry3d a_T_b = Eigen::Isometry3d::Identity();
  a_T_b.translation() = Eigen::Vector3d(0.5, 1.5, 0.2);
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

}  // namespace proximity_server::narrowphase::stress_test
