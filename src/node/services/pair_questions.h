#pragma once

#include <optional>
#include <vector>

#include "node/answers/gradients.h"
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

/// The threshold [m] of a request in which <= 0 means none. Throws RequestError if it is not finite.
double thresholdOrNone(double threshold);

/// The poses of a scene, and the status that says which of them are missing.
struct PosedState {
  const scene::BodyPoses& poses;
  const QueryStatus& status;
};

/// The gradients of the pairs that a batch asks about; nullopt if it does not want them.
std::optional<Gradients> gradientsOf(const Robot& robot, const RequestedPairs& pairs, const QueryPairsRequest& request);

/// Asks a scene about `pairs`, as the mode of a batch says, and for `gradients` if there are some. If a pose of some pair is
/// missing, the answer has the status of `state`; if the deadline passed before some pair was computed, OVER_BUDGET. Throws
/// RequestError for a mode that does not exist.
StateProximity askPairs(const Robot& robot, scene::Scene& scene, const PosedState& state, const RequestedPairs& pairs,
                        const QueryPairsRequest& request, const scene::Question& question,
                        std::optional<Gradients>& gradients);

}  // namespace proximity_server::node
