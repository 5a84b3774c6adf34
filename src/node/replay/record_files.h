#pragma once

#include "node/replay/replay.h"

#include <string>
#include <vector>

namespace proximity_server::node {

/// The files of a stretch of a record in which robot and objects do not change.
struct RecordFiles {
  std::string folder;           ///< with robot.urdf, robot.srdf, objects.yaml and states.csv
  double mesh_tolerance = 0.0;  ///< [m] of the robot
  std::size_t states = 0;       ///< rows of states.csv
};

/// Writes a record as files that `clearance` and the other tools read: for each stretch a folder "1", "2", ... in
/// `folder`, which must exist. The SRDF disables every pair that the node does not check. There is a state for each
/// cycle with known poses; joints that move no checked pair have no column. The additions of the parameters to the
/// URDF are not in the files: padding, and mesh tolerances of single links.
/// Failure: throws std::invalid_argument as replay(); for several robots, for a planar or floating joint, which tables
///          of states do not have; if a file cannot be written; and if there is no state.
std::vector<RecordFiles> writeFiles(const ReplayOptions& options, const std::string& folder);

}  // namespace proximity_server::node
