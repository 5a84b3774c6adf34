#pragma once

#include "proximity_server/scene/model/load_robot_model.h"
#include "proximity_server/scene/model/robot_model.h"

namespace proximity_server::scene {

/// Throws std::invalid_argument naming a link of the options that the model does not have.
void requireLinks(const ModelOptions& options, const RobotModel& model);

}  // namespace proximity_server::scene
