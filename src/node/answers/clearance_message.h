#pragma once

#include "node/answers/clearance_text.h"
#include "node/answers/conversions.h"
#include "node/robot/robot.h"
#include "node/tf/tf_poses.h"
#include "proximity_server/Clearance.h"
#include "proximity_server/scene/answers/assessment.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

namespace proximity_server::node {

/// The poses and settings of a cycle of the monitor, with the assessment of its state.
struct AssessedCycle {
  const PoseSnapshot& snapshot;
  const FrameSnapshot& frames;
  const MonitorSettings& settings;
  const scene::State& state;
  const scene::Assessment& found;
  const QueryStatus& bounds;                     ///< OK if it is known where the true state is
  const scene::GuaranteedDistances* guaranteed;  ///< nullptr: exactly there
};

/// Writes the Clearance of each cycle of one robot. Not thread-safe. Memory is allocated only in the first few cycles,
/// and after max_reported_pairs has grown.
class ClearanceMessage {
 public:
  /// The robot of the next cycles, which has to outlive them.
  void follow(const Robot& robot);

  /// The revision of its objects, and [characters] the longest name that a cycle can write.
  void use(std::uint64_t objects_revision, std::size_t longest_name);

  /// Writes all but the look-ahead and the computation time. The message is valid until the next call.
  Clearance& write(const AssessedCycle& cycle);

  /// Its `cycle` is 0 before the first one.
  const Clearance& latest() const { return message_; }

 private:
  void begin(const AssessedCycle& cycle);
  void assignJoints(const AssessedCycle& cycle);
  void assignCounts(const AssessedCycle& cycle);
  void listPairs(const AssessedCycle& cycle);
  void reserve(Proximity& pair, const AssessedCycle& cycle) const;
  void assignPair(Proximity& message, const AssessedCycle& cycle, const scene::PairProximity& pair,
                  const scene::PairFacts& facts) const;
  void assignPair(Proximity& message, const AssessedCycle& cycle, const scene::AssessedPair& pair) const;
  void assignLevel(const AssessedCycle& cycle);
  void explain(const AssessedCycle& cycle);
  void explainInvalid(const AssessedCycle& cycle);

  const Robot* robot_ = nullptr;
  std::optional<ClearanceText> text_;  ///< for this robot
  std::size_t longest_name_ = 0;       ///< [characters] of all names
  std::size_t text_capacity_ = 0;      ///< [characters] of the longest text
  Clearance message_;
  std::vector<Proximity> unlisted_;  ///< entries that below_threshold does not need now; they keep memory
};

}  // namespace proximity_server::node
