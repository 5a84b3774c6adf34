#include "system/process.h"

#include <gtest/gtest.h>
#include <sched.h>

#include <thread>

namespace proximity_server::system::process_test {

// Regression: a node that was started with `chrt --fifo 20` lost its policy. SCHED_BATCH is granted to everybody.
TEST(AskForShortTurns, KeepsAPolicyThatSomebodyChose) {
  std::thread([] {
    const sched_param parameter{};
    ASSERT_EQ(sched_setscheduler(0, SCHED_BATCH, &parameter), 0);
    requestShortTimeSlices();
    EXPECT_EQ(sched_getscheduler(0) & ~SCHED_RESET_ON_FORK, SCHED_BATCH);
  }).join();
}

}  // namespace proximity_server::system::process_test
