#pragma once

#include <urdf_model/model.h>
#include <urdf_world/types.h>

#include <set>
#include <string>
#include <vector>

namespace proximity_server::scene {

/// The links of which <visual> geometry stands for the <collision> geometry that they do not have.
struct FromVisual {
  std::vector<std::string> wanted;       ///< names, or kAllLinks
  std::set<std::string> taken{};         ///< the links among them that have visual, but no collision geometry
  std::vector<std::string> only_seen{};  ///< the others that have visual, but no collision geometry
  int seen = 0;                          ///< links with visual geometry
};

/// Reads a URDF with urdfdom, but reports every error. If urdfdom would log an error and continue without the element,
/// or use the first of two shapes, this throws std::invalid_argument, naming link or joint.
///
/// Elements that are not needed here (most visuals, inertial, material, ...) are removed first, so that errors in them do
/// not matter. An unknown element that holds geometry or joints becomes a warning that names it.
urdf::ModelInterfaceSharedPtr readUrdf(const std::string& urdf_xml, FromVisual& visuals,
                                       std::vector<std::string>& warnings);

}  // namespace proximity_server::scene
