#pragma once

#include "node/robot/robot.h"
#include "node/robot/scene_pool.h"
#include "node/sources/tracked_ages.h"
#include "proximity_server/Sensed.h"

#include <vector>

namespace proximity_server::node {

/// A message for each cloud, with the closest pair of its source in the state of `scenes`; without it unless that
/// `is_known`.
std::vector<SensedSource> sensedSources(const Robot& robot, PosedScenes& scenes, bool is_known,
                                        const std::vector<SensedCloud>& clouds);

}  // namespace proximity_server::node
