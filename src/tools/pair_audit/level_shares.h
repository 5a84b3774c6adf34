#pragma once

#include "proximity_server/scene/levels/clearance_level.h"
#include "proximity_server/scene/scene_model/scene_model.h"
#include "tools/program/time_budget.h"

#include <Eigen/Core>

#include <array>
#include <memory>
#include <string>
#include <vector>

namespace proximity_server::tools {

/// Random positions of the joints within their ranges, a row for each state; the same for the same seed.
Eigen::MatrixXd randomStates(const scene::RobotModel& robot, unsigned long seed);

/// The level of each state: the worst of its checked pairs. Throws as TimeBudget::require().
std::vector<scene::ClearanceLevel> levelsIn(const Eigen::MatrixXd& states,
                                            const std::shared_ptr<const scene::SceneModel>& model,
                                            const scene::LevelThresholds& thresholds, const TimeBudget& budget = {});

/// How many of the random states have each level.
struct LevelCounts {
  static constexpr int kStates = 500;
  std::array<int, 4> states{};
};
LevelCounts countLevels(const std::shared_ptr<const scene::SceneModel>& model, const scene::LevelThresholds& thresholds,
                        unsigned long seed, const TimeBudget& budget = {});

/// A table with a row for each of them.
std::string levelTable(const LevelCounts& before, const LevelCounts& after);

}  // namespace proximity_server::tools
