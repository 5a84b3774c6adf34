#pragma once

#include "node/robot/robot.h"
#include "node/services/requests.h"
#include "proximity_server/QueryPairsRequest.h"
#include "proximity_server/StateProximity.h"
#include "proximity_server/scene/model/kinematics.h"

#include <string>

namespace proximity_server::node {

/// A question with the tolerance of the parameters and a deadline of Config::max_request_time from now.
scene::Question questionOf(const Robot& robot);

/// The question that the options of a request describe. Throws RequestError for a number that is not finite.
scene::Question questionOf(const Robot& robot, const QueryPairsRequest& request);

/// The threshold [m] of a request; it is infinite if the number is <= 0, which means none. Throws RequestError if the
/// number is not finite.
double thresholdOrNone(double threshold);

/// The uncertainty of a text of a request, or if it is empty, of the parameters. Throws RequestError naming the field
/// of the text that is wrong.
scene::Uncertainty uncertaintyOf(const Robot& robot, const std::string& text);

/// The guaranteed distances within an uncertainty; nullptr if nothing is uncertain. They end at the deadline of the
/// question.
scene::GuaranteedDistances* guaranteedWithin(const scene::Uncertainty& uncertainty, PosedScenes& scenes,
                                             const scene::Question& question);

/// OVER_BUDGET if the time for guaranteed distances was over, so that they are coarse; otherwise OK.
QueryStatus statusOf(const Robot& robot, const scene::GuaranteedDistances& guaranteed);

/// The poses of a state as they were found, with a status that names the first pose that is missing.
struct FoundPoses {
  const scene::BodyPoses& poses;
  const QueryStatus& status;
};

/// Asks about `pairs` in the mode of the request, with their gradients if it wants them, and their guaranteed distances
/// unless `guaranteed` is nullptr. If a pose of some pair is missing, the answer has the status of `found`. If the
/// deadline has passed before all pairs were computed, the status is OVER_BUDGET. Throws RequestError for a mode that
/// does not exist.
StateProximity askPairs(const Robot& robot, PosedScenes& scenes, const FoundPoses& found, const RequestedPairs& pairs,
                        const QueryPairsRequest& request, const scene::Question& question,
                        scene::GuaranteedDistances* guaranteed);

}  // namespace proximity_server::node
