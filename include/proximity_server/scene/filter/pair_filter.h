#pragma once

#include "proximity_server/scene/model/robot_model.h"
#include "proximity_server/scene/scene_model/pair_table.h"

#include <string>
#include <utility>
#include <vector>

namespace proximity_server::scene {

struct PairFilterOptions {
  using Names = std::pair<std::string, std::string>;
  std::vector<Names> exclude_pairs;
  std::vector<Names> only_pairs;  ///< if empty, there is no restriction
  std::string group;              ///< a group of the SRDF; if empty, there is no restriction
  std::vector<std::pair<Names, double>> pair_padding;
};

/// Decides which pairs of links are checked: all but pairs of one body, neighbours, and pairs that SRDF or options
/// exclude.
///
/// `srdf_xml` may be empty. It is read for disable_collisions, enable_collisions, disable_default_collisions and groups
/// (links, joints, chains, subgroups). An enable_collisions brings back a pair that disable_default_collisions or
/// adjacency has excluded, but a disable_collisions of the same pair is stronger.
/// Failure: throws std::invalid_argument for XML that cannot be read, for a group that does not exist or contains
///          itself, and for a link of the options that does not exist. These become warnings: names of the SRDF that do
///          not exist, duplicates, entries without effect, and neighbours that are excluded without an entry or that
///          are checked.
PairTable filterPairs(const RobotModel& model, const std::string& srdf_xml, const PairFilterOptions& options = {});

/// Takes an SRDF for each of RobotModel::robots. Each SRDF is about its own robot alone; links, joints and groups have
/// the names there that they have in the robot's URDF. The options have the names of the model ("left/elbow", and the
/// group "left/arm"). So the pairs of two robots are checked unless the options exclude them.
/// Failure: as above, naming the robot; throws std::invalid_argument also if there is not one SRDF for each robot.
PairTable filterPairs(const RobotModel& model, const std::vector<std::string>& srdf_xmls,
                      const PairFilterOptions& options = {});

/// Tells for each of RobotModel::bodies whether it moves when the joints of an SRDF group move, including their mimic
/// joints.
/// Failure: throws std::invalid_argument as filterPairs() does, and for a group that does not exist. The message begins
///          with `named_by`, which says where the group is named.
std::vector<bool> bodiesMovedBy(const RobotModel& model, const std::vector<std::string>& srdf_xmls,
                                const std::string& group, const std::string& named_by);

}  // namespace proximity_server::scene
