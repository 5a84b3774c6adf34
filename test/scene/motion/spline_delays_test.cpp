#include "proximity_server/scene/motion/spline_delays.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace proximity_server::scene::spline_delays_test {

constexpr double kLead = SplineDelays::kLargestLead;

/// Tells a SplineDelays of one joint, each with an error of 0.01 rad and 0.1 rad/s.
template <class Spline>
void tell(SplineDelays& delays, double time, double position, double velocity, const Spline& spline,
          double velocity_later = 0.0) {
  delays.observe(time, {{position, velocity, velocity_later, 0.01, 0.1}},
                 [&](std::size_t, double delay) { return spline(time - delay); });
}

double steady(double time) { return time; }  // 1 rad/s
double resting(double) { return 0.0; }
double turning(double time) { return -time * time; }

TEST(SplineDelays, AreThoseWithinThePositionError) {
  SplineDelays delays(-kLead);
  tell(delays, 1.0, 0.95, 1.0, steady);
  EXPECT_TRUE(delays.fits());
  EXPECT_NEAR(delays.best(), 0.05, 1e-5) << "it is drawn to 0 by a mm for 0.1 s";
  EXPECT_LE(delays.least(), 0.04);
  EXPECT_GE(delays.least(), 0.04 - SplineDelays::kStep - 1e-9);
  EXPECT_GE(delays.most(), 0.06);
  EXPECT_LE(delays.most(), 0.06 + SplineDelays::kStep + 1e-9);
}

TEST(SplineDelays, AreAllOfThemAtRest) {
  SplineDelays delays(0.0);
  tell(delays, 1.0, 0.001, 0.0, resting);
  EXPECT_EQ(delays.least(), 0.0);
  EXPECT_NEAR(delays.most(), SplineDelays::kLargest, 1e-12);
  EXPECT_EQ(delays.best(), 0.0);
}

TEST(SplineDelays, AreNegativeOnlyAsFarAsTheyMayBe) {
  SplineDelays with_stamp(0.0), without(-kLead);
  tell(with_stamp, 1.0, 1.015, 1.0, steady);
  EXPECT_FALSE(with_stamp.fits());
  EXPECT_NEAR(with_stamp.farthest(), 0.015, 1e-9);
  tell(without, 1.0, 1.015, 1.0, steady);
  EXPECT_TRUE(without.fits());
  tell(without, 1.1, 1.1 + kLead + 0.012, 1.0, steady);
  EXPECT_FALSE(without.fits());
}

TEST(SplineDelays, AreThoseOfAllStatesTogether) {
  SplineDelays delays(0.0);
  tell(delays, 1.0, 0.97, 1.0, steady);
  tell(delays, 1.1, 1.055, 1.0, steady);
  EXPECT_GE(delays.least(), 0.035 - SplineDelays::kStep);
  EXPECT_LE(delays.most(), 0.04 + SplineDelays::kStep);
}

TEST(SplineDelays, CountAsFollowedAfterATenthOfASecond) {
  SplineDelays delays(0.0);
  for (double time = 1.0; time < 1.095; time += 0.01) {
    tell(delays, time, time - 0.02, 1.0, steady);
    EXPECT_FALSE(delays.areFollowed()) << time;
  }
  tell(delays, 1.101, 1.081, 1.0, steady);
  EXPECT_TRUE(delays.areFollowed());
  tell(delays, 1.11, 1.09, 0.8, steady);
  EXPECT_TRUE(delays.fits());
  EXPECT_FALSE(delays.areFollowed()) << "another velocity";
  tell(delays, 1.2, 1.18, 1.0, steady);
  EXPECT_FALSE(delays.areFollowed());
  tell(delays, 1.31, 1.29, 1.0, steady);
  EXPECT_TRUE(delays.areFollowed());
  tell(delays, 1.4, 1.2, 1.0, steady);
  EXPECT_FALSE(delays.fits());
  EXPECT_FALSE(delays.areFollowed()) << "another position";
}

TEST(SplineDelays, AgreeOnlyWhileSomebodyLooks) {
  SplineDelays delays(0.0);
  const auto tellAt = [&](double time) { tell(delays, time, time - 0.02, 1.0, steady); };
  for (const double time : {1.0, 1.2, 1.4, 1.52}) {
    tellAt(time);
    EXPECT_TRUE(delays.fits());
    EXPECT_EQ(delays.areFollowed(), time == 1.52) << time;
  }
  EXPECT_EQ(delays.agreedSince(), 1.4);
  tellAt(2.0);
  EXPECT_FALSE(delays.areFollowed());
  EXPECT_EQ(delays.agreedSince(), 2.0);
}

TEST(SplineDelays, AreInheritedByTheNextSpline) {
  SplineDelays delays(0.0, 0.89);
  tell(delays, 1.0, 0.98, 1.0, steady);
  EXPECT_TRUE(delays.areFollowed());
}

// It crosses the spline backwards. Each state by itself fits with some delay, until it has passed.
TEST(SplineDelays, OfARobotThatCrossesTheSplineDoNotAgree) {
  for (const double velocity : {-2.0, -0.5, 0.0, 0.5, 1.5}) {
    SplineDelays delays(-kLead);
    for (double time = 0.8; time < 1.2; time += 0.002) {
      tell(delays, time, 0.97 + velocity * (time - 1.0), velocity, steady);
      EXPECT_FALSE(delays.areFollowed()) << velocity << " at " << time;
    }
  }
}

// A robot that stands before a turning point has the position of two delays, and none of their velocities.
TEST(SplineDelays, OfARobotThatStandsAreNotFollowed) {
  SplineDelays delays(0.0);
  for (double time = -0.1; time < 0.2; time += 0.005) {
    tell(delays, time, -0.0225, 0.0, turning);
    EXPECT_FALSE(delays.areFollowed()) << time;
  }
}

TEST(SplineDelays, TakeTheVelocityOfItsOwnTime) {
  const auto accelerating = [](double time) { return 5.0 * time * time; };
  SplineDelays early(0.0), late(0.0);
  for (double time = 0.3; time < 0.45; time += 0.01) {
    tell(early, time, accelerating(time), 10.0 * (time + 0.02), accelerating);
    tell(late, time, accelerating(time), 10.0 * (time + 0.02), accelerating, 0.02);
  }
  EXPECT_FALSE(early.areFollowed());
  EXPECT_TRUE(late.areFollowed());
}

}  // namespace proximity_server::scene::spline_delays_test
