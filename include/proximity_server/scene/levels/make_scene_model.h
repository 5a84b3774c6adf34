#pragma once

#include "proximity_server/scene/levels/level_thresholds.h"
#include "proximity_server/scene/scene_model/scene_model.h"

#include <string>
#include <vector>

namespace proximity_server::scene {

/// A robot with its pairs, see filterPairs(), and one more warning about checked pairs between which there is only one
/// joint, but that are in contact over its whole range. That is nearly always an overlap of the model itself.
///
/// Failure: throws as filterPairs() does.
SceneModel makeSceneModel(RobotModel robot, const std::string& srdf_xml, const PairFilterOptions& options = {});

/// Takes an SRDF for each of RobotModel::robots.
SceneModel makeSceneModel(RobotModel robot, const std::vector<std::string>& srdf_xmls,
                          const PairFilterOptions& options = {});

/// A pair that is not checked, and how near it was seen.
struct DisabledPair {
  int pair;         ///< index into PairTable::pairs
  double smallest;  ///< [m] at most its stop distance; 0: contact
};

/// The pairs that the SRDF disables, but that were seen at or below their stop distance: nothing warns when they come
/// near. MoveIt's assistant looks for contact only, and so disables pairs that come that near. Those disabled on purpose
/// are left out: neighbours, pairs that were in contact in each state, and those with a reason, see isDecision().
///
/// Looks at random states, which are the same each time: 1000 states, or fewer if there are very many such pairs.
std::vector<DisabledPair> disabledPairsBelow(const SceneModel& model, const PairDistances& stop);

/// Adds warnings about pairs that the thresholds do not fit: the pairs of disabledPairsBelow() by name, and each
/// checked pair of links that is at or below its stop distance in every state, see findAlwaysNear(), with thresholds
/// that fit.
void warnOfNearPairs(SceneModel& model, const LevelThresholds& thresholds);

}  // namespace proximity_server::scene
