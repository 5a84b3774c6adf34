#pragma once

#include "node/robot/robot.h"
#include "proximity_server/QueryStatus.h"
#include "proximity_server/scene/motion/moving_scene.h"
#include "proximity_server/scene/query/question.h"

// Why an answer is not complete.

namespace proximity_server::node {

/// The status for pairs that have no answer although tf knows all poses: the deadline has passed, or a pose is so far
/// away that the numbers overflow.
QueryStatus incompleteness(const Robot& robot, const scene::PairCounts& counts, const scene::Question& question);

/// OK, or TF_UNAVAILABLE if a pose or all geometry of some pairs is missing.
QueryStatus completeness(const scene::MotionCounts& counts);

/// OK if the search is complete; otherwise OVER_BUDGET if the deadline has passed, else NOT_CONVERGED.
QueryStatus statusOf(narrowphase::Status status, const scene::MotionQuestion& question);

}  // namespace proximity_server::node
