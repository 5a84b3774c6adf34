#pragma once

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "proximity_server/scene/filter/scene_model.h"
#include "proximity_server/scene/query/always_near.h"

namespace proximity_server::tools {

/// In how many of `kStates` random states the node's level is CLEAR, WARN, STOP and COLLISION.
struct LevelCounts {
  static constexpr int kStates = 500;
  std::array<int, 4> states{};
};

/// The level of a state is the worst of its checked pairs; each is held to `usual` thresholds, but the pairs of `own` to those that
/// fit them, see scene::fittingThresholds(). Joints are uniform within their ranges.
LevelCounts countLevels(const std::shared_ptr<const scene::SceneModel>& model, const scene::StopAndWarn& usual,
                        const std::vector<scene::AlwaysNear>& own, unsigned long seed);

/// A table with a row for each of them.
std::string levelTable(const LevelCounts& before, const LevelCounts& after);

}  // namespace proximity_server::tools
