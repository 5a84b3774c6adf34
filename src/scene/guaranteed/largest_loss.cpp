#include "scene/guaranteed/largest_loss.h"

#include "scene/model/numbers.h"
#include "scene/objects/object_geometry.h"
#include "scene/objects/placed_object.h"
#include "scene/state/volumes.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace proximity_server::scene {

using Eigen::Isometry3d;
using Eigen::Vector3d;

/// Finds how far what each body carries can be from its origin: no farther than along the chain of origins to the
/// geometry of any body that it carries, whatever the angles of the joints are. Infinity for a body without a pose that
/// carries one with a pose, and for one that carries a half-space in the frame of a link.
void LargestLoss::findRadii() {
  reach_.assign(robot().bodies.size(), 0.0);
  for (int link = 0; link < static_cast<int>(robot().links.size()); ++link) {
    double& reach = reach_[robot().links[link].body];
    if (robot().hasGeometry(link)) reach = std::max(reach, state().volumes()->part(link).whole().bounds.reach);
  }
  reachObjects();
  radius_ = reach_;
  for (int body = static_cast<int>(robot().bodies.size()) - 1; body >= 0; --body) {  // parents come first
    if (!state().poses()[body]) continue;
    int parent = robot().bodies[body].parent;
    for (; parent >= 0 && !state().poses()[parent]; parent = robot().bodies[parent].parent) radius_[parent] = kInfinity;
    if (parent < 0) continue;
    const double between = (state().poses()[body]->translation() - state().poses()[parent]->translation()).norm();
    radius_[parent] = std::max(radius_[parent], (1.0 + kPoseRounding) * (between + radius_[body]));
  }
}

/// Adds the objects that bodies carry to reach_. The places of those in frames of links are known from poses only.
void LargestLoss::reachObjects() {
  for (const int number : state().objects()->numbers()) {
    const PlacedObject& placed = *state().objects()->placed(number);
    const ShapeRef ref = ShapeRef::ofObject(number);
    const int body = state().bodyOf(ref);
    if (body < 0) continue;
    const Volume& whole = partOf(placed).whole();
    if (placed.kind == PlacedObject::Kind::Attached) {
      if (!whole.isEmpty()) reach_[body] = std::max(reach_[body], whole.bounds.reach);
      continue;
    }
    const std::optional<Isometry3d> pose = state().poseOf(ref);
    if (!pose || !state().poses()[body]) continue;
    const double between = (*pose * whole.bounds.centre - state().poses()[body]->translation()).norm();
    const double own = placed.isUnbounded() ? kInfinity : (1.0 + kPoseRounding) * (between + whole.bounds.radius);
    reach_[body] = std::max(reach_[body], own);
  }
}

/// [m] How far the points move at most if each joint moves by its travel. And by slides alone: only they change the
/// distances along the chain of origins in findRadii(), where all poses of the chain are known.
LargestLoss::TravelWays LargestLoss::waysOf(const std::vector<double>& travel) const {
  TravelWays ways;
  for (std::size_t i = 0; i < robot().bodies.size() && !travel.empty(); ++i) {
    const int joint = robot().bodies[i].joint;
    if (joint < 0) continue;
    const bool slides = robot().joints[joint].type == Joint::Type::Prismatic;
    const double own = std::abs(places_.leaders()[joint].multiplier) * travel[places_.leaders()[joint].joint];
    if (own == 0.0) continue;
    ways.of_all += own * (slides ? 1.0 : radius_[i]);
    if (slides || radius_[i] == kInfinity) ways.of_slides += slides ? own : kInfinity;
  }
  return ways;
}

/// [m] How far a point of what the robot carries can be from a place, after a way of the robot.
double LargestLoss::reachOfBodies(const Vector3d& from, double way) const {
  double farthest = 0.0;
  for (std::size_t body = 0; body < reach_.size(); ++body)
    if (state().poses()[body])
      farthest = std::max(farthest, (state().poses()[body]->translation() - from).norm() + reach_[body] + way);
  return farthest;
}

/// [m] The same of the objects that no link holds, and that are checked against another one.
double LargestLoss::reachOfFreeObjects(const Vector3d& from, int checked_against) const {
  const Objects& objects = *state().objects();
  double farthest = 0.0;
  for (const int number : objects.numbers()) {
    const PlacedObject& placed = *objects.placed(number);
    if (placed.kind == PlacedObject::Kind::Attached) continue;
    const ShapeRef ref = ShapeRef::ofObject(number);
    const std::optional<Isometry3d> pose = state().poseOf(ref);
    if (!pose || !objects.isChecked(ref, ShapeRef::ofObject(checked_against))) continue;
    const Bounds& bounds = partOf(placed).whole().bounds;
    farthest = std::max(farthest, (*pose * bounds.centre - from).norm() + bounds.radius);
  }
  return farthest;
}

