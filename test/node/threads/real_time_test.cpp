#include "node/threads/real_time.h"

#include "node/threads/grants_real_time.h"

#include <gtest/gtest.h>
#include <sched.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <string>
#include <thread>

namespace proximity_server::node::real_time_test {

constexpr int kPriority = 7;

int policy() { return sched_getscheduler(0) & ~SCHED_RESET_ON_FORK; }

template <class Function>
void inAThread(Function function) {
  std::thread(function).join();
}

TEST(RunInRealTime, IsForTheThreadThatAsksAlone) {
  if (!grantsRealTime()) GTEST_SKIP() << "the system does not grant real-time priorities";
  inAThread([] {
    runInRealTime(kPriority);
    EXPECT_EQ(policy(), SCHED_FIFO);
    sched_param parameter{};
    sched_getparam(0, &parameter);
    EXPECT_EQ(parameter.sched_priority, kPriority);
    inAThread([] { EXPECT_EQ(policy(), SCHED_OTHER); });
  });
  EXPECT_EQ(policy(), SCHED_OTHER);
}

TEST(RunInRealTime, IsNotAskedForByZero) {
  testing::internal::CaptureStderr();
  inAThread([] {
    runInRealTime(0);
    EXPECT_EQ(policy(), SCHED_OTHER);
  });
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

TEST(RunInRealTime, WarnsWhereItIsNotGranted) {
  rlimit before{};
  getrlimit(RLIMIT_RTPRIO, &before);
  const rlimit none{0, before.rlim_max};
  setrlimit(RLIMIT_RTPRIO, &none);
  testing::internal::CaptureStderr();
  inAThread([] {
    constexpr int kNobody = 65534;
    syscall(SYS_setresuid, kNobody, kNobody, kNobody);  // of this thread only; fails where it is nobody special anyway
    runInRealTime(kPriority);
    EXPECT_EQ(policy(), SCHED_OTHER);
  });
  const std::string said = testing::internal::GetCapturedStderr();
  setrlimit(RLIMIT_RTPRIO, &before);
  EXPECT_NE(said.find("realtime_priority 7 is not granted"), std::string::npos) << said;
}

}  // namespace proximity_server::node::real_time_test
