#pragma once

#include "proximity_server/scene/levels/clearance_level.h"
#include "proximity_server/scene/model/joint_ranges.h"
#include "proximity_server/scene/scene_model/scene_model.h"

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace proximity_server::tools {

/// The states in which levels are counted. First the state of rest: `rest`, or all joints at 0; a joint at 0 that
/// cannot be there is in the middle of its range. Then all joints in the middle. Then random ones, the same for the
/// same seed.
std::vector<scene::Positions> levelStates(const scene::RobotModel& robot, unsigned long seed,
                                          const std::optional<scene::Positions>& rest = std::nullopt);

/// The levels of one checked pair.
struct PairLevels {
  scene::ShapeRefPair pair;
  int collisions = 0, stops = 0;  ///< the numbers of random states
  scene::ClearanceLevel at_rest = scene::ClearanceLevel::Clear;

  /// True if the pair is in contact at rest, or in more than half of the random states. Most such pairs overlap in the
  /// model and not in the robot, and a monitor that checks them tells nothing. A person has to decide.
  bool isSuspect() const;
};

/// The levels of states, and of the pairs that set them.
struct LevelShares {
  static constexpr int kStates = 500;            ///< random ones
  std::vector<scene::ClearanceLevel> of_states;  ///< each the worst of all checked pairs; in the order of levelStates()
  std::vector<PairLevels> of_pairs;  ///< those at Stop or worse in a random state or at rest; suspects first, then the
                                     ///< most frequent

  std::array<int, 4> counts() const;  ///< of the random states, by level
  std::vector<PairLevels> suspects() const;
};

LevelShares levelShares(const std::shared_ptr<const scene::SceneModel>& model, const scene::LevelThresholds& thresholds,
                        const std::vector<scene::Positions>& states);

/// A table with a row for each of them.
std::string levelTable(const LevelShares& before, const LevelShares& after);

/// "12.0 % CLEAR, 20.0 % WARN, 30.0 % STOP, 38.0 % COLLISION"
std::string levelsText(const LevelShares& shares);

/// A share of the random states, "92.4 %"; and in which states a pair is in contact, "in contact at rest and in 92.4 % of
/// random states".
std::string shareText(int states);
std::string contactText(const PairLevels& pair);

}  // namespace proximity_server::tools
