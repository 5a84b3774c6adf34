#pragma once

#include <string>
#include <vector>

#include "proximity_server/scene/filter/scene_model.h"
#include "proximity_server/scene/levels/level_thresholds.h"

namespace proximity_server::scene {

/// The robot with its pairs, see filterPairs(), and one more warning: the checked pairs that one joint moves against
/// each other, but that are in contact all over its range. That is nearly always an overlap of the model itself.
///
/// Failure: throws as filterPairs() does.
SceneModel makeSceneModel(RobotModel robot, const std::string& srdf_xml, const PairFilterOptions& options = {});

/// The same with an SRDF for each of RobotModel::robots.
SceneModel makeSceneModel(RobotModel robot, const std::vector<std::string>& srdf_xmls,
                          const PairFilterOptions& options = {});

/// A pair that nobody checks, and how near it was seen.
struct DisabledPair {
  int pair;         ///< index into PairTable::pairs
  double smallest;  ///< [m] at most its stop distance; 0: contact
};

/// The pairs that the SRDF disables, but that were seen at or below their stop distance: nothing will tell when they come near. MoveIt's
/// assistant looks for contact only, and so disables pairs that come as near as that. Neighbours are left out, and pairs that were in
/// contact in each state: these are meant.
///
/// Looks at random states, the same ones each time: 1000, or fewer where there are very many such pairs.
std::vector<DisabledPair> disabledPairsBelow(const SceneModel& model, const PairDistances& stop);

/// Adds warnings about what the thresholds do not fit to: these pairs by name, and each checked pair of links that is at or below its stop
/// distance in every state, see findAlwaysNear(), with the thresholds that fit.
void warnOfNearPairs(SceneModel& model, const LevelThresholds& thresholds);

}  // namespace proximity_server::scene
