#include "scene/model/numbers.h"
#include "scene/uncertainty/pair_bounds.h"

#include <algorithm>
#include <cmath>

namespace proximity_server::scene {

using Eigen::Isometry3d;
using Eigen::Vector3d;

/// Finds how far what each body carries can be from its origin: no farther than along the chain of origins to the
/// geometry of any body that it carries, whatever the angles of the joints are.
void PairBounds::findRadii() {
  const RobotModel& robot = joints_.robot();
  radius_ = reach_;
  for (int body = static_cast<int>(robot.bodies.size()) - 1; body >= 0; --body) {  // parents come first
    if (!joints_.poses()[body]) continue;
    int parent = robot.bodies[body].parent;
    while (parent >= 0 && !joints_.poses()[parent]) parent = robot.bodies[parent].parent;
    if (parent < 0) continue;
    const double between = (joints_.poses()[body]->translation() - joints_.poses()[parent]->translation()).norm();
    radius_[parent] = std::max(radius_[parent], (1.0 + kPoseRounding) * (between + radius_[body]));
  }
}

/// [m] How far the points move at most if each joint moves by its travel. Of slides alone: only they change the
/// distances along the chain of origins in findRadii().
PairBounds::TravelWays PairBounds::waysOf(const std::vector<double>& travel) const {
  const RobotModel& robot = joints_.robot();
  TravelWays ways;
  for (std::size_t i = 0; i < robot.bodies.size() && !travel.empty(); ++i) {
    const int joint = robot.bodies[i].joint;
    if (joint < 0) continue;
    const bool slides = robot.joints[joint].type == Joint::Type::Prismatic;
    const double own = std::abs(leaders_[joint].multiplier) * travel[leaders_[joint].joint];
    ways.of_all += own * (slides ? 1.0 : radius_[i]);
    if (slides) ways.of_slides += own;
  }
  return ways;
}

/// [m] How much closer a half-space can come to what the robot carries by its own uncertainty, and on a way of the robot.
double PairBounds::lossOfHalfSpaces(double way) const {
  double largest = 0.0;
  for (const int number : joints_.objects()->unbounded()) {
    const PlacedObject& placed = *joints_.objects()->placed(number);
    const ObjectFrame& frame = object_frames_[number];
    const std::optional<Isometry3d>* moving =
        placed.kind == PlacedObject::Kind::Moving ? &frames_[joints_.objects()->frameOf(number)] : nullptr;
    if (frame.uncertainty.isZero() || (moving && !*moving)) continue;
    const Vector3d origin = moving ? Vector3d(**moving * frame.origin) : frame.origin;
    for (std::size_t body = 0; body < reach_.size(); ++body) {
      if (!joints_.poses()[body]) continue;
      const double radius = (joints_.poses()[body]->translation() - origin).norm() + reach_[body] + way;
      largest = std::max(largest, frame.uncertainty.translation + frame.uncertainty.angle * radius);
    }
  }
  return (1.0 + 4.0 * kPoseRounding) * largest;
}

double PairBounds::largestLoss() {
  if (!largest_loss_) largest_loss_ = largestLoss(std::vector<double>());
  return *largest_loss_;
}

/// Only what is on the way from one shape of a pair to the other displaces the two relative to each other. So the sum
/// along the longest way between two bodies, each joint, frame and base with the largest radius of all that it carries,
/// is not less than the loss of any pair.
double PairBounds::largestLoss(const std::vector<double>& travel) {
  if (carries_free_objects_) return kInfinity;
  const RobotModel& robot = joints_.robot();
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
      if (slides && frame.angle > 0.0 && joints_.poses()[i] && joints_.poses()[body.parent])
        shift += frame.angle * (joints_.poses()[i]->translation() - jointOrigin(static_cast<int>(i))).norm();
    }
    const double own = turn * (radius_[i] + ways.of_slides) + shift;
    branches_[body.parent + 1].offer(own + branches_[i + 1].largest);
  }
  double longest = 0.0;
  for (const TwoLargest& branches : branches_) longest = std::max(longest, branches.sum());
  const double sum = longest + swellings_ + objects_lose_ + (joints_.objects() ? lossOfHalfSpaces(ways.of_all) : 0.0);
  // The sum is of positive numbers, four for each body and a few more; that of a pair is rounded up, too. Each radius
  // is a sum over at most all bodies.
  return (1.0 + static_cast<double>(robot.bodies.size() + 8) * 2.0 * kPoseRounding) * sum;
}

}  // namespace proximity_server::scene
