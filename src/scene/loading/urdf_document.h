#pragma once

#include <urdf_model/model.h>
#include <urdf_world/types.h>

#include <string>
#include <vector>

namespace proximity_server::scene {

/// Reads a URDF with urdfdom, but reports every error. If urdfdom would log an error and continue without the element,
/// or use the first of two shapes, this throws std::invalid_argument, naming link or joint.
///
/// Elements that are not needed here (visual, inertial, material, ...) are removed first, so that errors in them do not
/// matter. An unknown element that holds geometry or joints becomes a warning that names it.
urdf::ModelInterfaceSharedPtr readUrdf(const std::string& urdf_xml, std::vector<std::string>& warnings);

}  // namespace proximity_server::scene
