#include "system/process.h"

#include <linux/sched.h>
#include <linux/sched/types.h>
#include <malloc.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

namespace proximity_server::system {

void requestShortTimeSlices() {
  const bool is_ordinary = syscall(SYS_sched_getscheduler, 0) == SCHED_NORMAL;
  if (!is_ordinary) return;  // the process was started with another policy, as by chrt

  constexpr __u64 kSlice = 100'000;  // [ns] the shortest time slice that Linux allows
  sched_attr attributes{};
  attributes.size = sizeof attributes;
  attributes.sched_nice = getpriority(PRIO_PROCESS, 0);
  attributes.sched_runtime = kSlice;
  // An older kernel refuses the call, and nothing changes.
  syscall(SYS_sched_setattr, 0, &attributes, 0);
}

void giveBackLargeMemory() {
  constexpr int kLarge = 1 << 20;  // [byte] more than a usual answer needs
  mallopt(M_MMAP_THRESHOLD, kLarge);
  mallopt(M_TRIM_THRESHOLD, kLarge);
}

void leaveCtrlCToOtherThreads() {
  sigset_t ctrl_c;
  sigemptyset(&ctrl_c);
  sigaddset(&ctrl_c, SIGINT);
  pthread_sigmask(SIG_BLOCK, &ctrl_c, nullptr);
}

void giveBackFreeMemory() { malloc_trim(0); }

}  // namespace proximity_server::system
