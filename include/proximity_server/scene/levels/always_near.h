#pragma once

#include <string>
#include <vector>

#include "proximity_server/scene/filter/scene_model.h"
#include "proximity_server/scene/levels/level_thresholds.h"

// Pairs of links that are near in every state, by design, and stop and warn distances that fit them: at those of all other
// pairs they would be an alarm that never ends.

namespace proximity_server::scene {

/// A stop and a warn distance [m].
struct StopAndWarn {
  double stop, warn;
};

/// Two links that were never seen far from each other.
struct AlwaysNear {
  ShapeRefPair pair;
  double smallest, largest;  ///< [m] the distances seen; 0: contact
};

/// Finds the checked pairs of links, each of one robot, that are within `distance` [m] in each of `states` random states of the
/// joints, without those that are in contact in each, and those with a joint of unknown range between them.
std::vector<AlwaysNear> findAlwaysNear(const SceneModel& model, double distance, int states = 300);

/// Thresholds of a pair that are below its usual distances and above contact, and at most `usual`.
///
/// Stop is half of a reference, and warn three quarters of it, rounded down to two digits. The reference is the smallest distance
/// seen; but if that is below 2 mm, which is less than what joints and meshes are exact to, the two may touch: then it is half of the
/// largest distance, if that is more.
StopAndWarn fittingThresholds(const AlwaysNear& pair, const StopAndWarn& usual);

/// Those of all pairs, where each of `near` has the ones that fit it.
LevelThresholds thresholdsWith(const std::vector<AlwaysNear>& near, const StopAndWarn& usual);

/// "stays at 15.6 mm", "stays between 11 mm and 20.5 mm", "stays between contact and 17.7 mm"
std::string distancesText(const AlwaysNear& pair);

/// A name as YAML has it, in quotes if YAML would take it for something else.
std::string yamlName(const std::string& name);

/// An entry of the parameters pair_stop_distance and pair_warn_distance: {links: [wrist_2_link, ee_link], distance: 0.0078}
std::string thresholdEntry(const RobotModel& robot, const ShapeRefPair& pair, double distance);

/// YAML of both parameters, an entry and a comment with the distances for each pair.
std::string thresholdsYaml(const RobotModel& robot, const std::vector<AlwaysNear>& pairs, const StopAndWarn& usual);

/// A sentence for people, with the lines that fit: wrist_2_link - ee_link stays at 15.6 mm whatever wrist_3_joint does:
/// pair_stop_distance: [{links: [wrist_2_link, ee_link], distance: 0.0078}], pair_warn_distance: [...]
std::string adviceText(const RobotModel& robot, const AlwaysNear& pair, const StopAndWarn& usual);

}  // namespace proximity_server::scene