/// [m] How much closer a half-space can come to what it is checked against by its own uncertainty. During a motion only
/// what the robot carries counts: no joint brings a half-space closer to another object.
double LargestLoss::lossOfHalfSpaces(const std::vector<double>& travel) const {
  const double way = waysOf(travel).of_all;
  double largest = 0.0;
  for (const int number : state().objects()->unbounded()) {
    const PoseUncertainty& own = places_.ofObject(number);
    const std::optional<Isometry3d> pose = state().poseOf(ShapeRef::ofObject(number));
    if (own.isZero() || !pose) continue;
    const Vector3d origin = places_.originAt(number, *pose);
    double farthest = reachOfBodies(origin, way);
    if (travel.empty()) farthest = std::max(farthest, reachOfFreeObjects(origin, number));
    largest = std::max(largest, own.translation + (own.angle > 0.0 ? own.angle * farthest : 0.0));
  }
  return (1.0 + 4.0 * kPoseRounding) * largest;
}

/// [m] How much closer two objects can come by their own uncertainties, without those that have half-spaces.
double LargestLoss::lossOfObjects() const {
  TwoLargest largest;
  for (const int number : state().objects()->numbers()) {
    const PlacedObject& placed = *state().objects()->placed(number);
    if (placed.isUnbounded()) continue;
    const Bounds& bounds = partOf(placed).whole().bounds;
    // The geometry of a fixed object is in the frame of the object itself.
    const Vector3d origin =
        placed.kind == PlacedObject::Kind::Fixed ? Vector3d(Vector3d::Zero()) : places_.originOf(number);
    const PoseUncertainty& own = places_.ofObject(number);
    largest.offer(own.translation + own.angle * ((bounds.centre - origin).norm() + bounds.radius));
  }
  return largest.sum();
}

/// [m] How much closer two links can come by what their surfaces swell.
double LargestLoss::lossOfSurfaces() const {
  TwoLargest largest;
  for (int link = 0; link < static_cast<int>(robot().links.size()); ++link)
    if (robot().hasGeometry(link)) largest.offer(places_.swellingOf(link));
  return largest.sum();
}

/// [m] How much closer two bodies can come, with slides that have moved by `way_of_slides` [m].
double LargestLoss::lossOfBodies(double way_of_slides) {
  branches_.assign(robot().bodies.size() + 1, {});
  for (std::size_t i = robot().bodies.size(); i-- > 0;) {  // parents come first
    const Body& body = robot().bodies[i];
    const PoseUncertainty& frame =
        body.joint < 0 ? places_.uncertainty().bases[body.robot] : places_.uncertainty().frames[body.joint];
    double turn = frame.angle, shift = frame.translation;
    if (body.joint >= 0) {
      const Joint::Mimic& leader = places_.leaders()[body.joint];
      const double width = std::abs(leader.multiplier) * places_.uncertainty().positions[leader.joint];
      const bool slides = robot().joints[body.joint].type == Joint::Type::Prismatic;
      (slides ? shift : turn) += width;
      if (slides && frame.angle > 0.0 && state().poses()[i] && state().poses()[body.parent])
        shift += frame.angle * (state().poses()[i]->translation() - places_.jointOrigin(static_cast<int>(i))).norm();
    }
    const double own = shift + (turn > 0.0 ? turn * (radius_[i] + way_of_slides) : 0.0);
    branches_[body.parent + 1].offer(own + branches_[i + 1].largest);
  }
  double longest = 0.0;
  for (const TwoLargest& branches : branches_) longest = std::max(longest, branches.sum());
  return longest;
}

double LargestLoss::of(const std::vector<double>& travel) {
  findRadii();
  const double sum =
      lossOfBodies(waysOf(travel).of_slides) + lossOfSurfaces() + lossOfObjects() + lossOfHalfSpaces(travel);
  // The sum is of positive numbers, four for each body and a few more; the loss of a pair is rounded up, too. Each
  // radius is a sum over at most all bodies.
  return (1.0 + static_cast<double>(robot().bodies.size() + 8) * 2.0 * kPoseRounding) * sum;
}

}  // namespace proximity_server::scene
