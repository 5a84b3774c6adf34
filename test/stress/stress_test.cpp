// The run of ./dev stress that every test run makes; and that its checks can fail at all.
#include <gtest/gtest.h>

#include <thread>

#include "narrowphase/certificate.h"
#include "stress/run.h"

namespace proximity_server {
namespace {

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

TEST(Stress, AMillionPairsKeepEveryPromise) {
  for (const FamilySummary& family : summariesOf(aRun(1000000, std::max(1u, std::thread::hardware_concurrency())))) {
    EXPECT_GT(family.pairs_with_oracle, 0) << family.name;
    EXPECT_EQ(family.failed, 0) << family.name << ": " << family.failures.front().failure.sentence
                                << "\n./dev stress records it";
  }
}

TEST(Stress, PairsDoNotDependOnTheThreads) {
  const std::vector<FamilySummary> one = summariesOf(aRun(3000, 1)), three = summariesOf(aRun(3000, 3));
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

TEST(Stress, ShearedPoseIsFound) {
  // A pose that is no rotation turns distances into something else: the relatives must disagree.
  Eigen::Isometry3d sheared = Eigen::Isometry3d::Identity();
  sheared.matrix()(0, 1) = 0.1;
  sheared.translation() = Eigen::Vector3d(0.5, 1.5, 0.2);
  EXPECT_TRUE(observe({Box{{1, 1, 1}}, Cylinder{0.4, 1}, sheared, {}, {}}).failure);
}

}  // namespace
}  // namespace proximity_server
