#pragma once

#include "proximity_server/scene/scene_model/scene_model.h"
#include "tools/model_check/findings.h"
#include "tools/pair_audit/level_shares.h"
#include "tools/pair_audit/pair_study.h"

#include <memory>
#include <string>
#include <vector>

// Each function makes one kind of check, and returns what it found.

namespace proximity_server::tools {

/// Expressions and elements of xacro that a URDF still has: nobody has expanded them. `file` is named.
std::vector<Finding> findXacro(const std::string& file, const std::string& urdf_xml);

/// The warnings about URDF, meshes and SRDF that the node logs.
std::vector<Finding> findWarnings(const scene::SceneModel& model);

/// Joints without limits, without a range or without a largest velocity, and mimic joints that leave their limits.
std::vector<Finding> findLimits(const scene::RobotModel& robot);

/// Meshes whose convex pieces lie farther than `tolerance` [m] outside of them.
std::vector<Finding> findInflation(const scene::RobotModel& robot, double tolerance);

/// Links that are seen and have no collision geometry, or whose visual geometry counts in its place, and those whose
/// visual geometry reaches farther than `tolerance` [m] out of it. `visual` is the robot with the visual geometry of each link in place of its collision geometry.
///
/// It is measured at the corners of the convex hull of each visual, and at points all over a round one: what a concave
/// collision geometry lacks between such points is not seen.
std::vector<Finding> findVisuals(const std::shared_ptr<const scene::SceneModel>& model, const scene::RobotModel& visual,
                                 double tolerance);

/// The URDF with its visual geometry in place of its collision geometry. Throws std::invalid_argument for broken XML.
std::string visualAsCollision(const std::string& urdf_xml);

/// Findings about neighbours, which no filter checks, about entries of an SRDF that the study contradicts, and about
/// checked pairs that are suspects, see PairLevels::isSuspect().
std::vector<Finding> findPairs(const scene::SceneModel& model, const PairStudy& study, const LevelShares& shares);

/// Pairs of links whose gap opens to more than `gap` [m] and closes below it: what fits between the two is caught there.
/// `study` has this distance. Source: ISO 13854, Minimum gaps to avoid crushing of parts of the human body, 2017.
std::vector<Finding> findPinchPoints(const scene::SceneModel& model, const PairStudy& study, double gap);

}  // namespace proximity_server::tools
