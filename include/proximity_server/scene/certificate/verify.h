#pragma once

#include "proximity_server/scene/certificate/certificate.h"
#include "proximity_server/scene/model/joint_ranges.h"
#include "proximity_server/scene/objects/objects.h"
#include "proximity_server/scene/scene_model/scene_model.h"

#include <optional>
#include <string>
#include <vector>

namespace proximity_server::scene {

/// Verifies a certificate by support functions alone: returns nullopt if it proves what it states for all states in
/// real numbers whose positions lie in the intervals of `box`, and else what is wrong with it.
///
/// It shares nothing with the search for proofs but the model: its room stands before those that could help it.
/// 1. Follow the tree from the whole box. A joint is divided within its interval, so the leaves cover the box.
/// 2. In a leaf, bound how far the points of each piece reach along each axis, see AxisHeights. The separation along an
///    axis is the gap between what a reaches forwards and what b reaches backwards.
/// 3. Each piece of a must be separated from each of b along one axis by the bound and the padding. A half-space has
///    its own normal as the axis.
/// 4. A shape may lie inside of a closed mesh without meeting its pieces. As no pieces meet in the whole box, it does so
///    in all states or in none; so the middle of the box tells, see Interior.
///
/// Error:   rounding is subtracted from all bounds.
/// Failure: throws std::invalid_argument for a link or an object that does not exist, and for objects whose frame is no
///          link.
std::optional<std::string> flawIn(const PairCertificate& certificate, const std::vector<JointRange>& box,
                                  const SceneModel& model, const Objects* objects = nullptr);

}  // namespace proximity_server::scene
