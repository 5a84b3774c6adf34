#pragma once

#include "node/answers/gradients.h"
#include "node/answers/guarantees.h"
#include "node/robot/robot.h"
#include "node/services/requests.h"
#include "proximity_server/QueryPairsRequest.h"
#include "proximity_server/StateProximity.h"
#include "proximity_server/scene/model/kinematics.h"

#include <optional>
#include <vector>

namespace proximity_server::node {

/// A question with the tolerance of the parameters and a deadline of Config::max_request_time from now.
scene::Question questionOf(const Robot& robot);

/// The question that the options of a request describe. Throws RequestError for a number that is not finite.
scene::Question questionOf(const Robot& robot, const QueryPairsRequest& request);

/// The threshold [m] of a request; it is infinite if the number is <= 0, which means none. Throws RequestError if the
/// number is not finite.
double thresholdOrNone(double threshold);

/// The poses of a scene, with a status that names the first pose that is missing.
struct PosedState {
  const scene::BodyPoses& poses;
  const QueryStatus& status;
};

/// Makes the object that computes the gradients of the requested pairs; nullopt if the request does not want gradients.
std::optional<Gradients> gradientsOf(const Robot& robot, const RequestedPairs& pairs, const QueryPairsRequest& request);

/// Makes the object that computes the guaranteed distances of the requested pairs within an uncertainty: the text of a
/// request, or if it is empty that of the parameters. They end at the deadline of the question. nullopt if nothing is
/// uncertain. Throws RequestError naming the field of the text that is wrong.
std::optional<Guarantees> guaranteesOf(const Robot& robot, const RequestedPairs& pairs, const std::string& uncertainty,
                                       const scene::Question& question);

/// OVER_BUDGET if the time for guaranteed distances was over, so that they are coarse; otherwise OK.
QueryStatus statusOf(const Robot& robot, const Guarantees& guarantees);

/// Writes gradients and guaranteed distances into the messages of pairs, if the request wants them.
struct PairDetails {
  std::optional<Gradients> gradients;
  std::optional<Guarantees> guarantees;

  void update(const scene::BodyPoses& poses, const scene::FramePoses& frames);
  void assign(Proximity& message, const scene::PairProximity& pair);
};

/// Asks a scene about `pairs` in the mode of the request, and adds the details, which have the same poses. If a
/// pose of some pair is missing, the answer has the status of `state`. If the deadline has passed before all pairs were
/// computed, the status is OVER_BUDGET. Throws RequestError for a mode that does not exist.
StateProximity askPairs(const Robot& robot, scene::Scene& scene, const PosedState& state, const RequestedPairs& pairs,
                        const QueryPairsRequest& request, const scene::Question& question, PairDetails& details);

}  // namespace proximity_server::node
