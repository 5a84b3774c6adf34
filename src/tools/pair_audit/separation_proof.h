#pragma once

#include "proximity_server/scene/model/joint_ranges.h"
#include "proximity_server/scene/query/scene.h"
#include "tools/robot/robot_text.h"

#include <optional>

namespace proximity_server::tools {

/// The result of a search over all positions of the joints between two links.
struct SeparationProof {
  double lower_bound;                    ///< [m] no positions bring the two closer than this
  std::optional<scene::Positions> near;  ///< positions in which they are not proven to be farther than `near`, if found
};

/// Upper bounds of the change of the signed distance of two links per change of each joint of `ranges`: [m/rad] or
/// [m/m].
///
/// A prismatic joint moves all points of one side by its own displacement. A revolute joint moves a point by the angle
/// times its distance from the axis. Either side may be regarded as the moving one, so the bound is the smaller of the
/// two reaches from the joint's origin, for any positions of the other joints. The bound of a leader is the sum of the
/// bounds of its mimic joints and its own.
std::vector<double> sensitivities(const scene::RobotModel& robot, const std::vector<scene::JointRange>& ranges,
                                  const scene::ShapeRefPair& pair);

/// Searches for a proof that the signed distance of two links is above `near` [m] all over the box of `ranges`, which
/// are those of all joints that move the two relative to each other. Other joints are at 0.
///
/// The lower bound of a cell of the box is the distance at its centre less the largest change within the cell, which is
/// the sum of sensitivity times half width. The cell with the smallest bound is halved along the joint that contributes
/// most to this sum, until the bound is half-way from `near` to the smallest distance found, or the budget of queries
/// is spent. The number of cells grows exponentially with the number of joints: two or three joints can be settled,
/// long chains cannot. If the volume of the box shows beforehand that the budget cannot suffice, nothing is tried.
///
/// Source: Piyavskii, An Algorithm for Finding the Absolute Extremum of a Function, 1972, in several dimensions.
SeparationProof proveSeparation(scene::Scene& scene, const std::vector<scene::JointRange>& ranges,
                                const scene::ShapeRefPair& pair, double near = kContactDistance);

}  // namespace proximity_server::tools
