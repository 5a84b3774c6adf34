#pragma once

#include <optional>

#include "proximity_server/scene/model/joint_ranges.h"
#include "proximity_server/scene/query/scene.h"

namespace proximity_server::tools {

/// [m] Two links count as in contact up to this distance: faces that are flush in the URDF are apart or overlap by the
/// rounding of its numbers (single precision in most meshes), which says nothing about the robot.
constexpr double kContactDistance = 1e-6;

/// What a search over all positions of the joints between two links found.
struct SeparationProof {
  /// [m] No position brings the two closer than this; not above kContactDistance: nothing is proven.
  double lower_bound;
  std::optional<scene::Positions> contact;  ///< positions in which the two are in contact, where the search met some
};

/// By how much the signed distance of two links changes with each of `ranges`, at most: [m/rad] or [m/m].
///
/// A prismatic joint moves all points of one side by as much as it moves. A revolute one moves a point by the angle
/// times its distance from the axis, and either side may be taken to be the moving one, so the smaller of the two
/// sides' reaches from the joint's origin counts, whatever the joints between do. A leader adds up what its followers
/// cause.
std::vector<double> sensitivities(const scene::RobotModel& robot, const std::vector<scene::JointRange>& ranges,
                                  const scene::ShapeRefPair& pair);

/// Looks for a lower bound of the signed distance of two links over the box of `ranges`, all that move them against
/// each other. Other joints are at 0.
///
/// A cell of the box is settled by the distance at its centre less what the joints can change within the cell, which is
/// the sum of sensitivity times half width. The cell with the smallest bound is halved along the joint that contributes
/// most to this sum, until the bound is half of the smallest distance met or the budget of queries is spent. The number
/// of cells grows with the power of the number of joints: two or three can be settled, long chains cannot, and where
/// the volume of the box shows that beforehand nothing is tried. Source: Piyavskii, An algorithm for finding the
/// absolute extremum of a function, 1972, in several dimensions.
SeparationProof proveSeparation(scene::Scene& scene, const std::vector<scene::JointRange>& ranges,
                                const scene::ShapeRefPair& pair);

}  // namespace proximity_server::tools
