// The part of ./dev stress clouds that every test run makes.
#include "sanitized.h"
#include "stress/campaign_test.h"

#include <gtest/gtest.h>

#include <vector>

namespace proximity_server::scene::cloud_stress_test {

TEST(CloudStress, FilterAndVoxelsKeepEveryPromise) {
  const std::vector<stress::Tally> tallies =
      stress::expectNoFailure(stress::cloudCampaign(), "PROXIMITY_STRESS_CLOUDS", repeats(kIsSanitized ? 60 : 400));
  if (kIsSanitized) return;  // what follows is of the whole test
  const stress::Tally all = stress::sumOf(tallies);
  EXPECT_GT(all["removed"], all["points"] / 10);
  EXPECT_LT(all["removed"], 0.9 * all["points"]);
  for (const char* number : {"at padding", "overlaps", "below", "clear"}) EXPECT_GT(all[number], 0) << number;
}

}  // namespace proximity_server::scene::cloud_stress_test
