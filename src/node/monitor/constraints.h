#pragma once

#include <cstddef>

#include "node/answers/conversions.h"
#include "node/answers/gradients.h"
#include "node/robot/config.h"
#include "node/robot/robot.h"
#include "node/tf/tf_poses.h"
#include "proximity_server/Clearance.h"
#include "proximity_server/ConstraintRows.h"
#include "proximity_server/scene/derivative/constraint_rows.h"
#include "proximity_server/scene/query/scene.h"

namespace proximity_server::node {

/// A cycle of the monitor, with the scene and the gradients that have its poses and objects.
struct MeasuredCycle {
  const Clearance& clearance;
  const PoseSnapshot& snapshot;
  scene::Scene& scene;
  const Gradients& gradients;
  const scene::PairDistances& stop;
  Named named;
  std::size_t longest_name;  ///< in characters, of any pair
};

/// The constraint rows of one robot as messages. Not thread-safe. Nothing allocates after the first few messages, as long as no more
/// pairs are stuck than in the one before.
class Constraints {
 public:
  /// Throws std::invalid_argument for a capacity below 1.
  Constraints(const Robot& robot, int capacity);

  int capacity() const { return rows_.capacity(); }

  /// The rows in the poses of a cycle; the message is valid until the next call. It has no rows if nothing is known of some
  /// pair, or if the settings contradict each other, as its status tells.
  const ConstraintRows& in(const MeasuredCycle& cycle, const MonitorSettings& settings);

 private:
  QueryStatus update(const MeasuredCycle& cycle, const MonitorSettings& settings);
  void assignRows(const MeasuredCycle& cycle);
  void assignStuck(const MeasuredCycle& cycle);

  scene::ConstraintRows rows_;
  scene::VelocityDamper damper_;
  ConstraintRows message_, refusal_;  ///< two, so that a message without rows frees no memory
};

}  // namespace proximity_server::node
