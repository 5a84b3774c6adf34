#pragma once

#include <string>

#include "proximity_server/scene/loading/model_options.h"
#include "proximity_server/scene/mesh/mesh_resolver.h"
#include "proximity_server/scene/model/robot_model.h"

namespace proximity_server::scene {

/// Reads a URDF.
///
/// Every <collision> of every link counts. A cylinder with a sphere of the same radius at both of its ends, in the same
/// link, becomes the capsule that they are.
/// Failure: throws std::invalid_argument naming link and file, joint, or element: unreadable XML, an unresolved mesh or a
///          mimic that makes no sense (unless allowed), zero-size or non-finite geometry, a padding or mesh tolerance for an unknown link.
RobotModel loadRobotModel(const std::string& urdf_xml, const MeshResolver& resolve, const ModelOptions& options = {});

}  // namespace proximity_server::scene
