#pragma once

#include "scene/filter/link_table.h"
#include "scene/filter/srdf.h"

#include <string>
#include <vector>

namespace proximity_server::scene {

/// Tells for each body whether it moves when the joints of a group move, including their mimic joints. Names in the
/// group that do not exist become warnings. Throws std::invalid_argument for a group that does not exist or that
/// contains itself.
std::vector<bool> bodiesMovedByGroup(const RobotModel& model, const LinkTable& links, const Srdf& srdf,
                                     const std::string& group, std::vector<std::string>& warnings);

}  // namespace proximity_server::scene
