#pragma once

#include "proximity_server/scene/levels/level_thresholds.h"
#include "proximity_server/scene/objects/object.h"
#include "proximity_server/scene/scene_model/scene_model.h"

#include <string>
#include <vector>

namespace proximity_server::tools {

/// Fingerprints of a robot as it was loaded: equal if its answers are equal, wherever its files lie.
struct ModelDigest {
  std::string joints;  ///< links and joints, with their frames, axes and limits
  std::string shapes;  ///< the pieces that stand for the geometry, with what was measured of the meshes
  std::string pairs;   ///< the pairs of links, with reasons and paddings
};
ModelDigest digestOf(const scene::SceneModel& model);

/// A fingerprint of the thresholds of all pairs of links, and of links with objects.
std::string digestOf(const scene::LevelThresholds& thresholds, const scene::RobotModel& robot);

/// A fingerprint of the pieces of objects, with what was measured of their meshes. Neither half-spaces nor the places
/// of the objects are in it, as the file of the objects has both.
std::string shapesDigestOf(const std::vector<scene::Object>& objects);

/// A hash of the program that runs: of its file and of the libraries of this package that it has loaded. Two builds
/// that may answer differently have different ones.
std::string programDigest();

}  // namespace proximity_server::tools
