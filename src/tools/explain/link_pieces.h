#pragma once

#include "tools/explain/explained_pair.h"
#include "tools/robot/robot_files.h"

#include <optional>
#include <string>

namespace proximity_server::tools {

/// Finds the two convex pieces of two links of a robot, in one state, that are closest or overlap deepest.
///
/// `state` is "joint=position joint=position ..." ([rad] or [m]), as the other tools print it; joints without a
/// position are at 0, and all of them for nullopt. Warnings go to standard error.
/// Failure: throws std::invalid_argument naming the file, the link or the joint.
ExplainedPair closestPieces(const RobotFiles& files, const std::string& link_a, const std::string& link_b,
                            const std::optional<std::string>& state);

}  // namespace proximity_server::tools
