#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "proximity_server/Clearance.h"
#include "robot.h"
#include "tf_poses.h"

namespace proximity_server {

/// Watches the checked pairs of a robot: one Clearance per cycle. Not thread-safe.
class Monitor {
 public:
  /// Watches this robot from now on.
  void follow(const std::shared_ptr<const Robot>& robot);

  /// The robot that is watched, and the bodies whose poses a cycle needs.
  const std::shared_ptr<const Robot>& robot() const { return robot_; }
  const std::vector<int>& bodies() const { return bodies_; }

  /// The clearance in these poses. Never waits.
  Clearance cycle(const PoseSnapshot& snapshot, const MonitorSettings& settings);

 private:
  void measure(const PoseSnapshot& snapshot, const MonitorSettings& settings, Clearance& clearance);
  void countPairs(Clearance& clearance) const;

  std::shared_ptr<const Robot> robot_;
  ScenePool::Lease scene_;  // after robot_, whose pool takes it back
  std::vector<int> bodies_;
  std::uint8_t level_ = Clearance::INVALID;
  std::uint64_t cycles_ = 0;
};

}  // namespace proximity_server
