#include "scene/derivative/placed_joints.h"

#include "proximity_server/narrowphase/assertion.h"
#include "scene/model/body_pose.h"
#include "scene/objects/placed_object.h"
#include "scene/scene_model/given_model.h"

#include <algorithm>
#include <stdexcept>
#include <string>

namespace proximity_server::scene {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

bool needsParent(const Joint& joint) { return !hasOnePosition(joint); }

/// The axes of a planar joint in its own frame: two axes of the plane, and the normal.
Matrix3d planeAxes(const Vector3d& normal) { return turnFromZ(normal.normalized()).toRotationMatrix(); }

}  // namespace

ObjectCarriers carriersOnLinks(const Objects& objects) {
  const RobotModel& robot = objects.model().robot;
  ObjectCarriers carriers;
  for (const std::string& frame : objects.frames())
    carriers.of_frames.push_back(robot.links[robot.findLink(frame)].body);
  return carriers;
}

PlacedJoints::PlacedJoints(std::shared_ptr<const SceneModel> model)
    : model_(std::move(model)), degrees_of_freedom_(given(model_).robot), poses_(robot().bodies.size()) {}

void PlacedJoints::requireCountOf(const BodyPoses& poses) const {
  if (poses.size() != poses_.size())
    throw std::invalid_argument("the robot has " + std::to_string(poses_.size()) + " bodies, but there are " +
                                std::to_string(poses.size()) + " poses");
}

void PlacedJoints::update(const BodyPoses& poses) {
  requireCountOf(poses);
  for (std::size_t i = 0; i < poses.size(); ++i) poses_[i] = usablePose(poses[i]);
  std::fill(frames_.begin(), frames_.end(), std::nullopt);
}

void PlacedJoints::update(const BodyPoses& poses, const FramePoses& frames) {
  if (frames.size() != frames_.size())
    throw std::invalid_argument("the objects have " + std::to_string(frames_.size()) + " frames, but there are " +
                                std::to_string(frames.size()) + " poses");
  update(poses);
  std::transform(frames.begin(), frames.end(), frames_.begin(), usablePose);
}

void PlacedJoints::update(const BodyPoses& poses, const Scene& scene) {
  requireCountOf(poses);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    poses_[i] = scene.poseOf(static_cast<int>(i));
    if (!poses_[i]) poses_[i] = usablePose(poses[i]);
  }
  std::fill(frames_.begin(), frames_.end(), std::nullopt);
  if (!objects_) return;
  for (const int number : objects_->moving()) frames_[objects_->frameOf(number)] = scene.poseOfObject(number);
}

std::optional<Eigen::Isometry3d> PlacedJoints::poseOf(const ShapeRef& ref) const {
  if (ref.isLink()) return poses_[robot().links[ref.link()].body];
  const PlacedObject& object = *objects_->placed(ref.object());
  if (object.kind == PlacedObject::Kind::Attached) return poses_[object.body];
  if (object.kind == PlacedObject::Kind::Fixed) return object.world_T_object;
  return frames_[objects_->frameOf(ref.object())];
}

void PlacedJoints::use(std::shared_ptr<const Objects> objects) {
  ObjectCarriers carriers;
  if (objects) carriers.of_frames.assign(objects->frames().size(), -1);
  use(std::move(objects), std::move(carriers));
}

void PlacedJoints::use(std::shared_ptr<const Objects> objects, ObjectCarriers carriers) {
  if (objects && &objects->model() != model_.get())
    throw std::invalid_argument("the objects are those of another model");
  const std::size_t frames = objects ? objects->frames().size() : 0;
  if (carriers.of_frames.size() != frames)
    throw std::invalid_argument("the objects have " + std::to_string(frames) + " frames, but there are " +
                                std::to_string(carriers.of_frames.size()) + " carriers");
  const auto require_body = [&](int body) {
    if (body < -1 || body >= static_cast<int>(robot().bodies.size()))
      throw std::invalid_argument("the robot has no body " + std::to_string(body) + ", which carries objects");
  };
  require_body(carriers.of_fixed);
  for (const int body : carriers.of_frames) require_body(body);
  objects_ = std::move(objects);
  carriers_ = std::move(carriers);
  frames_.assign(frames, std::nullopt);
}

