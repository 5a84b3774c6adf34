#include "node/answers/conversions.h"
#include "node/objects/object_needs.h"
#include "node/services/answered.h"
#include "node/services/joint_requests.h"
#include "node/services/motion_requests.h"
#include "node/services/queries.h"
#include "proximity_server/scene/proof/prove_apart.h"
#include "system/durations.h"

#include <algorithm>
#include <limits>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace proximity_server::node {
namespace {

ProveJointBoxResponse emptyProof() {
  ProveJointBoxResponse response;
  response.lower_bound = kNaN;
  return response;
}

scene::JointBox namedIntervals(const scene::RobotModel& robot, const std::vector<JointInterval>& box) {
  std::vector<std::string> names;
  for (const JointInterval& interval : box) names.push_back(interval.name);
  const std::vector<int> joints = jointsNamed(robot, names, "box");
  scene::JointBox intervals;
  for (std::size_t i = 0; i < box.size(); ++i) {
    const std::string where = "box: joint '" + box[i].name + "' ";
    if (robot.joints[joints[i]].mimic) refuse(where + "follows another one, which has to be named in its place");
    finite(box[i].lower, "box: lower of joint '" + box[i].name + "'");
    finite(box[i].upper, "box: upper of joint '" + box[i].name + "'");
    if (box[i].lower > box[i].upper) refuse(where + "has lower above upper");
    intervals.push_back({joints[i], box[i].lower, box[i].upper});
  }
  return intervals;
}

/// The joints that move the bodies, without mimic joints, and that the box does not have.
std::vector<int> missingIn(const scene::JointBox& box, const Robot& robot, const std::vector<int>& bodies) {
  std::vector<int> missing;
  for (const int edge : edgesTo(robot, bodies)) {
    if (edge >= static_cast<int>(robot.robotModel().joints.size())) continue;
    const int leader = robot.robotModel().leaderOf(edge).joint;
    if (scene::intervalOf(box, leader) || !scene::hasOnePosition(robot.robotModel().joints[leader])) continue;
    if (std::count(missing.begin(), missing.end(), leader) == 0) missing.push_back(leader);
  }
  return missing;
}

/// Adds the joints that the request does not name.
void addMissing(scene::JointBox& box, const std::vector<int>& missing, const Robot& robot, std::uint8_t code,
                const JointSnapshot& from_tf) {
  const scene::JointBox limits = scene::knownRanges(robot.robotModel());
  for (const int joint : missing) {
    if (code == ProveJointBoxRequest::WITHIN_LIMITS) {
      if (const scene::JointRange* range = scene::intervalOf(limits, joint)) box.push_back(*range);
      continue;  // proveApart() names a joint without limits, if the pairs need it
    }
    const double position =
        code == ProveJointBoxRequest::FROM_TF ? presentPosition(robot, joint, from_tf, /*next=*/0.0) : 0.0;
    box.push_back({joint, position, position});
  }
}

/// The objects of a node, with their numbers, in frames of links or at rest relative to the root of the robot.
class ObjectsForProof {
 public:
  ObjectsForProof(const Robot& robot, const scene::Objects& objects, const FrameSnapshot& frames,
                  const JointSnapshot& from_tf)
      : robot_(robot), objects_(objects), frames_(frames) {
    if (robot.referenceLink() < 0) root_T_reference_ = from_tf.roots.at(0).value().inverse();
  }

  std::shared_ptr<const scene::Objects> placed() const {
    std::vector<scene::ObjectChange> changes;
    for (const int number : objects_.numbers()) {
      scene::Object object = *objects_.object(number);
      if (std::holds_alternative<scene::Attached>(object.placement)) continue;
      object.placement = placementOf(number, object);
      changes.emplace_back(scene::ReplaceObject{std::move(object)});
    }
    return std::make_shared<const scene::Objects>(objects_.changed(changes));
  }

 private:
  scene::Placement placementOf(int number, const scene::Object& object) const {
    if (const auto* fixed = std::get_if<scene::Fixed>(&object.placement)) return inReference(fixed->world_T_object);
    const auto& moving = std::get<scene::Moving>(object.placement);
    const int link = robot_.linkOfFrame(moving.frame);
    if (link >= 0) return scene::Moving{robot_.robotModel().links[link].name, moving.frame_T_object};
    return inReference(frames_.poses.at(objects_.frameOf(number)).value() * moving.frame_T_object);
  }

  scene::Placement inReference(const Eigen::Isometry3d& reference_T_object) const {
    if (robot_.referenceLink() < 0) return scene::Fixed{root_T_reference_ * reference_T_object};
    return scene::Moving{robot_.robotModel().links[robot_.referenceLink()].name, reference_T_object};
  }

