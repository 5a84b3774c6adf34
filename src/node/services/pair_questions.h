#pragma once

#include <vector>

#include "node/robot/robot.h"
#include "node/services/requests.h"
#include "proximity_server/QueryPairsRequest.h"
#include "proximity_server/StateProximity.h"
#include "proximity_server/scene/model/kinematics.h"

namespace proximity_server::node {

/// A question with the tolerance of the parameters and a deadline of Config::max_request_time from now.
scene::Question questionOf(const Robot& robot);

/// The question that the options of a batch describe. Throws RequestError for a number that is not finite.
scene::Question questionOf(const Robot& robot, const QueryPairsRequest& request);

/// The threshold [m] of a request in which <= 0 means none. Throws RequestError where it is not finite.
double thresholdOrNone(double threshold);

/// The poses of a scene, and the status that says which of them are missing.
struct PosedState {
  const scene::BodyPoses& poses;
  const QueryStatus& status;
};

/// Asks a scene the question of a batch's mode about `pairs`. A pair without poses makes the state's status
/// that of the answer, one that the time did not suffice for makes it OVER_BUDGET. Throws RequestError for a mode that
/// does not exist.
StateProximity askPairs(const Robot& robot, scene::Scene& scene, const PosedState& state, const RequestedPairs& pairs,
                        const QueryPairsRequest& request, const scene::Question& question);

/// The status for pairs that have no answer although tf knows all poses: the deadline has passed, or a pose is too far
/// away to compute with.
QueryStatus incompleteness(const Robot& robot, const scene::PairCounts& counts, const scene::Question& question);

}  // namespace proximity_server::node
