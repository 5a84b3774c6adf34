#include "node/answers/conversions.h"
#include "node/answers/statuses.h"
#include "node/objects/object_needs.h"
#include "node/services/answered.h"
#include "node/services/motion_requests.h"
#include "node/services/queries.h"
#include "proximity_server/scene/model/kinematics.h"
#include "system/durations.h"

namespace proximity_server::node {
namespace {

FirstContactResponse emptyFirstContact() {
  FirstContactResponse response;
  response.t_free = response.t_contact = kNaN;
  response.pair = unknownProximity();
  response.minimum = unknownMinimum();
  return response;
}

}  // namespace

FirstContactResponse answer(const Robot& robot, TfPoses& tf, const FirstContactRequest& request) {
  return answered(emptyFirstContact(), [&](FirstContactResponse& response) {
    scene::LevelThresholds thresholds;  // known with the objects
    scene::MotionQuestion question = motionQuestion(request.contact_distance, request.tolerance, thresholds.stop);
    const double budget = timeBudget(robot, request.time_budget);
    positive(request.horizon, "horizon");
    const auto pairs = pairsOf(robot, request.a, request.b, filterOf(request.ignore_filter));
    thresholds = robot.thresholdsWith(pairs.objects());
    const bool are_joints = !request.joints.name.empty();
    const PoseSnapshot start =
        tf.await(robot, are_joints ? withInequalities(robot, pairs.bodies()) : pairs.bodies(), request.stamp);
    response.header.stamp = start.stamp;
    response.header.frame_id = robot.referenceFrame();
    require(start.status);
    const CarrierFrames asked_frames = pairs.frames();
    const FrameSnapshot frames = tf.awaitFrames(robot, asked_frames, start, request.stamp);
    require(frames.status);
    const RequestedMotion requested = motionOf(robot, start, asked_frames, frames.poses, request);
    const scene::Motion& motion = requested.limited.motion;
    assignStops(response, robot, requested.limited, request.horizon);

    const RobotAndObjects model(robot.robotModel(), &pairs.objects());
    const ScenePool::Lease scenes = pairs.borrowScenes();
    scene::MotionSearch& search = scenes->motions();
    question.deadline = system::deadlineIn(budget);
    const scene::RobotTimeOfContact found = search.timeOfContact(pairs.asked(), motion, question);
    require(completeness(found.counts));
    response.status = statusOf(found.status, question);
    response.t_free = motion.timeAt(found.t_free);
    response.contact = found.contact;
    if (found.contact) {
      response.t_contact = motion.timeAt(found.t_contact);
      response.pair = toMessage(model, motion, found.t_contact, found.state, found.pair);
    } else if (!request.skip_minimum && response.status.code == QueryStatus::OK) {
      const scene::RobotMinimum minimum = search.minimum(pairs.asked(), motion, question);
      response.minimum = toMessage(model, motion, minimum);
      response.status = statusOf(minimum.status, question);
    }
    if (response.status.code == QueryStatus::OK) response.status.message = requested.text;
  });
}

}  // namespace proximity_server::node
