#pragma once

#include "node/answers/conversions.h"
#include "node/robot/config.h"
#include "node/robot/robot.h"
#include "node/tf/tf_poses.h"
#include "proximity_server/Clearance.h"
#include "proximity_server/ConstraintRows.h"
#include "proximity_server/scene/derivative/constraint_rows.h"
#include "proximity_server/scene/guaranteed/guaranteed_distances.h"

#include <cstddef>
#include <vector>

namespace proximity_server::node {

/// The results of a cycle of the monitor, with its state and scenes.
struct MeasuredCycle {
  const Clearance& clearance;
  const PoseSnapshot& snapshot;
  PosedScenes& scenes;
  const scene::PairDistances& stop;
  RobotAndObjects model;
  scene::GuaranteedDistances* guaranteed;  ///< nullptr if the robot is not uncertain
  std::size_t longest_name;                ///< [characters] of the names in any pair
};

/// Makes messages with the constraint rows of one robot. Not thread-safe. After the first few messages no memory is
/// allocated, unless more pairs are stuck than in any message before.
class Constraints {
 public:
  /// Throws std::invalid_argument for a capacity below 1.
  Constraints(const Robot& robot, int capacity);

  int capacity() const { return rows_.capacity(); }  ///< of pairs

  /// The rows at the poses of a cycle: those of pairs, then one for each of RobotModel::inequalities. The message is
  /// valid until the next call. It has no rows, and a status with the reason, if the distance of a pair or the position
  /// of a joint of an inequality is unknown, or if the settings contradict each other.
  const ConstraintRows& rowsOf(const MeasuredCycle& cycle, const MonitorSettings& settings);

 private:
  QueryStatus update(const MeasuredCycle& cycle, const MonitorSettings& settings);
  void assignRows(const MeasuredCycle& cycle);
  void assignInequalities();
  void assignStuck(const MeasuredCycle& cycle);

  const Config& config_;
  scene::ConstraintRows rows_;
  scene::InequalityRows inequality_rows_;
  scene::VelocityDamper damper_;
  ConstraintRows message_;
  ConstraintRows empty_message_;  ///< for a message without rows, so that `message_` keeps its memory
};

}  // namespace proximity_server::node
