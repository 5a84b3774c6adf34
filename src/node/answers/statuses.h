#pragma once

#include "node/robot/robot.h"
#include "proximity_server/QueryStatus.h"
#include "proximity_server/scene/motion/motion_question.h"
#include "proximity_server/scene/query/question.h"

#include <string>

// The statuses of answers that may be incomplete.

namespace proximity_server::node {

/// The status of an answer in which some pairs, or what `noun` says, are unknown although tf knows all poses: OVER_BUDGET if the deadline has
/// passed, otherwise TF_UNAVAILABLE, because a pose is so far away that the numbers overflow.
QueryStatus incompleteness(const Robot& robot, const scene::PairCounts& counts, const scene::Question& question,
                           const std::string& noun = "pairs");

/// The status of a search along a motion: TF_UNAVAILABLE if a pose or all geometry of some pairs is missing, otherwise
/// OK.
QueryStatus completeness(const scene::MotionCounts& counts);

/// The status of a search: OK if it is complete, OVER_BUDGET if the deadline has ended it, otherwise NOT_CONVERGED.
QueryStatus statusOf(narrowphase::Status status, const scene::MotionQuestion& question);

/// The status of a search for contact, which is free until `t_free` [s].
QueryStatus statusOfContact(const scene::RobotTimeOfContact& found, double t_free,
                            const scene::MotionQuestion& question);

}  // namespace proximity_server::node
