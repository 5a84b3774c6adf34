// The run of ./dev stress motions that every test run makes; and that its checks can fail at all.
#include <gtest/gtest.h>

#include <thread>

#include "from_environment.h"
#include "sanitized.h"
#include "stress/motion_run.h"
#include "stress/recorded_motions.h"

namespace proximity_server::narrowphase::motion_stress_test {

std::vector<MotionFamilySummary> summariesOf(std::int64_t motions, unsigned threads) {
  MotionRun run;
  run.motions = motions;
  run.threads = threads;
  std::atomic<std::int64_t> done{0};
  return runMotions(run, done);
}

TEST(MotionStress, MotionsOfEveryFamilyKeepEveryPromise) {
  const std::int64_t motions = fromEnvironment("PROXIMITY_STRESS_MOTIONS", repeats(5000));
  for (const MotionFamilySummary& family : summariesOf(motions, std::max(1u, std::thread::hardware_concurrency()))) {
    EXPECT_GT(family.with_oracle, 0) << family.name;
    EXPECT_TRUE(kIsSanitized || family.contacts > 0) << family.name;
    EXPECT_TRUE(kIsSanitized || family.contacts < family.motions) << family.name;
    EXPECT_EQ(family.failed, 0) << family.name << ", motion " << family.failures.front().number << ": "
                                << family.failures.front().sentence << "\n./dev stress motions records it";
  }
}

TEST(MotionStress, MotionsDoNotDependOnTheThreads) {
  const int motions = kIsSanitized ? 60 : 300;
  const std::vector<MotionFamilySummary> one = summariesOf(motions, 1), three = summariesOf(motions, 3);
  for (std::size_t i = 0; i < one.size(); ++i) {
    EXPECT_EQ(one[i].motions, three[i].motions);
    EXPECT_EQ(one[i].contacts, three[i].contacts);
    EXPECT_EQ(one[i].contact_queries, three[i].contact_queries);
    EXPECT_EQ(one[i].minimum_queries, three[i].minimum_queries);
  }
}

TEST(MotionStress, MotionIsTheSameAfterItWasWrittenAndRead) {
  for (std::size_t family = 0; family < motionFamilies().size(); ++family) {
    const StressMotion motion = stressMotion(family, /*seed=*/3, /*number=*/4);
    const StressMotion read = motionFromJsonLine(toJsonLine({"", motion})).motion;
    EXPECT_EQ(toJsonLine({"", read}), toJsonLine({"", motion}));
    EXPECT_EQ(observeMotion(read).contact.t_free, observeMotion(motion).contact.t_free);
  }
}

TEST(MotionStress, RecordedMotionsKeepEveryPromise) {
  const std::string path = std::string(PROXIMITY_SOURCE_DIR) + "/test/data/recorded_motions.jsonl";
  for (const RecordedMotion& recorded : readRecordedMotions(path)) {
    const MotionObservation seen = observeMotionWithOracle(recorded.motion);
    EXPECT_FALSE(seen.failure) << recorded.name << ": " << *seen.failure;
  }
}

/// A ball that falls through a plate of 1e-6 m at 0.45.
StressMotion fallingBall() {
  ScrewMotion fall;
  fall.start.translation().z() = 1.0 + 0.1 + 0.5e-6;
  fall.linear.z() = -1.0 / 0.45;
  return {Box{{1, 1, 1e-6}}, {}, Sphere{0.1}, {fall}, {}, {}};
}

TEST(MotionStress, ForgedContactsAreFound) {
  const StressMotion m = fallingBall();
  const TimeOfContact honest = timeOfContact(m.a, m.a_motion, m.b, m.b_motion, m.options);
  const MinimumOverMotion minimum = minimumDistance(m.a, m.a_motion, m.b, m.b_motion);
  ASSERT_TRUE(honest.contact);
  ASSERT_FALSE(brokenPromise(m, honest, minimum)) << *brokenPromise(m, honest, minimum);

  TimeOfContact late = honest;
  late.t_free = late.t_contact = honest.t_contact + 1e-9;
  EXPECT_TRUE(brokenPromise(m, late, minimum));
  TimeOfContact missed;
  missed.status = Status::Converged;
  missed.t_free = 1.0;
  EXPECT_TRUE(brokenPromise(m, missed, minimum));
  TimeOfContact early = honest;
  early.t_free = early.t_contact = honest.t_contact - 1e-8;
  EXPECT_TRUE(brokenPromise(m, early, minimum));
  TimeOfContact elsewhere = honest;
  elsewhere.at_contact.point_a.x() += 1e-6;
  EXPECT_TRUE(brokenPromise(m, elsewhere, minimum));
}

TEST(MotionStress, ForgedMinimaAreFound) {
  const StressMotion m = fallingBall();
  const TimeOfContact contact = timeOfContact(m.a, m.a_motion, m.b, m.b_motion, m.options);
  const MinimumOverMotion honest = minimumDistance(m.a, m.a_motion, m.b, m.b_motion);
  ASSERT_FALSE(brokenPromise(m, contact, honest));

  MinimumOverMotion forged = honest;
  forged.lower_bound += 1e-8;
  forged.upper_bound += 1e-8;
  EXPECT_TRUE(brokenPromise(m, contact, forged));
  forged = honest;
  forged.upper_bound -= 1e-8;
  EXPECT_TRUE(brokenPromise(m, contact, forged));
  forged = honest;
  forged.time += 1e-6;
  EXPECT_TRUE(brokenPromise(m, contact, forged));
}

}  // namespace proximity_server::narrowphase::motion_stress_test
