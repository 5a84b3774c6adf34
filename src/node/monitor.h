#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "joint_velocities.h"
#include "proximity_server/Clearance.h"
#include "robot.h"
#include "tf_poses.h"

namespace proximity_server {

/// Watches the checked pairs of a robot: one Clearance per cycle. Not thread-safe.
class Monitor {
 public:
  /// Watches this robot from now on.
  void follow(const std::shared_ptr<const Robot>& robot);

  /// The robot that is watched, the bodies whose poses a cycle needs, and the joints whose velocities the lookahead
  /// needs.
  const std::shared_ptr<const Robot>& robot() const { return robot_; }
  const std::vector<int>& bodies() const { return bodies_; }
  const std::vector<int>& joints() const { return joints_; }

  /// The clearance in these poses, and with a lookahead what the velocities lead to. Never waits.
  Clearance cycle(const PoseSnapshot& snapshot, const VelocitySnapshot& velocities, const MonitorSettings& settings);

 private:
  void measure(const PoseSnapshot& snapshot, const MonitorSettings& settings, Clearance& clearance);
  void lookAhead(const PoseSnapshot& snapshot, const VelocitySnapshot& velocities, const MonitorSettings& settings,
                 Clearance& clearance);
  void countPairs(Clearance& clearance) const;

  std::shared_ptr<const Robot> robot_;
  ScenePool::Lease scene_;  // after robot_, whose pools take it and the next back
  MovingScenePool::Lease moving_scene_;
  std::vector<int> bodies_;
  std::vector<int> joints_;
  std::uint8_t level_ = Clearance::INVALID;
  std::uint64_t cycles_ = 0;
};

}  // namespace proximity_server