int PlacedJoints::bodyOf(const ShapeRef& ref) const {
  if (ref.isLink()) return robot().links[ref.link()].body;
  const PlacedObject* object = objects_ ? objects_->placed(ref.object()) : nullptr;
  if (!object) throw std::invalid_argument("there is no object of number " + std::to_string(ref.object()));
  switch (object->kind) {
    case PlacedObject::Kind::Attached:
      return object->body;
    case PlacedObject::Kind::Fixed:
      return carriers_.of_fixed;
    case PlacedObject::Kind::Moving:
      break;
  }
  return carriers_.of_frames[objects_->frameOf(ref.object())];
}

bool PlacedJoints::knowsJointOf(int body) const {
  const Body& moved = robot().bodies[body];
  return poses_[body] && (!needsParent(robot().joints[moved.joint]) || poses_[moved.parent]);
}

bool PlacedJoints::knowsBetween(int a, int b) const {
  bool known = true;
  forEachBetween(a, b, [&](int body, Side) { known = known && knowsJointOf(body); });
  return known;
}

UnitTwist PlacedJoints::twistOf(int body) const {
  const Joint& joint = robot().joints[robot().bodies[body].joint];
  PROXIMITY_ASSERT(hasOnePosition(joint) && poses_[body], "It is for joints with one position and a known pose.");
  const Vector3d origin = poses_[body]->translation();
  const Vector3d axis = poses_[body]->linear() * joint.axis;  // the joint does not move its own axis
  if (joint.type == Joint::Type::Prismatic) return {axis, Vector3d::Zero(), origin};
  return {Vector3d::Zero(), axis, origin};
}

JointTwists PlacedJoints::twistsOf(int body) const {
  PROXIMITY_ASSERT(narrowphase::isPlace(body, poses_.size()) && knowsJointOf(body),
                   "The pose of the body or of its parent is not known: ask knowsBetween() first.");
  const Body& moved = robot().bodies[body];
  const Joint& joint = robot().joints[moved.joint];
  JointTwists result;
  if (hasOnePosition(joint)) {
    result.twists[result.count++] = twistOf(body);
    return result;
  }
  const auto add = [&](const Vector3d& linear, const Vector3d& angular) {
    result.twists[result.count++] = {linear, angular, poses_[body]->translation()};
  };
  const Link& parent = robot().links[joint.parent_link];
  const Matrix3d at_rest = poses_[moved.parent]->linear() * parent.body_T_link.linear() * joint.parent_T_joint.linear();
  if (joint.type == Joint::Type::Planar) {
    const Matrix3d axes = at_rest * planeAxes(joint.axis);
    add(axes.col(0), Vector3d::Zero());
    add(axes.col(1), Vector3d::Zero());
    add(Vector3d::Zero(), axes.col(2));
    return result;
  }
  for (int i = 0; i < 3; ++i) add(at_rest.col(i), Vector3d::Zero());
  for (int i = 0; i < 3; ++i) add(Vector3d::Zero(), at_rest.col(i));
  return result;
}

Vector3d PlacedJoints::relativeTurn(int a, int b, const Eigen::Ref<const Eigen::VectorXd>& velocity) const {
  Vector3d turn = Vector3d::Zero();
  forEachBetween(a, b, [&](int body, Side side) {
    const JointTwists twists = twistsOf(body);
    const auto& own = degrees_of_freedom_.columnsOf(robot().bodies[body].joint);
    const double sign = side == Side::B ? own.multiplier : -own.multiplier;
    for (int i = 0; i < twists.count; ++i) turn += sign * velocity[own.first + i] * twists.twists[i].angular;
  });
  return turn;
}

}  // namespace proximity_server::scene
