#pragma once

#include "proximity_server/scene/loading/model_options.h"
#include "proximity_server/scene/model/robot_model.h"

#include <urdf_model/model.h>

namespace proximity_server::scene {

/// Adds the links, joints and bodies of a URDF to an empty model, depth first from the root, so that parents come
/// first.
///
/// Failure: throws std::invalid_argument, naming the joint, for an unknown type, an axis without length, an origin that
///          is not finite, and an invalid mimic that moves geometry (unless allowed). Input that is odd but legal is a
///          warning.
void addKinematicTree(const urdf::ModelInterface& urdf, const ModelOptions& options, RobotModel& model);

}  // namespace proximity_server::scene
