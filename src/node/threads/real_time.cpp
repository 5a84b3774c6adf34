#include "node/threads/real_time.h"

#include <ros/console.h>
#include <ros/poll_manager.h>
#include <sched.h>

#include <cerrno>
#include <cstring>
#include <memory>
#include <mutex>

namespace proximity_server::node {

void runInRealTime(int priority) {
  if (priority == 0) return;
  sched_param parameter{};
  parameter.sched_priority = priority;
  if (sched_setscheduler(0, SCHED_FIFO | SCHED_RESET_ON_FORK, &parameter) == 0) return;
  ROS_WARN_STREAM_ONCE("realtime_priority "
                       << priority << " is not granted (" << std::strerror(errno)
                       << "): the monitor runs like any other thread. The limit is that of ulimit -r");
}

void runPollThreadInRealTime(int priority) {
  // The poll thread calls it again and again.
  ros::PollManager::instance()->addPollThreadListener(
      [priority, once = std::make_shared<std::once_flag>()] { std::call_once(*once, runInRealTime, priority); });
}

}  // namespace proximity_server::node
