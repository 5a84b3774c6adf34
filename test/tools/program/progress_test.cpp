#include "tools/program/progress.h"

#include <gtest/gtest.h>

namespace proximity_server::tools::answer_counter_test {

TEST(AnswerCounter, TellsRateAndTimeThatIsLeft) {
  EXPECT_EQ(countText("states", 1000, 5000, 2.0), "1,000 of 5,000 states, 500 a second, 8 s left");
  EXPECT_EQ(countText("states", 1234567, 1000000000, 0.5),
            "1,234,567 of 1,000,000,000 states, 2,469,134 a second, 7 min left");
  EXPECT_EQ(countText("states", 1, 20000, 1.0), "1 of 20,000 states, 1 a second, 6 h left");
  EXPECT_EQ(countText("segments", 7, 7, 7.0), "7 of 7 segments, 1 a second, 0 s left");
}

TEST(AnswerCounter, WithoutATotalOrAnAnswerNothingIsSaidOfTheRest) {
  EXPECT_EQ(countText("states", 999, std::nullopt, 1.0), "999 states, 999 a second");
  EXPECT_EQ(countText("states", 0, 10, 1.0), "0 of 10 states, 0 a second");
}

std::string toldOnAPipe(std::chrono::milliseconds pause) {
  testing::internal::CaptureStderr();
  ProgressBar bar(pause);
  bar.show("random states", 0.4321);
  bar.show("random states", 0.5);
  return testing::internal::GetCapturedStderr();
}

TEST(ProgressBar, PrintsLinesOnAPipe) {
  EXPECT_EQ(toldOnAPipe(std::chrono::milliseconds(0)), "random states: 43 %\nrandom states: 50 %\n");
  EXPECT_EQ(toldOnAPipe(std::chrono::hours(1)), "");
}

}  // namespace proximity_server::tools::answer_counter_test
