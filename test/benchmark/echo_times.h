#pragma once

#include <ros/node_handle.h>
#include <std_msgs/UInt32.h>

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <vector>

namespace proximity_server::benchmark {

/// The main() of a process that publishes each message of one topic on another one at once, and does nothing else.
void serveEcho();

/// Measures how long a message needs to the process of serveEcho() and back, which is as long as for any process on this
/// machine at this time. Not thread-safe.
class EchoTimes {
 public:
  /// Failure: throws std::runtime_error if the other process does not listen.
  explicit EchoTimes(ros::NodeHandle nh);

  /// Measures for so many seconds, and returns the times [s].
  std::vector<double> measure(double seconds);

 private:
  using Clock = std::chrono::steady_clock;
  void onEcho(const std_msgs::UInt32& message);

  std::mutex mutex_;  // guards the next three
  std::condition_variable arrived_;
  std::uint32_t last_ = 0;
  Clock::time_point last_arrival_;
  ros::Publisher publisher_;
  ros::Subscriber subscriber_;
};

}  // namespace proximity_server::benchmark
