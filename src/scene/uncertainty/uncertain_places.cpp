#include "scene/uncertainty/uncertain_places.h"

#include "scene/objects/object_geometry.h"
#include "scene/state/volumes.h"

#include <cmath>
#include <utility>
#include <variant>

namespace proximity_server::scene {

using Eigen::Isometry3d;
using Eigen::Vector3d;

namespace {

void addFrame(const PoseUncertainty& frame, int place, const Vector3d& origin, std::vector<Displacement>& chain) {
  if (frame.angle > 0.0) chain.push_back({Displacement::Kind::Tilt, place, frame.angle, origin});
  if (frame.translation > 0.0) chain.push_back({Displacement::Kind::Shift, place, frame.translation, origin});
}

/// The origin of an object in the frame of what carries it.
Vector3d originOf(const Object& object, const RobotModel& robot) {
  if (const auto* fixed = std::get_if<Fixed>(&object.placement)) return fixed->world_T_object.translation();
  if (const auto* moving = std::get_if<Moving>(&object.placement)) return moving->frame_T_object.translation();
  const auto& attached = std::get<Attached>(object.placement);
  return robot.links[robot.findLink(attached.link)].body_T_link * attached.link_T_object.translation();
}

}  // namespace

UncertainPlaces::UncertainPlaces(const std::shared_ptr<const SceneModel>& model)
    : model_(model), uncertainty_(model->robot), places_(model->robot.bodies.size()) {
  for (int joint = 0; joint < static_cast<int>(robot().joints.size()); ++joint)
    leaders_.push_back(robot().leaderOf(joint));
}

void UncertainPlaces::assume(const Uncertainty& uncertainty) {
  uncertainty.requireValidFor(robot());
  uncertainty_ = uncertainty;
  revision_ = 0;
}

UncertainPlaces::News UncertainPlaces::see(const State& state) {
  state_ = &state;
  if (state.revision() == revision_) return News::None;
  state.requireModel(*model_);
  const bool has_other_objects = state.objects() != objects_;
  objects_ = state.objects();
  if (has_other_objects || revision_ == 0) placeObjects();
  for (Place& place : places_) place.is_found = false;
  revision_ = state.revision();
  return has_other_objects ? News::Objects : News::Poses;
}

void UncertainPlaces::placeObjects() {
  object_frames_.resize(static_cast<std::size_t>(objects_->numberLimit()));
  for (const int number : objects_->numbers()) {
    const Object& object = objects_->placed(number)->object;
    object_frames_[number] = {uncertainty_.ofObject(object.id), scene::originOf(object, robot())};
  }
}

const Joint::Mimic* UncertainPlaces::leaderOf(const Displacement& own) const {
  const bool is_of_joint = own.kind == Displacement::Kind::Turn || own.kind == Displacement::Kind::Slide;
  return is_of_joint ? &leaders_[robot().bodies[own.place].joint] : nullptr;
}

Vector3d UncertainPlaces::jointOrigin(int body) const {
  const Body& moved = robot().bodies[body];
  const Joint& joint = robot().joints[moved.joint];
  if (joint.type != Joint::Type::Prismatic) return state_->poses()[body]->translation();
  return *state_->poses()[moved.parent] *
         (robot().links[joint.parent_link].body_T_link * joint.parent_T_joint.translation());
}

/// Adds the joint or the base of a body. Returns false if a pose is missing that is needed.
bool UncertainPlaces::addPlace(int body, std::vector<Displacement>& chain) const {
  const Body& moved = robot().bodies[body];
  const std::optional<Isometry3d>& pose = state_->poses()[body];
  if (moved.joint < 0) {
    const PoseUncertainty& base = uncertainty_.bases[moved.robot];
    if (base.isZero()) return true;
    if (pose) addFrame(base, body, pose->translation(), chain);
    return pose.has_value();
  }
  const Joint::Mimic& leader = leaders_[moved.joint];
  const double width = std::abs(leader.multiplier) * uncertainty_.positions[leader.joint];
  const PoseUncertainty& frame = uncertainty_.frames[moved.joint];
  if (width == 0.0 && frame.isZero()) return true;
  const bool slides = robot().joints[moved.joint].type == Joint::Type::Prismatic;
  if (!state_->knowsJointOf(body) || (slides && !state_->poses()[moved.parent])) return false;
  if (width > 0.0) {
    const UnitTwist twist = state_->twistOf(body);
    // Only slides may be in one group, see point 6 of Displacements.
    const bool is_together = slides && robot().joints[leader.joint].type == Joint::Type::Prismatic;
    chain.push_back({slides ? Displacement::Kind::Slide : Displacement::Kind::Turn, body, width, twist.origin,
                     slides ? twist.linear : twist.angular, is_together ? leader.joint : moved.joint,
                     is_together ? leader.multiplier : 1.0});
  }
  if (!frame.isZero()) addFrame(frame, body, jointOrigin(body), chain);
  return true;
}

const UncertainPlaces::Place& UncertainPlaces::placeOf(int body) {
  Place& place = places_[body];
  if (place.is_found) return place;
  place.is_found = true;
  place.displacements.clear();
  place.is_known = addPlace(body, place.displacements);
  return place;
}

Vector3d UncertainPlaces::originAt(int number, const Isometry3d& pose) const {
  const bool is_fixed = state_->objects()->placed(number)->kind == PlacedObject::Kind::Fixed;
  return is_fixed ? object_frames_[number].origin : Vector3d(pose * object_frames_[number].origin);
}

bool UncertainPlaces::place(const ShapeRef& ref, int place, DisplacedShape& shape) const {
  shape.chain.clear();
  shape.part = state_->volumes()->part(ref, state_->objects().get());
  const PlacedObject* object = shape.part.object;
  const std::optional<Isometry3d> pose = state_->poseOf(ref);
  if (!pose) return false;
  shape.pose = *pose;
  if (object)
    addFrame(object_frames_[ref.object()].uncertainty, place, originAt(ref.object(), shape.pose), shape.chain);
  return true;
}

}  // namespace proximity_server::scene
