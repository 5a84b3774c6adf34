#include "proximity_server/scene/state/state.h"

#include "proximity_server/narrowphase/assertion.h"
#include "scene/model/body_pose.h"
#include "scene/objects/placed_object.h"
#include "scene/scene_model/given_model.h"
#include "scene/state/placed_robot.h"

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace proximity_server::scene {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

bool needsParent(const Joint& joint) { return !hasOnePosition(joint); }

/// The axes of a planar joint in its own frame: two axes of the plane, and the normal.
Matrix3d planeAxes(const Vector3d& normal) { return turnFromZ(normal.normalized()).toRotationMatrix(); }

std::uint64_t nextRevision() {
  static std::atomic<std::uint64_t> last{0};
  return ++last;
}

/// The error is like "the robot has 3 bodies, but there are 2 poses".
void requireAsMany(std::size_t given, const char* noun, std::size_t count, const char* owner, const char* what) {
  if (given == count) return;
  throw std::invalid_argument(std::string(owner) + " " + std::to_string(count) + " " + what + ", but there are " +
                              std::to_string(given) + " " + noun);
}

const PlacedObject& existing(const Objects& objects, const ShapeRef& ref) {
  const PlacedObject* object = objects.placed(ref.object());
  if (!object) throw std::invalid_argument("there is no object of number " + std::to_string(ref.object()));
  return *object;
}

}  // namespace

ObjectCarriers carriersOnLinks(const Objects& objects) {
  const RobotModel& robot = objects.model().robot;
  ObjectCarriers carriers;
  for (const std::string& frame : objects.frames())
    carriers.of_frames.push_back(robot.links[robot.findLink(frame)].body);
  return carriers;
}

State::State(std::shared_ptr<const SceneModel> model)
    : State(model, std::make_shared<const DegreesOfFreedom>(given(model).robot),
            std::make_shared<const Volumes>(given(model).robot), std::make_shared<const Objects>(model), {}) {}

State::State(std::shared_ptr<const SceneModel> model, std::shared_ptr<const DegreesOfFreedom> degrees_of_freedom,
             std::shared_ptr<const Volumes> volumes, std::shared_ptr<const Objects> objects, ObjectCarriers carriers)
    : model_(std::move(model)),
      objects_(std::move(objects)),
      carriers_(std::move(carriers)),
      degrees_of_freedom_(std::move(degrees_of_freedom)),
      poses_(robot().bodies.size()),
      frames_(objects_->frames().size()),
      revision_(nextRevision()),
      placed_(std::make_unique<PlacedRobot>(model_->robot, std::move(volumes))) {}
State::~State() = default;
State::State(State&&) noexcept = default;
State& State::operator=(State&&) noexcept = default;

State State::forAnotherThread() const { return {model_, degrees_of_freedom_, volumes(), objects_, carriers_}; }

void State::requireModel(const SceneModel& model) const {
  if (&model != model_.get()) throw std::invalid_argument("the state is of another robot");
}

const std::shared_ptr<const Volumes>& State::volumes() const { return placed_->volumes(); }

const PlacedRobot& State::placed() const {
  if (placed_revision_ == revision_) return *placed_;
  if (placed_->objects() != objects_) placed_->use(objects_);
  placed_->update(poses_, frames_);
  placed_revision_ = revision_;
  return *placed_;
}

void State::set(std::shared_ptr<const Objects> objects) {
  ObjectCarriers carriers;
  if (objects) carriers.of_frames.assign(objects->frames().size(), -1);
  set(std::move(objects), std::move(carriers));
}

void State::set(std::shared_ptr<const Objects> objects, ObjectCarriers carriers) {
  if (!objects) throw std::invalid_argument("there are no objects");
  if (&objects->model() != model_.get()) throw std::invalid_argument("the objects are those of another model");
  requireAsMany(carriers.of_frames.size(), "carriers", objects->frames().size(), "the objects have", "frames");
  const auto require_body = [&](int body) {
    if (body < -1 || body >= static_cast<int>(robot().bodies.size()))
      throw std::invalid_argument("the robot has no body " + std::to_string(body) + ", which carries objects");
  };
  require_body(carriers.of_fixed);
  for (const int body : carriers.of_frames) require_body(body);
  FramePoses frames;
  for (const std::string& frame : objects->frames()) frames.push_back(poseOfFrame(frame));
  objects_ = std::move(objects);
  carriers_ = std::move(carriers);
  frames_ = std::move(frames);
  revision_ = nextRevision();
}

