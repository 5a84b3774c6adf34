#pragma once

#include "proximity_server/scene/levels/level_thresholds.h"
#include "proximity_server/scene/scene_model/scene_model.h"

#include <string>
#include <vector>

// Pairs of links that are near in every state, by design, and stop and warn distances that fit them. With the distances
// of all other pairs they would raise an alarm that never ends.

namespace proximity_server::scene {

/// A stop and a warn distance [m].
struct StopAndWarn {
  double stop, warn;
};

/// Two links that were never seen far from each other.
struct AlwaysNear {
  ShapeRefPair pair;
  double smallest, largest;  ///< [m] the distances that were seen; 0: contact
};

/// Finds the checked pairs of links, each of one robot, that are within `distance` [m] in each of `states` random
/// states of the joints. Excludes pairs that are in contact in all states, and pairs with a joint of unknown range
/// between them.
std::vector<AlwaysNear> findAlwaysNear(const SceneModel& model, double distance, int states = 300);

/// Returns thresholds of a pair that are below its usual distances and above contact, and at most `usual`.
///
/// Stop is half of a reference, and warn is three quarters of it; both are rounded down to two digits. The reference is
/// the smallest distance that was seen. If that is below 2 mm, which is less than the accuracy of joints and meshes,
/// the two may touch; then the reference is half of the largest distance, if that is more.
StopAndWarn fittingThresholds(const AlwaysNear& pair, const StopAndWarn& usual);

/// The thresholds of all pairs, in which each pair of `near` has those that fit it.
LevelThresholds thresholdsWith(const std::vector<AlwaysNear>& near, const StopAndWarn& usual);

/// Returns a text: "stays at 15.6 mm", "stays between 11 mm and 20.5 mm", "stays between contact and 17.7 mm"
std::string distancesText(const AlwaysNear& pair);

/// An entry of the parameters pair_stop_distance and pair_warn_distance: {links: [wrist_2_link, ee_link], distance:
/// 0.0078}
std::string thresholdEntry(const RobotModel& robot, const ShapeRefPair& pair, double distance);

/// The YAML of both parameters, with an entry for each pair and a comment with its distances.
std::string thresholdsYaml(const RobotModel& robot, const std::vector<AlwaysNear>& pairs, const StopAndWarn& usual);

/// A sentence for people, with the parameters that fit: wrist_2_link - ee_link stays at 15.6 mm whatever wrist_3_joint
/// does: pair_stop_distance: [{links: [wrist_2_link, ee_link], distance: 0.0078}], pair_warn_distance: [...]
std::string adviceText(const RobotModel& robot, const AlwaysNear& pair, const StopAndWarn& usual);

}  // namespace proximity_server::scene
