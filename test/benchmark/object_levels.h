#pragma once

#include <proximity_server/Clearance.h>
#include <proximity_server/ObjectChanges.h>

#include <ros/node_handle.h>

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

namespace proximity_server::benchmark {

/// Moves a ball into the base of the robot and far away by turns, and measures how long each message needs to the first
/// ~clearance that knows it. Beside that, other balls may be moved by a stream of messages. Not thread-safe.
class ObjectLevels {
 public:
  explicit ObjectLevels(ros::NodeHandle nh);
  /// Removes all objects.
  ~ObjectLevels();

  /// Measures for so many seconds, and returns the times [s]. `stream` [Hz] is the rate of the other messages, 0: none.
  std::vector<double> measure(double seconds, double stream);

 private:
  void onClearance(const Clearance& clearance);
  enum class Place : unsigned char { InTheRobot, FarAway };
  /// Returns the time [s]; throws std::runtime_error if the level does not come.
  double timeToLevelAt(Place place);

  using Clock = std::chrono::steady_clock;

  std::mutex mutex_;  // guards the next three
  std::condition_variable arrived_;
  std::optional<Place> place_;  // of the ball, in the latest message
  Clock::time_point placed_;    // when the first message with this place arrived
  ros::Publisher publisher_;
  ros::Subscriber subscriber_;
};

}  // namespace proximity_server::benchmark