std::optional<Eigen::Isometry3d> State::poseOfFrame(const std::string& frame) const {
  const std::vector<std::string>& known = objects_->frames();
  const auto place = std::lower_bound(known.begin(), known.end(), frame);
  const bool is_known = place != known.end() && *place == frame;
  return is_known ? frames_[static_cast<std::size_t>(place - known.begin())] : std::nullopt;
}

void State::set(const BodyPoses& poses) {
  take(poses);
  std::fill(frames_.begin(), frames_.end(), std::nullopt);
}

void State::set(const BodyPoses& poses, const FramePoses& frames) {
  requireAsMany(frames.size(), "poses", frames_.size(), "the objects have", "frames");
  take(poses);
  std::transform(frames.begin(), frames.end(), frames_.begin(), usablePose);
}

void State::take(const BodyPoses& poses) {
  requireAsMany(poses.size(), "poses", poses_.size(), "the robot has", "bodies");
  std::transform(poses.begin(), poses.end(), poses_.begin(), usablePose);
  revision_ = nextRevision();
}

std::optional<Eigen::Isometry3d> State::poseOf(const ShapeRef& ref) const {
  if (ref.isLink()) return poses_[robot().links[ref.link()].body];
  const PlacedObject& object = existing(*objects_, ref);
  if (object.kind == PlacedObject::Kind::Attached) return poses_[object.body];
  if (object.kind == PlacedObject::Kind::Fixed) return object.world_T_object;
  return frames_[objects_->frameOf(ref.object())];
}

int State::bodyOf(const ShapeRef& ref) const {
  if (ref.isLink()) return robot().links[ref.link()].body;
  if (ref.isPoint()) return -1;
  const PlacedObject& object = existing(*objects_, ref);
  if (object.kind == PlacedObject::Kind::Attached) return object.body;
  if (object.kind == PlacedObject::Kind::Fixed) return carriers_.of_fixed;
  return carriers_.of_frames[objects_->frameOf(ref.object())];
}

bool State::knowsJointOf(int body) const {
  const Body& moved = robot().bodies[body];
  return poses_[body] && (!needsParent(robot().joints[moved.joint]) || poses_[moved.parent]);
}

bool State::knowsBetween(int a, int b) const {
  bool known = true;
  forEachBetween(a, b, [&](int body, Side) { known = known && knowsJointOf(body); });
  return known;
}

UnitTwist State::twistOf(int body) const {
  const Joint& joint = robot().joints[robot().bodies[body].joint];
  PROXIMITY_ASSERT(hasOnePosition(joint) && poses_[body], "It is for joints with one position and a known pose.");
  const Vector3d origin = poses_[body]->translation();
  const Vector3d axis = poses_[body]->linear() * joint.axis;  // the joint does not move its own axis
  if (joint.type == Joint::Type::Prismatic) return {axis, Vector3d::Zero(), origin};
  return {Vector3d::Zero(), axis, origin};
}

JointTwists State::twistsOf(int body) const {
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

Vector3d State::relativeTurn(int a, int b, const Eigen::Ref<const Eigen::VectorXd>& velocity) const {
  Vector3d turn = Vector3d::Zero();
  forEachBetween(a, b, [&](int body, Side side) {
    const JointTwists twists = twistsOf(body);
    const auto& own = degrees_of_freedom_->columnsOf(robot().bodies[body].joint);
    const double sign = side == Side::B ? own.multiplier : -own.multiplier;
    for (int i = 0; i < twists.count; ++i) turn += sign * velocity[own.first + i] * twists.twists[i].angular;
  });
  return turn;
}

}  // namespace proximity_server::scene
