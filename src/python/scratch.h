#pragma once

#include "proximity_server/scene/batch/scene_batch.h"
#include "proximity_server/scene/derivative/free_motion.h"
#include "proximity_server/scene/motion/frames_on_links.h"
#include "proximity_server/scene/state/state.h"
#include "proximity_server/scene/uncertainty/guaranteed_distances.h"
#include "python/joint_positions.h"
#include "python/robot.h"

#include <Eigen/Core>

#include <optional>
#include <vector>

namespace proximity_server::python {

/// What one thread asks about a robot with its objects, and its memory. Each of them is made when a question first needs
/// it. The robot must outlive it.
class Scratch {
 public:
  explicit Scratch(const Robot& robot) : robot_(robot) {}

  scene::SceneBatch& batch() { return batch_ ? *batch_ : batch_.emplace(robot_.newBatch()); }
  scene::State& state() { return state_ ? *state_ : state_.emplace(robot_.newState()); }
  scene::FreeMotion& freeMotion() { return free_motion_ ? *free_motion_ : free_motion_.emplace(robot_.model()); }
  scene::GuaranteedDistances& guaranteed() { return guaranteed_ ? *guaranteed_ : guaranteed_.emplace(robot_.model()); }

  /// Takes the poses of a state of the block.
  const scene::State& place(const JointPositions::Block& block, Eigen::Index index) {
    positionsOf(block, index, positions);
    setPositions(state(), positions);
    return state();
  }

  std::vector<double> positions;  ///< of one state
  Eigen::VectorXd by_degrees;     ///< a gradient or a motion with respect to the degrees of freedom

 private:
  const Robot& robot_;
  std::optional<scene::SceneBatch> batch_;
  std::optional<scene::State> state_;
  std::optional<scene::FreeMotion> free_motion_;
  std::optional<scene::GuaranteedDistances> guaranteed_;
};

}  // namespace proximity_server::python
