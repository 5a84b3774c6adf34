// The part of ./dev stress motions that every test run makes; that its checks can fail at all; and the motions that
// were once wrong.
#include "stress/campaign_test.h"
#include "stress/motion_checks.h"
#include "stress/recorded.h"

#include <functional>

namespace proximity_server::narrowphase::motion_stress_test {

TEST(MotionStress, MotionsOfEveryFamilyKeepEveryPromise) {
  for (const stress::Tally& family :
       stress::expectNoFailure(stress::motionCampaign(), "PROXIMITY_STRESS_MOTIONS", repeats(5000))) {
    EXPECT_GT(family["with_oracle"], 0) << family.family;
    EXPECT_TRUE(kIsSanitized || family["contacts"] > 0) << family.family;
    EXPECT_TRUE(kIsSanitized || family["contacts"] < family["motions"]) << family.family;
  }
}

TEST(MotionStress, MotionsDoNotDependOnTheThreads) {
  stress::expectIndependenceOfThreads(stress::motionCampaign(), kIsSanitized ? 60 : 300,
                                      {"motions", "contacts", "contact_queries", "minimum_queries"});
}

TEST(MotionStress, MotionIsTheSameAfterItWasWrittenAndRead) {
  for (std::size_t family = 0; family < motionFamilies().size(); ++family) {
    const StressMotion motion = stressMotion(family, /*seed=*/3, /*number=*/4);
    const StressMotion read = motionFromJsonLine(toJsonLine(RecordedMotion{"", motion})).motion;
    EXPECT_EQ(toJsonLine(RecordedMotion{"", read}), toJsonLine(RecordedMotion{"", motion}));
    EXPECT_EQ(observeMotion(read).contact.t_free, observeMotion(motion).contact.t_free);
  }
}

TEST(MotionStress, RecordedMotionsKeepEveryPromise) {
  EXPECT_GE(readRecordedMotions().size(), 3u);
  for (const RecordedMotion& recorded : readRecordedMotions()) {
    const MotionObservation seen = observeMotionWithOracle(recorded.motion);
    EXPECT_FALSE(seen.failure) << recorded.name << ": " << *seen.failure;
  }
}

/// The answers about a ball that falls through a plate of 1e-6 m at 0.45.
class ForgedAnswers : public testing::Test {
 protected:
  static StressMotion fallingBall() {
    ScrewMotion fall;
    fall.start.translation().z() = 1.0 + 0.1 + 0.5e-6;
    fall.linear.z() = -1.0 / 0.45;
    return {Box{{1, 1, 1e-6}}, {}, Sphere{0.1}, {fall}, {}, {}};
  }

  void SetUp() override {
    ASSERT_TRUE(contact_.contact);
    ASSERT_FALSE(brokenPromise(motion_, contact_, minimum_)) << *brokenPromise(motion_, contact_, minimum_);
  }

  void expectFound(const std::function<void(TimeOfContact&, MinimumOverMotion&)>& forge) const {
    TimeOfContact contact = contact_;
    MinimumOverMotion minimum = minimum_;
    forge(contact, minimum);
    EXPECT_TRUE(brokenPromise(motion_, contact, minimum));
  }

  const StressMotion motion_ = fallingBall();
  const TimeOfContact contact_ =
      timeOfContact(motion_.a, motion_.a_motion, motion_.b, motion_.b_motion, motion_.options);
  const MinimumOverMotion minimum_ = minimumDistance(motion_.a, motion_.a_motion, motion_.b, motion_.b_motion);
};

TEST_F(ForgedAnswers, ContactsAreFound) {
  expectFound([](TimeOfContact& late, auto&) { late.t_free = late.t_contact = late.t_contact + 1e-9; });
  expectFound([](TimeOfContact& missed, auto&) {
    missed = {};
    missed.status = Status::Converged;
    missed.t_free = 1.0;
  });
  expectFound([](TimeOfContact& early, auto&) { early.t_free = early.t_contact = early.t_contact - 1e-8; });
  expectFound([](TimeOfContact& elsewhere, auto&) { elsewhere.at_contact.point_a.x() += 1e-6; });
}

TEST_F(ForgedAnswers, MinimaAreFound) {
  expectFound([](auto&, MinimumOverMotion& high) {
    high.lower_bound += 1e-8;
    high.upper_bound += 1e-8;
  });
  expectFound([](auto&, MinimumOverMotion& low) { low.upper_bound -= 1e-8; });
  expectFound([](auto&, MinimumOverMotion& later) { later.time += 1e-6; });
}

}  // namespace proximity_server::narrowphase::motion_stress_test
