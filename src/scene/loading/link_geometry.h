#pragma once

#include "proximity_server/scene/loading/model_options.h"
#include "proximity_server/scene/mesh/mesh_resolver.h"
#include "proximity_server/scene/model/robot_model.h"
#include "scene/loading/urdf_document.h"

#include <urdf_model/model.h>

namespace proximity_server::scene {

/// Throws std::invalid_argument, naming a link of the options that the model does not have.
void requireLinks(const ModelOptions& options, const RobotModel& model);

/// Adds the <collision> elements of all links of a model, and the convex pieces that stand for them. Those
/// that were taken from `visuals` say so.
///
/// Failure: throws std::invalid_argument, naming link and <collision>, see loadRobotModel().
void addGeometry(const urdf::ModelInterface& urdf, const MeshResolver& resolve, const ModelOptions& options,
                 const FromVisual& visuals, RobotModel& model);

}  // namespace proximity_server::scene
