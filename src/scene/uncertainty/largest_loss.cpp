#include "scene/model/numbers.h"
#include "scene/uncertainty/pair_bounds.h"

#include <algorithm>
#include <cmath>

namespace proximity_server::scene {

using Eigen::Isometry3d;
using Eigen::Vector3d;

/// Finds how far what each body carries can be from its origin: no farther than along the chain of origins to the
/// geometry of any body that it carries, whatever the angles of the joints are. Infinity for a body without a pose that
/// carries one with a pose, and for one that carries a half-space in the frame of a link.
void PairBounds::findRadii() {
  const RobotModel& robot = model_->robot;
  reach_ = held_reach_;
  reachCarriedObjects();
  radius_ = reach_;
  for (int body = static_cast<int>(robot.bodies.size()) - 1; body >= 0; --body) {  // parents come first
    if (!state_->poses()[body]) continue;
    int parent = robot.bodies[body].parent;
    for (; parent >= 0 && !state_->poses()[parent]; parent = robot.bodies[parent].parent) radius_[parent] = kInfinity;
    if (parent < 0) continue;
    const double between = (state_->poses()[body]->translation() - state_->poses()[parent]->translation()).norm();
    radius_[parent] = std::max(radius_[parent], (1.0 + kPoseRounding) * (between + radius_[body]));
  }
}

/// Adds to reach_ the objects that stand in the frame of a link. Their places on the body are known from poses only.
void PairBounds::reachCarriedObjects() {
  for (const int number : state_->objects()->numbers()) {
    const PlacedObject& placed = *state_->objects()->placed(number);
    const ShapeRef ref = ShapeRef::ofObject(number);
    const int body = state_->bodyOf(ref);
    const std::optional<Isometry3d> pose = state_->poseOf(ref);
    if (placed.kind == PlacedObject::Kind::Attached || body < 0 || !pose || !state_->poses()[body]) continue;
    const Bounds& bounds = partOf(placed).whole().bounds;
    const double between = (*pose * bounds.centre - state_->poses()[body]->translation()).norm();
    const double own = placed.isUnbounded() ? kInfinity : (1.0 + kPoseRounding) * (between + bounds.radius);
    reach_[body] = std::max(reach_[body], own);
  }
}

/// [m] How far the points move at most if each joint moves by its travel. Of slides alone: only they change the
/// distances along the chain of origins in findRadii(), where all poses of the chain are known.
PairBounds::TravelWays PairBounds::waysOf(const std::vector<double>& travel) const {
  const RobotModel& robot = model_->robot;
  TravelWays ways;
  for (std::size_t i = 0; i < robot.bodies.size() && !travel.empty(); ++i) {
    const int joint = robot.bodies[i].joint;
    if (joint < 0) continue;
    const bool slides = robot.joints[joint].type == Joint::Type::Prismatic;
    const double own = std::abs(leaders_[joint].multiplier) * travel[leaders_[joint].joint];
    if (own == 0.0) continue;
    ways.of_all += own * (slides ? 1.0 : radius_[i]);
    if (slides || radius_[i] == kInfinity) ways.of_slides += slides ? own : kInfinity;
  }
  return ways;
}

/// [m] How far a point of what the robot carries can be from a place, after a way of the robot.
double PairBounds::reachOfBodies(const Vector3d& from, double way) const {
  double farthest = 0.0;
  for (std::size_t body = 0; body < reach_.size(); ++body)
    if (state_->poses()[body])
      farthest = std::max(farthest, (state_->poses()[body]->translation() - from).norm() + reach_[body] + way);
  return farthest;
}

/// [m] The same of the objects that no link holds, and that are checked against another one.
double PairBounds::reachOfFreeObjects(const Vector3d& from, int checked_against) const {
  const Objects& objects = *state_->objects();
  double farthest = 0.0;
  for (const int number : objects.numbers()) {
    const PlacedObject& placed = *objects.placed(number);
    if (placed.kind == PlacedObject::Kind::Attached) continue;
    const ShapeRef ref = ShapeRef::ofObject(number);
    const std::optional<Isometry3d> pose = state_->poseOf(ref);
    if (!pose || !objects.isChecked(ref, ShapeRef::ofObject(checked_against))) continue;
    const Bounds& bounds = partOf(placed).whole().bounds;
    farthest = std::max(farthest, (*pose * bounds.centre - from).norm() + bounds.radius);
  }
  return farthest;
}

/// [m] How much closer a half-space can come to what it is checked against by its own uncertainty. During a motion only
/// what the robot carries counts: no joint brings a half-space closer to another object.
double PairBounds::lossOfHalfSpaces(const std::vector<double>& travel) const {
  const double way = waysOf(travel).of_all;
  double largest = 0.0;
  for (const int number : state_->objects()->unbounded()) {
    const PoseUncertainty& own = object_frames_[number].uncertainty;
    const std::optional<Isometry3d> pose = state_->poseOf(ShapeRef::ofObject(number));
    if (own.isZero() || !pose) continue;
    const Vector3d origin = originAt(number, *pose);
    double farthest = reachOfBodies(origin, way);
    if (travel.empty()) farthest = std::max(farthest, reachOfFreeObjects(origin, number));
    largest = std::max(largest, own.translation + (own.angle > 0.0 ? own.angle * farthest : 0.0));
  }
  return (1.0 + 4.0 * kPoseRounding) * largest;
}

double PairBounds::largestLoss(const State& state) {
  see(state);
  if (!largest_loss_) largest_loss_ = largestLossWith({});
  return *largest_loss_;
}

double PairBounds::largestLoss(const State& state, const std::vector<double>& travel) {
  see(state);
  return largestLossWith(travel);
}

/// Only what is on the way from one shape of a pair to the other displaces the two relative to each other. So the sum
/// along the longest way between two bodies, each joint, frame and base with the largest radius of all that it carries,
/// is not less than the loss of any pair in any state.
double PairBounds::largestLossWith(const std::vector<double>& travel) {
  const RobotModel& robot = model_->robot;
  findRadii();
  const TravelWays ways = waysOf(travel);
  branches_.assign(robot.bodies.size() + 1, {});
  for (std::size_t i = robot.bodies.size(); i-- > 0;) {  // parents come first
    const Body& body = robot.bodies[i];
    const PoseUncertainty& frame = body.joint < 0 ? uncertainty_.bases[body.robot] : uncertainty_.frames[body.joint];
    double turn = frame.angle, shift = frame.translation;
    if (body.joint >= 0) {
      const Joint::Mimic& leader = leaders_[body.joint];
      const double width = std::abs(leader.multiplier) * uncertainty_.positions[leader.joint];
      const bool slides = robot.joints[body.joint].type == Joint::Type::Prismatic;
      (slides ? shift : turn) += width;
      if (slides && frame.angle > 0.0 && state_->poses()[i] && state_->poses()[body.parent])
        shift += frame.angle * (state_->poses()[i]->translation() - jointOrigin(static_cast<int>(i))).norm();
    }
    const double own = shift + (turn > 0.0 ? turn * (radius_[i] + ways.of_slides) : 0.0);
    branches_[body.parent + 1].offer(own + branches_[i + 1].largest);
  }
  double longest = 0.0;
  for (const TwoLargest& branches : branches_) longest = std::max(longest, branches.sum());
  const double sum = longest + swellings_ + objects_lose_ + lossOfHalfSpaces(travel);
  // The sum is of positive numbers, four for each body and a few more; that of a pair is rounded up, too. Each radius
  // is a sum over at most all bodies.
  return (1.0 + static_cast<double>(robot.bodies.size() + 8) * 2.0 * kPoseRounding) * sum;
}

}  // namespace proximity_server::scene
