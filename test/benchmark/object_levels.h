#pragma once

#include <proximity_server/Clearance.h>
#include <proximity_server/ObjectChanges.h>

#include <ros/node_handle.h>

#include <condition_variable>
#include <mutex>
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

  std::mutex mutex_;  // guards the next two
  std::condition_variable arrived_;
  double distance_ = 0.0;  ///< [m] of the nearest object
  ros::Publisher publisher_;
  ros::Subscriber subscriber_;
};

}  // namespace proximity_server::benchmark
