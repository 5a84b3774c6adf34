#pragma once

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "proximity_server/scene/filter/pair_filter.h"
#include "proximity_server/scene/query/pair_distances.h"

namespace proximity_server::scene {

/// Distances [m] that users give pairs by name. A pair goes before a link, a link before an SRDF group, a group before the
/// default; of equals the larger counts. Links and groups count for pairs with objects too.
struct DistanceRules {
  std::vector<std::pair<PairFilterOptions::Names, double>> of_pairs;
  std::map<std::string, double> of_links;
  std::map<std::string, double> of_groups;  ///< of all links that move when the joints of the group do
};

/// At or below which distances a pair is at a level.
struct LevelThresholds {
  PairDistances stop{0.02, 0.02}, warn{0.05, 0.05};
};

/// The same by name; the defaults are those of `LevelThresholds`.
struct ThresholdRules {
  DistanceRules stop, warn;
};

/// The thresholds of a robot with an SRDF for each of RobotModel::robots ("" if there is none), in place of those that `defaults` has
/// for single pairs.
///
/// Failure: throws std::invalid_argument naming the list ("pair_stop_distance") and the link or group that does not exist or has no
///          collision geometry, the number that is negative or not finite, and the pair whose stop distance is above its warn distance.
LevelThresholds levelThresholds(const RobotModel& model, const std::vector<std::string>& srdf_xmls,
                                const ThresholdRules& rules, const LevelThresholds& defaults = {});

/// The thresholds of a file.
struct ThresholdFile {
  LevelThresholds defaults;
  ThresholdRules rules;
};

/// Reads YAML with the names that the node's parameters have: stop_distance, warn_distance, object_stop_distance,
/// object_warn_distance, pair_stop_distance: [{links: [a, b], distance: 0.01}], link_stop_distance: {link: 0.01},
/// group_stop_distance, and the same of warn_distance. What is not there keeps its default.
///
/// Failure: throws std::invalid_argument naming `source`, the line, the field and the reason.
ThresholdFile thresholdsFrom(const std::string& yaml, const std::string& source);

/// Throws std::invalid_argument naming a pair that has a stop distance above its warn distance ("the stop distance of wrist - hand is
/// 0.06, above ..."). Of pairs with objects it names the link.
void requireOrder(const RobotModel& model, const LevelThresholds& thresholds);

}  // namespace proximity_server::scene
