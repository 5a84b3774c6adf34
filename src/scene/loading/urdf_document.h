#pragma once

#include <urdf_model/model.h>
#include <urdf_world/types.h>

#include <string>
#include <vector>

namespace proximity_server::scene {

/// Reads a URDF with urdfdom, but reports every error: where urdfdom would log an error and go on without the element,
/// or use the first of two shapes, this throws std::invalid_argument naming link or joint.
///
/// What is of no concern here (visual, inertial, material, ...) is removed first, so that errors in it do not matter.
/// An element that is not known, but holds geometry or joints, becomes a warning that names it.
urdf::ModelInterfaceSharedPtr readUrdf(const std::string& urdf_xml, std::vector<std::string>& warnings);

}  // namespace proximity_server::scene
