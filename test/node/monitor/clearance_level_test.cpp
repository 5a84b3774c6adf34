#include "node/monitor/clearance_level.h"

#include <gtest/gtest.h>

#include <limits>

#include "proximity_server/Clearance.h"

namespace proximity_server::node::clearance_level_test {

MonitorSettings settings() {
  MonitorSettings settings;
  settings.warn_distance = 0.05;
  settings.stop_distance = 0.02;
  settings.hysteresis = 0.01;
  return settings;
}

TEST(ClearanceLevel, StartsAtItsThreshold) {
  const std::uint8_t none = Clearance::INVALID;
  EXPECT_EQ(clearanceLevel(0.051, none, settings()), Clearance::CLEAR);
  EXPECT_EQ(clearanceLevel(0.05, none, settings()), Clearance::WARN);
  EXPECT_EQ(clearanceLevel(0.02, none, settings()), Clearance::STOP);
  EXPECT_EQ(clearanceLevel(0.0, none, settings()), Clearance::COLLISION);
  EXPECT_EQ(clearanceLevel(-0.1, none, settings()), Clearance::COLLISION);
}

TEST(ClearanceLevel, IsLeftOnlyBeyondTheHysteresis) {
  const MonitorSettings with = settings();
  EXPECT_EQ(clearanceLevel(0.059, Clearance::WARN, with), Clearance::WARN);
  EXPECT_EQ(clearanceLevel(0.061, Clearance::WARN, with), Clearance::CLEAR);
  EXPECT_EQ(clearanceLevel(0.029, Clearance::STOP, with), Clearance::STOP);
  EXPECT_EQ(clearanceLevel(0.031, Clearance::STOP, with), Clearance::WARN);
  EXPECT_EQ(clearanceLevel(0.009, Clearance::COLLISION, with), Clearance::COLLISION);
  EXPECT_EQ(clearanceLevel(0.011, Clearance::COLLISION, with), Clearance::STOP);
}

TEST(ClearanceLevel, GetsWorseWithoutDelay) {
  EXPECT_EQ(clearanceLevel(0.02, Clearance::CLEAR, settings()), Clearance::STOP);
  EXPECT_EQ(clearanceLevel(0.0, Clearance::WARN, settings()), Clearance::COLLISION);
}

TEST(ClearanceLevel, OfWhatIsNoNumberIsTheWorst) {
  EXPECT_EQ(clearanceLevel(std::numeric_limits<double>::quiet_NaN(), Clearance::CLEAR, settings()),
            Clearance::COLLISION);
}

}  // namespace proximity_server::node::clearance_level_test
