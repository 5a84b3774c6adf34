#pragma once

#include "node/robot/config.h"
#include "proximity_server/scene/configuration/parameter.h"

#include <vector>

namespace proximity_server::node {

/// Returns all parameters, each with its field in `config`. A live parameter is a field of MonitorSettings. The node
/// reads its parameters by these rows, and `./dev parameters` makes the table of config/PARAMETERS.md,
/// config/proximity.yaml and config/Proximity.cfg from them.
std::vector<scene::Parameter> parameterTable(Config& config);

}  // namespace proximity_server::node
