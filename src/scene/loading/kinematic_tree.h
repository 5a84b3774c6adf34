#pragma once

#include <urdf_model/model.h>

#include "proximity_server/scene/loading/model_options.h"
#include "proximity_server/scene/model/robot_model.h"

namespace proximity_server::scene {

/// Adds the links, joints and bodies of a URDF to an empty model, depth first from the root, so parents first.
///
/// Failure: throws std::invalid_argument naming the joint: a type that is not known, an axis without length, an origin
///          that is not finite, a mimic that makes no sense and moves geometry (unless allowed). What is odd but not wrong is a warning.
void addKinematicTree(const urdf::ModelInterface& urdf, const ModelOptions& options, RobotModel& model);

}  // namespace proximity_server::scene
