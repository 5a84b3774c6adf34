#pragma once

#include "node/objects/tracked_ages.h"
#include "node/robot/robot.h"
#include "node/robot/scene_pool.h"
#include "proximity_server/Sensed.h"

#include <optional>
#include <vector>

namespace proximity_server::node {

/// The sensed sources of a robot in the state of `scenes`. `clouds` and `ages` [s] are in the order of Config::tracked. The
/// distances are not asked for unless `is_known`.
std::vector<SensedSource> sensedSources(const Robot& robot, PosedScenes& scenes, bool is_known,
                                        const std::vector<SensedCloud>& clouds,
                                        const std::vector<std::optional<double>>& ages);

}  // namespace proximity_server::node
