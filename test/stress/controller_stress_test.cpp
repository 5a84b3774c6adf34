// The runs of ./dev stress drives, free-motions and stops that every test run makes.
#include <gtest/gtest.h>

#include <algorithm>
#include <thread>

#include "from_environment.h"
#include "sanitized.h"
#include "stress/drive_run.h"
#include "stress/free_motion_run.h"
#include "stress/stop_run.h"

namespace proximity_server::scene::controller_stress_test {

TEST(FreeMotionStress, NoMotionWithinABubbleLeadsBelowTheThreshold) {
  FreeMotionRun run;
  run.motions = fromEnvironment("PROXIMITY_STRESS_FREE_MOTIONS", kIsSanitized ? 400 : repeats(50000));
  run.threads = std::max(1u, std::thread::hardware_concurrency());
  std::atomic<std::int64_t> done{0};
  double most_used = 0.0;
  for (const FreeMotionSummary& family : runFreeMotions(run, done)) {
    EXPECT_EQ(family.failed, 0) << family.name << ", cell " << family.failures.front().number << ": "
                                << family.failures.front().sentence;
    EXPECT_GT(family.motions, 0) << family.name;
    if (kIsSanitized) continue;  // what follows is of the whole test
    EXPECT_GT(family.of_scenes, 0) << family.name;
    EXPECT_GT(family.most_used, 0.5) << family.name;
    most_used = std::max(most_used, family.most_used);
  }
  if (!kIsSanitized) {
    EXPECT_GT(most_used, 0.99) << "a motion needs nearly all that is free";
  }
}

TEST(StopStress, NoStopEndsTooNearAndNoRetreatIsSlowed) {
  StopRun run;
  run.stops = fromEnvironment("PROXIMITY_STRESS_STOPS", repeats(2000));
  run.threads = std::max(1u, std::thread::hardware_concurrency());
  std::atomic<std::int64_t> done{0};
  StopSummary all;
  for (const StopSummary& family : runStops(run, done)) {
    EXPECT_EQ(family.failed, 0) << family.name << ", cell " << family.failures.front().number << ": "
                                << family.failures.front().sentence;
    EXPECT_GT(family.stops, 0) << family.name;
    all.merge(family);
    if (kIsSanitized) continue;  // what follows is of the whole test
    EXPECT_LE(20 * family.unneeded, family.retreats) << family.name;
  }
  if (kIsSanitized) return;
  EXPECT_GT(20 * all.slowed, all.stops);
  EXPECT_GT(20 * all.retreats, all.stops);
  EXPECT_GT(20 * all.halted, all.stops);
  EXPECT_LT(2 * all.halted, all.stops);
}

TEST(DriveStress, RobotsKeepTheirDistanceAndNeitherRaceNorTrembleNorRestWithoutACause) {
  DriveRun run;
  run.drives = fromEnvironment("PROXIMITY_STRESS_DRIVES", repeats(12));
  run.threads = std::max(1u, std::thread::hardware_concurrency());
  run.duration = 8.0;
  std::atomic<std::int64_t> done{0};
  DriveSummary all;
  for (const DriveSummary& family : runDrives(run, done)) {
    EXPECT_EQ(family.failed, 0) << family.name << ", cell " << family.failures.front().number << ": "
                                << family.failures.front().sentence;
    EXPECT_GT(family.drives, 0) << family.name;
    all.merge(family);
  }
  EXPECT_LE(all.fastest, 1.0 + 1e-9);
  if (kIsSanitized) return;  // what follows is of the whole test
  EXPECT_LT(all.nearest, 0.004) << "some pair came near";
}

}  // namespace proximity_server::scene::controller_stress_test
