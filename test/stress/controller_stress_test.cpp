// The part of ./dev stress drives, free-motions, people and stops that every test run makes.
#include "stress/campaign_test.h"

namespace proximity_server::stress::controller_stress_test {

TEST(FreeMotionStress, NoMotionWithinABubbleLeadsBelowTheThreshold) {
  const std::vector<Tally> families =
      expectNoFailure(freeMotionCampaign(), "PROXIMITY_STRESS_FREE_MOTIONS", kIsSanitized ? 400 : repeats(50000));
  if (kIsSanitized) return;  // what follows is of the whole test
  for (const Tally& family : families) {
    EXPECT_GT(family["of_scenes"], 0) << family.family;
    EXPECT_GT(family["most_used"], 0.5) << family.family;
  }
  EXPECT_GT(sumOf(families)["most_used"], 0.99) << "a motion needs nearly all that is free";
}

TEST(StopStress, NoStopEndsTooNearAndNoRetreatIsSlowed) {
  const std::vector<Tally> families = expectNoFailure(stopCampaign(), "PROXIMITY_STRESS_STOPS", repeats(2000));
  if (kIsSanitized) return;  // what follows is of the whole test
  for (const Tally& family : families) EXPECT_LE(20 * family["unneeded"], family["retreats"]) << family.family;
  const Tally all = sumOf(families);
  EXPECT_GT(sumOf(families)["coupled"], repeats(100)) << "inequalities slow some";
  for (const char* number : {"slowed", "retreats", "halted"}) EXPECT_GT(20 * all[number], all["stops"]) << number;
  EXPECT_LT(2 * all["halted"], all["stops"]);
}

TEST(PeopleStress, NobodyReachesARobotBeforeItStands) {
  const Tally all = sumOf(expectNoFailure(peopleCampaign(), "PROXIMITY_STRESS_PEOPLE", repeats(2000)));
  if (kIsSanitized) return;  // what follows is of the whole test
  for (const char* number : {"slowed", "halted", "retreats"}) EXPECT_GT(20 * all[number], all["people"]) << number;
  EXPECT_LE(20 * all["unneeded"], all["retreats"]);
  EXPECT_GT(4 * all["met"], 3 * all["doubled"]) << "at twice the scale";
}

TEST(DriveStress, RobotsKeepTheirDistanceAndNeitherRaceNorTrembleNorRestWithoutACause) {
  const Tally all = sumOf(expectNoFailure(driveCampaign(/*duration=*/8.0), "PROXIMITY_STRESS_DRIVES", repeats(12)));
  EXPECT_LE(all["fastest"], 1.0 + 1e-9);
  if (kIsSanitized) return;  // what follows is of the whole test
  EXPECT_EQ(all.numbers().count("nearest"), 1u) << "some pair came near";
  EXPECT_LT(all["nearest"], 0.004);
}

}  // namespace proximity_server::stress::controller_stress_test
