#include "node/answers/gradients.h"
#include "node/services/answered.h"
#include "node/services/joint_requests.h"
#include "node/services/pair_questions.h"
#include "node/services/queries.h"
#include "proximity_server/scene/derivative/free_motion.h"
#include "proximity_server/scene/model/kinematics.h"

#include <Eigen/Core>

#include <algorithm>
#include <chrono>
#include <optional>
#include <string>

namespace proximity_server::node {
namespace {

/// The question about pairs that is asked in every state.
QueryPairsRequest questionInEachState(const QueryConfigurationRequest& request) {
  QueryPairsRequest question;
  question.a = request.a;
  question.b = request.b;
  question.group = request.group;
  question.mode = request.mode;
  question.k = request.k;
  question.threshold = request.threshold;
  question.skip_penetration = request.skip_penetration;
  question.ignore_filter = request.ignore_filter;
  question.want_gradient = request.want_gradient;
  return question;
}

std::vector<JointValues> statesOf(const scene::RobotModel& robot, const QueryConfigurationRequest& request) {
  const MissingJoints missing = missingJoints(request.missing_joints);
  std::vector<JointValues> states;
  for (const sensor_msgs::JointState& state : request.states) {
    const std::string where = "state " + std::to_string(states.size());
    const std::vector<int> joints = jointsNamed(robot, state.name, where);
    states.push_back(completed(valuesOf(robot, joints, state.position, "position", where), missing));
  }
  return states;
}

/// Computes the free motions of a response.
class FreeMotions {
 public:
  /// The state must outlive it. Throws RequestError if the request is not about all checked pairs, and for a wrong motion.
  FreeMotions(const Robot& robot, const scene::State& state, const RequestedPairs& pairs,
              const QueryConfigurationRequest& request, const scene::Deadline& deadline)
      : free_(robot.sharedModel()), degrees_(state.degreesOfFreedom()) {
    if (pairs.list()) refuse("want_free_motion is about all checked pairs: a, b and group must be empty");
    const double distance = finite(request.free_motion_distance, "free_motion_distance");
    question_.thresholds = {distance, distance};
    question_.influence_distance += distance;
    question_.deadline = deadline;
    if (request.motion.name.empty() && request.motion.position.empty()) return;
    const scene::RobotModel& model = robot.robotModel();
    const JointValues motion = valuesOf(model, jointsNamed(model, request.motion.name, "motion"),
                                        request.motion.position, "position", "motion");
    motion_.setZero(degrees_.size());
    for (int i = 0; i < degrees_.size(); ++i) motion_[i] = motion[degrees_[i].joint].value_or(0.0);
  }

  /// Adds the free motions of a state.
  void add(PosedScenes& scenes, QueryConfigurationResponse& response) {
    free_.find(scenes.scene, scenes.state, question_);
    for (int i = 0; i < degrees_.size(); ++i) response.free_motion.push_back(free_.alone(i));
    if (motion_.size() > 0) response.free_scale.push_back(free_.scale(motion_));
  }

 private:
  scene::FreeMotion free_;
  const scene::DegreesOfFreedom& degrees_;
  scene::FreeMotionQuestion question_;
  Eigen::VectorXd motion_;  ///< empty if the request has none
};

/// The status of the first state that has no answer; if all have one, of the first that breaks an inequality.
QueryStatus summary(const std::vector<StateProximity>& states) {
  const auto has_none = [](const StateProximity& state) { return state.status.code != QueryStatus::OK; };
  auto state = std::find_if(states.begin(), states.end(), has_none);
  if (state == states.end())
    state = std::find_if(states.begin(), states.end(), [](const auto& each) { return !each.status.message.empty(); });
  if (state == states.end()) return {};
  return statusOf(state->status.code, "state " + std::to_string(state - states.begin()) + ": " + state->status.message);
}

}  // namespace

QueryConfigurationResponse answer(const Robot& robot, TfPoses& tf, const QueryConfigurationRequest& request) {
  return answered(QueryConfigurationResponse(), [&](QueryConfigurationResponse& response) {
    const QueryPairsRequest in_each = questionInEachState(request);
    const scene::Question question = questionOf(robot, in_each);
    const auto pairs = pairsOf(robot, in_each);
    requireAnswersWithinBatch(robot, in_each, pairs.size(), request.states.size());
    if (request.states.empty()) refuse("states is empty");
    const std::vector<JointValues> states = statesOf(robot.robotModel(), request);

    const JointSnapshot from_tf =
        missingFromTf(robot, tf, pairs.bodies(), states, request.stamp, coupledJoints(robot.robotModel(), states));
    response.header.stamp = from_tf.stamp;
    response.header.frame_id = robot.referenceFrame();
    const CarrierFrames asked_frames = pairs.frames();
    FrameSnapshot frames = framesFromTf(robot, tf, asked_frames, from_tf, request.stamp);
    const QueryStatus& status = from_tf.status.code == QueryStatus::OK ? frames.status : from_tf.status;
    const ScenePool::Lease scenes = pairs.borrowScenes();
    scene::GuaranteedDistances* const guaranteed =
        guaranteedWithin(uncertaintyOf(robot, request.uncertainty), *scenes, question);
    std::optional<FreeMotions> free_motions;
    if (request.want_free_motion) free_motions.emplace(robot, scenes->state, pairs, request, question.deadline);
    for (const JointValues& state : states) {
      const scene::BodyPoses poses = inReference(robot, posesInRoot(robot, state, from_tf), from_tf.roots);
      placeFramesOfLinks(robot, asked_frames, poses, frames.poses);
      scenes->state.set(poses, frames.poses);
      response.states.push_back(askPairs(robot, *scenes, {poses, status}, pairs, in_each, question, guaranteed));
      QueryStatus& of_state = response.states.back().status;
      if (of_state.code == QueryStatus::OK) of_state.message = brokenText(robot, state, from_tf);
      if (free_motions) free_motions->add(*scenes, response);
    }
    if (in_each.want_gradient || free_motions) assignColumns(response.joint_names, scenes->state.degreesOfFreedom());
    response.status = summary(response.states);
  });
}

}  // namespace proximity_server::node
