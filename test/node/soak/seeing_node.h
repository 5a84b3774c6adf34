#pragma once

#include <proximity_server/Clearance.h>
#include "chance.h"
#include "node/load/node_under_load.h"
#include "node/soak/soak_record.h"

#include <sensor_msgs/PointCloud2.h>

#include <array>
#include <chrono>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <string>

namespace proximity_server::node {

/// A node with two cameras, of which one at least sees points everywhere around the robot, or fails after it has seen them:
/// the level must be neither CLEAR nor WARN.
class SeeingNode {
 public:
  /// Failure: throws std::runtime_error where the node does not start.
  explicit SeeingNode(SoakRecord& record);
  ~SeeingNode();

  /// Both cameras see the points. Whether the node stops within `patience` [s].
  bool awaitStop(double patience);

  /// One camera does something wrong for a while. Returns whether the node stops again within `patience` [s].
  bool fail(Chance& chance, double patience);

 private:
  enum class Way : unsigned char {
    Stops,
    JumpsAhead,
    JumpsBack,
    Twice,
    Nowhere,
    LiesAboutSize,
    NoFields,
    Empty,
    Reload
  };
  static constexpr int kWays = 9;

  void see(std::size_t camera, const sensor_msgs::PointCloud2& cloud) { publishers_[camera].publish(cloud); }
  bool sees(std::size_t camera, double patience);
  void seeFor(double seconds, std::size_t failing, Way way);
  void onClearance(const Clearance& message);

  SoakRecord& record_;
  std::mutex mutex_;  // guards what follows, up to the node
  std::condition_variable arrived_;
  bool must_stop_ = false;  ///< the node has the points of a camera that fails
  std::uint64_t stops_ = 0;
  std::string decided_by_;  ///< the last of them
  std::string way_;         ///< of the last failure
  std::array<ros::Publisher, 2> publishers_;
  std::unique_ptr<ChildProcess> node_;
  ros::Subscriber clearance_sub_;
};

}  // namespace proximity_server::node
