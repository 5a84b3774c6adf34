#pragma once

#include "proximity_server/scene/filter/pair_filter.h"
#include "proximity_server/scene/query/pair_distances.h"

#include <map>
#include <string>
#include <utility>
#include <vector>

namespace proximity_server::scene {

/// Distances [m] that users give to pairs by name. A rule for a pair is stronger than one for a link, a link is
/// stronger than an SRDF group, and a group is stronger than the default. Among equally strong rules the larger
/// distance counts. Links and groups count for pairs with objects, too.
struct DistanceRules {
  std::vector<std::pair<PairFilterOptions::Names, double>> of_pairs;
  std::map<std::string, double> of_links;
  std::map<std::string, double> of_groups;  ///< for all links that move when the joints of the group move
};

/// The distances at or below which a pair is at a level.
struct LevelThresholds {
  PairDistances stop{0.02, 0.02}, warn{0.05, 0.05};
};

/// Rules by name for the thresholds; `LevelThresholds` has the defaults.
struct ThresholdRules {
  DistanceRules stop, warn;
};

/// The thresholds of a robot with an SRDF for each of RobotModel::robots ("" if there is none). They replace the
/// thresholds that `defaults` has for single pairs.
///
/// Failure: throws std::invalid_argument, naming the list ("pair_stop_distance"), for a link or group that does not
///          exist or has no collision geometry, for a number that is negative or not finite, and for a pair whose stop
///          distance is above its warn distance.
LevelThresholds levelThresholds(const RobotModel& model, const std::vector<std::string>& srdf_xmls,
                                const ThresholdRules& rules, const LevelThresholds& defaults = {});

/// Throws std::invalid_argument, naming the pair, if a stop distance is above the warn distance ("the stop distance of
/// wrist - hand is 0.06, above ..."). For pairs with objects it names the link.
void requireOrder(const RobotModel& model, const LevelThresholds& thresholds);

}  // namespace proximity_server::scene
