#pragma once

#include "node/answers/motions.h"
#include "node/services/requests.h"
#include "proximity_server/FirstContactRequest.h"
#include "proximity_server/scene/model/kinematics.h"

#include <string>

// These functions read the motion of a request.
// Failure: they throw RequestError INVALID_ARGUMENT naming the number, point, joint or link that is wrong.

namespace proximity_server::node {

/// The question that the numbers of a FirstContact or QueryTrajectory request describe, without a deadline. A tolerance
/// of 0 means the default. A contact distance of NaN means the stop distance of each pair; `stop` must outlive the
/// question.
scene::MotionQuestion motionQuestion(double contact_distance, double tolerance, const scene::PairDistances& stop);

/// The time budget [s] of a search; the default if `asked` is 0. Throws RequestError OVER_BUDGET if it exceeds
/// Config::max_request_time.
double timeBudget(const Robot& robot, const ros::Duration& asked);

/// The requested motion, with a text about the first inequality that it breaks and the turns that it assumes.
struct RequestedMotion {
  scene::LimitedMotion limited;
  std::string text;  ///< "": none
};
/// It starts at these poses.
RequestedMotion motionOf(const Robot& robot, const PoseSnapshot& start, const CarrierFrames& frames,
                         const scene::FramePoses& poses_of_frames, const FirstContactRequest& request);

}  // namespace proximity_server::node
