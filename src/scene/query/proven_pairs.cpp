#include "scene/query/proven_pairs.h"

#include "proximity_server/scene/model/kinematics.h"
#include "scene/model/body_pose.h"
#include "scene/model/numbers.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <utility>

namespace proximity_server::scene {
namespace {

constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

/// The joints between two bodies and their leaders, leaders first.
std::vector<int> jointsOf(const RobotModel& model, const LinkPair& pair) {
  std::set<int> leaders, followers;
  for (const int joint : jointsBetween(model, model.links[pair.link_a].body, model.links[pair.link_b].body)) {
    const int leader = model.leaderOf(joint).joint;
    leaders.insert(leader);
    if (leader != joint) followers.insert(joint);
  }
  std::vector<int> joints(leaders.begin(), leaders.end());
  joints.insert(joints.end(), followers.begin(), followers.end());
  return joints;
}

bool agree(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) {
  return (a.linear() - b.linear()).norm() <= kJointAgreement &&
         (a.translation() - b.translation()).norm() <= kJointAgreement;
}

/// The position of the same pose that is nearest to the middle of the limits.
double nearMiddle(const Joint& joint, double position) {
  const double middle = 0.5 * (joint.lower + joint.upper);
  if (joint.type != Joint::Type::Revolute || !std::isfinite(middle)) return position;
  return position + 2.0 * M_PI * std::round((middle - position) / (2.0 * M_PI));
}

}  // namespace

ProvenPairs::ProvenPairs(const SceneModel& model) : model_(model.robot), readings_(model.robot.joints.size()) {
  for (const LinkPair& pair : model.pairs.pairs) {
    if (pair.proven.ranges.empty()) continue;
    pairs_.push_back({{pair.link_a, pair.link_b}, jointsOf(model_, pair), &pair.proven});
  }
  for (int body = 0; body < static_cast<int>(model_.bodies.size()); ++body)
    if (const int joint = model_.bodies[body].joint; joint >= 0) readings_[joint].body = body;
}

double ProvenPairs::boundAbove(double least, const PartPair& parts, const PlacedRobot& robot) {
  if (update_ == 0) return -kInfinity;
  const auto place = [](const PartPair& pair) { return std::make_pair(pair.a, pair.b); };
  const auto pair = std::lower_bound(pairs_.begin(), pairs_.end(), parts, [&](const Pair& one, const PartPair& wanted) {
    return place(one.links) < place(wanted);
  });
  if (pair == pairs_.end() || place(pair->links) != place(parts) || !(pair->proven->distance > least))
    return -kInfinity;
  // NaN, a position that is not known, is in no interval.
  const auto isWithin = [&](const JointRange& interval) {
    const double position = positionOf(interval.joint, robot);
    return interval.lower <= position && position <= interval.upper;
  };
  const auto isIn = [&](const std::vector<JointRange>& range) {
    return std::all_of(range.begin(), range.end(), isWithin);
  };
  const auto& ranges = pair->proven->ranges;
  if (std::none_of(ranges.begin(), ranges.end(), isIn)) return -kInfinity;
  const auto isKnown = [&](int joint) { return !std::isnan(positionOf(joint, robot)); };
  return std::all_of(pair->joints.begin(), pair->joints.end(), isKnown) ? pair->proven->distance : -kInfinity;
}

double ProvenPairs::positionOf(int joint, const PlacedRobot& robot) {
  Reading& reading = readings_[joint];
  if (reading.update != update_) {
    reading.position = read(joint, robot);
    reading.update = update_;
  }
  return reading.position;
}

double ProvenPairs::read(int joint_index, const PlacedRobot& robot) {
  const int index = readings_[joint_index].body;
  const Body& body = model_.bodies[index];
  const Joint& joint = model_.joints[joint_index];
  if (!hasOnePosition(joint) || !robot.isKnown(index) || !robot.isKnown(body.parent)) return kUnknown;
  const RelativePose relative = robot.relativeBodies(body.parent, index);
  Eigen::Isometry3d parent_T_child = Eigen::Isometry3d::Identity();
  parent_T_child.linear() = relative.rotation;
  parent_T_child.translation() = relative.translation;
  const Joint::Mimic leader = model_.leaderOf(joint_index);
  const double position = leader.joint == joint_index ? nearMiddle(joint, jointPosition(model_, joint, parent_T_child))
                                                      : followedPosition(leader, positionOf(leader.joint, robot));
  const Eigen::Isometry3d expected =
      poseOnParent(model_, body, Eigen::Isometry3d::Identity(), jointMotion(joint, position));
  return agree(parent_T_child, expected) ? position : kUnknown;
}

}  // namespace proximity_server::scene
