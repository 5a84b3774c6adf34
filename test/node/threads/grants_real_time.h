#pragma once

#include <sched.h>

#include <thread>

namespace proximity_server::node {

/// Gives this thread a SCHED_FIFO priority; false where the system does not grant it.
inline bool takeRealTimePriority(int priority) {
  sched_param parameter{};
  parameter.sched_priority = priority;
  return sched_setscheduler(0, SCHED_FIFO, &parameter) == 0;
}

inline void giveUpRealTimePriority() {
  const sched_param none{};
  sched_setscheduler(0, SCHED_OTHER, &none);
}

/// Whether the system would grant one.
inline bool grantsRealTime() {
  bool granted = false;
  std::thread([&] { granted = takeRealTimePriority(1); }).join();
  return granted;
}

}  // namespace proximity_server::node
