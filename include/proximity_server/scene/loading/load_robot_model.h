#pragma once

#include "proximity_server/scene/loading/model_options.h"
#include "proximity_server/scene/mesh/mesh_resolver.h"
#include "proximity_server/scene/model/robot_model.h"

#include <string>

namespace proximity_server::scene {

/// The warning about links that have visual, but no collision geometry, begins with this.
inline constexpr char kSeenOnly[] = "Seen, but not checked";

/// Reads a URDF.
///
/// Every <collision> of every link counts. If a link has a cylinder with a sphere of the same radius at both of its
/// ends, the three become a capsule, which is the same solid.
/// Failure: throws std::invalid_argument, naming link and file, joint, or element, for unreadable XML, an unresolved
///          mesh or an invalid mimic (unless allowed), geometry that has size zero or is not finite, and a padding or
///          mesh tolerance for an unknown link; std::runtime_error once ModelOptions::stop is set.
RobotModel loadRobotModel(const std::string& urdf_xml, const MeshResolver& resolve, const ModelOptions& options = {});

}  // namespace proximity_server::scene