  const Robot& robot_;
  const scene::Objects& objects_;
  const FrameSnapshot& frames_;
  Eigen::Isometry3d root_T_reference_ = Eigen::Isometry3d::Identity();
};

std::vector<scene::ShapeRefPair> listOf(const Robot& robot, const RequestedPairs& pairs) {
  if (pairs.size() > static_cast<std::size_t>(robot.config().max_batch))
    throw RequestError(QueryStatus::OVER_BUDGET, "the request is about " + std::to_string(pairs.size()) +
                                                     " pairs, max_batch is " +
                                                     std::to_string(robot.config().max_batch));
  if (pairs.list()) return *pairs.list();
  std::vector<scene::ShapeRefPair> list = robot.candidates().list();
  pairs.objects().forEachCheckedPair([&](const scene::ShapeRef& a, const scene::ShapeRef& b) {
    list.push_back({a, b});
  });
  return list;
}

std::uint8_t codeOf(scene::ProofOutcome outcome) {
  switch (outcome) {
    case scene::ProofOutcome::Proven:
      return PairProof::PROVEN;
    case scene::ProofOutcome::Refuted:
      return PairProof::REFUTED;
    case scene::ProofOutcome::Undecided:
      break;
  }
  return PairProof::UNDECIDED;
}

PairProof toMessage(const RobotAndObjects& model, const scene::PairProof& proof) {
  const auto nameOf = [&](const scene::JointRange& interval) { return model.robot.joints[interval.joint].name; };
  PairProof message;
  assign(message.a, model, proof.pair.a);
  assign(message.b, model, proof.pair.b);
  message.outcome = codeOf(proof.outcome);
  message.lower_bound = proof.lower_bound;
  message.closest_upper_bound = proof.closest.empty() ? kNaN : proof.closest_upper_bound;
  message.undecided = proof.undecided;
  for (const scene::JointRange& interval : proof.closest.empty() ? scene::JointBox() : proof.box) {
    message.closest.name.push_back(nameOf(interval));
    message.closest.position.push_back(proof.closest.at(interval.joint));
  }
  for (const scene::JointRange& interval : proof.worst) {
    message.worst.emplace_back();
    message.worst.back().name = nameOf(interval);
    message.worst.back().lower = interval.lower;
    message.worst.back().upper = interval.upper;
  }
  return message;
}

/// Fills what is said about the pairs.
void fill(ProveJointBoxResponse& response, const RobotAndObjects& model, std::vector<scene::PairProof> proofs) {
  const auto rank = [](const scene::PairProof& proof) {
    return std::pair((codeOf(proof.outcome) + 1) % 3, proof.lower_bound);  // refuted, undecided, proven
  };
  std::stable_sort(proofs.begin(), proofs.end(),
                   [&](const scene::PairProof& one, const scene::PairProof& other) { return rank(one) < rank(other); });
  response.lower_bound = std::numeric_limits<double>::infinity();
  std::size_t proven = 0, undecided = 0;
  for (const scene::PairProof& proof : proofs) {
    response.lower_bound = std::min(response.lower_bound, proof.lower_bound);
    proven += proof.outcome == scene::ProofOutcome::Proven;
    undecided += proof.outcome == scene::ProofOutcome::Undecided;
    response.pairs.push_back(toMessage(model, proof));
  }
  response.proven = proven == proofs.size();
  if (undecided > 0)
    response.status =
        statusOf(QueryStatus::OVER_BUDGET, std::to_string(undecided) + " of " + std::to_string(proofs.size()) +
                                               " pairs are undecided: time_budget or most_boxes ended");
}

std::vector<scene::PairProof> prove(const Robot& robot, const std::vector<scene::ShapeRefPair>& pairs,
                                    const scene::JointBox& box, const scene::ProofQuestion& question) {
  try {
    return scene::proveApart(robot.sharedModel(), pairs, box, question);
  } catch (const std::invalid_argument& error) {
    refuse(error.what());
  }
}

}  // namespace

ProveJointBoxResponse answer(const Robot& robot, TfPoses& tf, const ProveJointBoxRequest& request) {
  return answered(emptyProof(), [&](ProveJointBoxResponse& response) {
    if (request.missing_joints > ProveJointBoxRequest::WITHIN_LIMITS)
      refuse("missing_joints " + std::to_string(request.missing_joints) + " does not exist");
    if (robot.robotModel().robots.size() > 1) refuse("nothing can be proven of several robots: their roots may move");
    scene::ProofQuestion question;
    const double contact_distance = notNegative(request.contact_distance, "contact_distance");
    question.contact_distance = contact_distance > 0.0 ? contact_distance : scene::kContactDistance;
    if (request.most_boxes > 0) question.most_boxes = request.most_boxes;
    const double budget = timeBudget(robot, request.time_budget);
    scene::JointBox box = namedIntervals(robot.robotModel(), request.box);
    const auto pairs = pairsOf(robot, request.a, request.b, filterOf(request.ignore_filter));
    const std::vector<scene::ShapeRefPair> list = listOf(robot, pairs);

    const std::vector<int> missing = missingIn(box, robot, pairs.bodies());
    const bool asks_tf = request.missing_joints == ProveJointBoxRequest::FROM_TF;
    const JointSnapshot from_tf =
        missingFromTf(robot, tf, {}, {}, request.stamp, asks_tf ? missing : std::vector<int>());
    response.header.stamp = from_tf.stamp;
    response.header.frame_id = robot.referenceFrame();
    require(from_tf.status);
    addMissing(box, missing, robot, request.missing_joints, from_tf);
    const FrameSnapshot frames = framesFromTf(robot, tf, framesOf(pairs.objects()), from_tf, request.stamp);
    require(frames.status);
    if (!pairs.objects().empty()) question.objects = ObjectsForProof(robot, pairs.objects(), frames, from_tf).placed();
    question.deadline = system::deadlineIn(budget);
    fill(response, {robot.robotModel(), &pairs.objects()}, prove(robot, list, box, question));
  });
}

}  // namespace proximity_server::node
