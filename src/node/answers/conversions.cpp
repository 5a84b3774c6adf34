#include "node/answers/conversions.h"

#include "proximity_server/ShapeKind.h"
#include "proximity_server/scene/loading/load_robot_model.h"
#include "proximity_server/scene/model/kinematics.h"

#include <algorithm>
#include <limits>
#include <optional>
#include <variant>

namespace proximity_server::node {
namespace {

const Eigen::Vector3d kUnknownPoint = Eigen::Vector3d::Constant(kNaN);

template <class Message>
void assign(Message& message, const Eigen::Vector3d& vector) {
  message.x = vector.x();
  message.y = vector.y();
  message.z = vector.z();
}

/// Transforms `point` into the frame that has this pose.
Eigen::Vector3d toFrame(const Eigen::Isometry3d& pose, const Eigen::Vector3d& point) {
  return pose.linear().transpose() * (point - pose.translation());
}

/// The link with which a shape moves: the link itself, or the link that holds the object; -1 if none holds it.
int linkOf(const RobotAndObjects& model, const scene::ShapeRef& ref) {
  if (!ref.isObject()) return ref.link();
  const auto* held = std::get_if<scene::Attached>(&model.objects->object(ref.object())->placement);
  return held ? model.robot.findLink(held->link) : -1;
}

/// Transforms `point` from the frame of the poses into the frame of linkOf(). Returns NaN if there is no such link, or
/// if its pose is not known.
Eigen::Vector3d inLink(const RobotAndObjects& model, const scene::BodyPoses& poses, const scene::ShapeRef& ref,
                       const Eigen::Vector3d& point) {
  const int index = linkOf(model, ref);
  if (index < 0) return kUnknownPoint;
  const scene::Link& link = model.robot.links[index];
  const std::optional<Eigen::Isometry3d>& pose = poses[link.body];
  return pose ? toFrame(link.body_T_link, toFrame(*pose, point)) : kUnknownPoint;
}

/// The state of a pair, as far as the bounds of its distance prove it.
std::uint8_t stateOf(const narrowphase::SignedDistance& result, double threshold) {
  if (result.status == narrowphase::Status::Unknown) return Proximity::UNKNOWN;
  if (result.lower_bound > threshold) return Proximity::BEYOND_THRESHOLD;
  if (result.lower_bound > 0.0) return Proximity::SEPARATED;
  if (result.upper_bound < 0.0 || result.status == narrowphase::Status::Threshold) return Proximity::PENETRATING;
  return result.status == narrowphase::Status::Converged ? Proximity::TOUCHING : Proximity::UNKNOWN;
}

void assignResult(Proximity& message, const narrowphase::SignedDistance& result, double threshold) {
  message.state = stateOf(result, threshold);
  const bool beyond = message.state == Proximity::BEYOND_THRESHOLD;
  message.distance = beyond ? result.lower_bound : result.distance;
  message.lower_bound = result.lower_bound;
  message.upper_bound = result.upper_bound;
  message.guaranteed = result.lower_bound;
  message.points_valid = result.has_points;
  assign(message.point_a, result.point_a);
  assign(message.point_b, result.point_b);
  assign(message.normal, result.normal);
  message.unique = result.unique;
  message.iterations = static_cast<std::uint16_t>(std::min<int>(result.iterations, UINT16_MAX));
}

ShapeInfo shapeInfo(const scene::RobotModel& robot, const scene::Collision& collision) {
  ShapeInfo info;
  assign(info.shape, RobotAndObjects(robot), scene::ShapeRef{collision.link, collision.number});
  info.description = collision.description;
  info.representation = static_cast<std::uint8_t>(collision.representation);
  info.deviation = collision.deviation;
  info.uncovered = collision.uncovered;
  info.volume_ratio = collision.volume_ratio;
  info.pieces = static_cast<std::uint32_t>(collision.pieces.size());
  for (const int index : collision.pieces) {
    const narrowphase::Shape& shape = robot.pieces[index].shape;
    if (shape.kind() == narrowphase::Shape::Kind::Hull)
      info.vertices += static_cast<std::uint32_t>(shape.hull().size());
  }
  return info;
}

void assignUnknownResult(Proximity& message) {
  message.state = Proximity::UNKNOWN;
  message.distance = message.lower_bound = message.upper_bound = message.guaranteed = kNaN;
  message.points_valid = message.unique = false;
  assign(message.point_a, kUnknownPoint);
  assign(message.point_b, kUnknownPoint);
  assign(message.normal, kUnknownPoint);
  assign(message.point_a_link, kUnknownPoint);
  assign(message.point_b_link, kUnknownPoint);
  message.iterations = 0;
}

LinkInfo linkInfo(const scene::RobotModel& robot, const scene::Link& link, const scene::ModelOptions& options) {
  LinkInfo info;
  info.name = link.name;
  info.padding = options.paddingOf(link.name);
  const scene::Body& body = robot.bodies[link.body];
  info.body = robot.links[body.link].name;
  for (const int index : link.collisions) {
    info.shapes.push_back(shapeInfo(robot, robot.collisions[index]));
  }
  return info;
}

PairInfo pairInfo(const scene::RobotModel& robot, const scene::LinkPair& pair) {
  PairInfo info;
  info.link_a = robot.links[pair.link_a].name;
  info.link_b = robot.links[pair.link_b].name;
  info.checked = pair.reason == scene::PairReason::Checked;
  info.reason = toString(pair.reason);
  info.detail = pair.detail;
  info.padding = pair.padding;
  return info;
}

}  // namespace

void assign(ShapeRef& message, const RobotAndObjects& model, const scene::ShapeRef& ref) {
  if (ref.isPoint() || ref.kind() == scene::ShapeRef::Kind::None) {
    clear(message);
    if (!ref.isPoint()) return;
    message.kind = ShapeKind::POINT;
    message.index = static_cast<std::uint32_t>(ref.point() + 1);
    return;
  }
  message.index = static_cast<std::uint32_t>(ref.collision());
  message.name.clear();
  const int link_of_ref = linkOf(model, ref);
  if (link_of_ref < 0)
    message.robot.clear();
  else
    message.robot = model.robot.robotOf(link_of_ref).name;
  if (ref.isObject()) {
    message.kind = ShapeRef::OBJECT;
    message.link = nameOf(ref, model.robot, model.objects);
    return;
  }
  message.kind = ShapeRef::LINK;
  const scene::Link& link = model.robot.links[ref.link()];
  message.link = link.name;
  if (ref.collision() > 0) message.name = model.robot.collisions[link.collisions[ref.collision() - 1]].name;
}

void clear(ShapeRef& message) {
  message.kind = ShapeRef::LINK;
  message.link.clear();
  message.index = 0;
  message.name.clear();
  message.robot.clear();
}

void reserveNames(ShapeRef& message, std::size_t characters) {
  for (std::string* name : {&message.link, &message.name, &message.robot}) name->reserve(characters);
}

void assign(Proximity& message, const RobotAndObjects& model, const scene::BodyPoses& poses,
            const scene::PairProximity& pair, const scene::Question& question) {
  assign(message.a, model, pair.asked.a.part(pair.collision_a));
  assign(message.b, model, pair.asked.b.part(pair.collision_b));
  message.gradient.clear();
  message.representation = static_cast<std::uint8_t>(pair.representation);
  message.depth_is_lower_bound = pair.depth_is_lower_bound;
  if (pair.result.status == narrowphase::Status::Unknown) {
    assignUnknownResult(message);
  } else {
    assignResult(message, pair.result, question.threshold);
    assign(message.point_a_link, inLink(model, poses, pair.asked.a, pair.result.point_a));
    assign(message.point_b_link, inLink(model, poses, pair.asked.b, pair.result.point_b));
  }
}

RayHit toMessage(const RobotAndObjects& model, const scene::Ray& ray, const scene::RayHit& hit) {
  RayHit message;
  assign(message.shape, model, hit.shape);
  const bool is_hit = hit.shape.kind() != scene::ShapeRef::Kind::None;
  message.state = hit.status != narrowphase::Status::Converged ? RayHit::UNKNOWN : is_hit ? RayHit::HIT : RayHit::FREE;
  message.distance = hit.distance;
  message.free_until = hit.free;
  assign(message.point, is_hit ? hit.pointOn(ray) : kUnknownPoint);
  assign(message.normal, hit.normal);
  return message;
}

Proximity toMessage(const RobotAndObjects& model, const scene::BodyPoses& poses, const scene::PairProximity& pair,
                    const scene::Question& question) {
  Proximity message;
  assign(message, model, poses, pair, question);
  return message;
}

void assignUnknown(Proximity& message) {
  clear(message.a);
  clear(message.b);
  message.gradient.clear();
  message.representation = Proximity::EXACT;
  message.depth_is_lower_bound = false;
  assignUnknownResult(message);
}

Proximity unknownProximity() {
  Proximity message;
  assignUnknown(message);
  return message;
}

Proximity beyondThreshold(double threshold) {
  Proximity message = unknownProximity();
  message.state = Proximity::BEYOND_THRESHOLD;
  message.distance = message.lower_bound = message.guaranteed = threshold;
  message.upper_bound = std::numeric_limits<double>::infinity();
  return message;
}

std::int8_t statusCode(const narrowphase::SignedDistance& result) {
  const bool decided =
      result.status == narrowphase::Status::Converged || result.status == narrowphase::Status::Threshold;
  return decided ? QueryStatus::OK : QueryStatus::NOT_CONVERGED;
}

ModelInfo toMessage(const Robot& robot, const ros::Time& loaded) {
  const scene::RobotModel& model = robot.robotModel();
  const scene::PairTable& pairs = robot.sceneModel().pairs;
  ModelInfo message;
  message.header.stamp = loaded;
  message.header.frame_id = robot.referenceFrame();
  message.robot = model.name;
  for (const scene::Link& link : model.links) message.links.push_back(linkInfo(model, link, robot.config().model));
  for (const scene::LinkPair& pair : pairs.pairs) message.pairs.push_back(pairInfo(model, pair));
  message.pairs_checked = static_cast<std::uint32_t>(pairs.checked.size());
  message.warnings = model.warnings;
  message.warnings.insert(message.warnings.end(), pairs.warnings.begin(), pairs.warnings.end());
  return message;
}

}  // namespace proximity_server::node
