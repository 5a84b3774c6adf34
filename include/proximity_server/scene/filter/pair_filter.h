#pragma once

#include <string>
#include <utility>
#include <vector>

#include "proximity_server/scene/filter/pair_table.h"
#include "proximity_server/scene/model/robot_model.h"

namespace proximity_server::scene {

struct PairFilterOptions {
  using Names = std::pair<std::string, std::string>;
  std::vector<Names> exclude_pairs;
  std::vector<Names> only_pairs;  ///< empty: no restriction
  std::string group;              ///< of the SRDF; empty: no restriction
  std::vector<std::pair<Names, double>> pair_padding;
};

/// Decides which pairs of links are checked: all but those of one body, neighbours, and what SRDF or options leave out.
///
/// `srdf_xml` may be empty. disable_collisions, enable_collisions, disable_default_collisions and groups (links,
/// joints, chains, subgroups) count. An enable_collisions brings back what disable_default_collisions or adjacency
/// took, but yields to a disable_collisions of the same pair.
/// Failure: throws std::invalid_argument for XML that cannot be read, for a group that does not exist or contains
///          itself, and for a link of the options that does not exist. Names of the SRDF that do not exist, duplicates
///          and entries without effect become warnings, and so do neighbours that are left out silently or checked.
PairTable filterPairs(const RobotModel& model, const std::string& srdf_xml, const PairFilterOptions& options = {});

/// The same with an SRDF for each of RobotModel::robots. Each is about its own robot alone, whose links, joints and groups
/// have the names there that they have in the robot's URDF; the options have the names of the model ("left/elbow", and the
/// group "left/arm"). So the pairs of two robots are checked unless the options leave them out.
/// Failure: as above, naming the robot; throws std::invalid_argument also if there is not one SRDF for each robot.
PairTable filterPairs(const RobotModel& model, const std::vector<std::string>& srdf_xmls,
                      const PairFilterOptions& options = {});

/// Whether each of RobotModel::bodies moves when the joints of an SRDF group do, those that mimic them included.
/// Failure: throws std::invalid_argument as filterPairs() does, and for a group that does not exist.
std::vector<bool> bodiesMovedBy(const RobotModel& model, const std::vector<std::string>& srdf_xmls,
                                const std::string& group);

}  // namespace proximity_server::scene
