#pragma once

#include <vector>

#include "node/robot/robot.h"
#include "proximity_server/QueryPairsRequest.h"
#include "proximity_server/StateProximity.h"
#include "proximity_server/scene/model/kinematics.h"

namespace proximity_server::node {

/// At the tolerance of the parameters, until Config::max_request_time from now.
scene::Question questionOf(const Robot& robot);

/// How exactly the options of a batch ask. Throws RequestError for a number that is not finite.
scene::Question questionOf(const Robot& robot, const QueryPairsRequest& request);

/// The threshold [m] of a request in which <= 0 means none. Throws RequestError where it is not finite.
double thresholdOrNone(double threshold);

/// One set of poses, which a scene is in, and what is wrong with it.
struct PosedState {
  const scene::BodyPoses& poses;
  const QueryStatus& status;
};

/// Asks a scene for what the mode of a batch wants to know of `pairs`. A pair without poses makes the state's status
/// that of the answer, one that the time did not suffice for makes it OVER_BUDGET. Throws RequestError for a mode that
/// does not exist.
StateProximity askPairs(const Robot& robot, scene::Scene& scene, const PosedState& state,
                        const std::vector<scene::ShapeRefPair>& pairs, const QueryPairsRequest& request,
                        const scene::Question& question);

/// Why pairs have no answer although tf knows all poses: the time of the request was over, or a pose is beyond what can
/// be computed with.
QueryStatus incompleteness(const Robot& robot, const scene::PairCounts& counts, const scene::Question& question);

}  // namespace proximity_server::node
