#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "node/monitor/joint_velocities.h"
#include "node/robot/robot.h"
#include "node/tf/tf_poses.h"
#include "proximity_server/Clearance.h"

namespace proximity_server::node {

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

  /// The clearance in these poses, and with a lookahead what the velocities lead to. Never waits. Valid until the next
  /// cycle. Without a lookahead only the first few cycles of a robot, or of a larger max_reported_pairs, take memory.
  const Clearance& cycle(const PoseSnapshot& snapshot, const VelocitySnapshot& velocities,
                         const MonitorSettings& settings);

  /// The message of the latest cycle; its `cycle` is 0 before the first one.
  const Clearance& latest() const { return clearance_; }

 private:
  void measure(const PoseSnapshot& snapshot, const MonitorSettings& settings);
  void report(const PoseSnapshot& snapshot, const scene::PairsBelow& below, const scene::Question& question,
              std::size_t most);
  void lookAhead(const PoseSnapshot& snapshot, const VelocitySnapshot& velocities, const MonitorSettings& settings);
  void countPairs();

  std::shared_ptr<const Robot> robot_;
  ScenePool::Lease scene_;  // after robot_, whose pools take it and the next back
  MovingScenePool::Lease moving_scene_;
  std::vector<int> bodies_;
  std::vector<int> joints_;
  std::uint8_t level_ = Clearance::INVALID;
  Clearance clearance_;
  std::vector<Proximity> unlisted_;  ///< room for further entries of Clearance::below_threshold
  std::size_t longest_name_ = 0;     ///< of links and <collision> elements
};

}  // namespace proximity_server::node
