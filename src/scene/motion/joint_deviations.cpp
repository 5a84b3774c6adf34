#include "scene/motion/joint_deviations.h"

#include "scene/bounds/seen_bounds.h"

#include <algorithm>
#include <cmath>

namespace proximity_server::scene {
namespace {

using Eigen::Isometry3d;

/// The frames whose joints are on the path from frame a to frame b, in this order.
std::vector<int> jointsBetween(int a, int b, const PosesInTime& poses) {
  const auto ancestry = [&](int frame) {
    std::vector<int> frames;
    for (; frame >= 0; frame = poses.segment(frame).parent) frames.push_back(frame);
    return frames;
  };
  std::vector<int> up = ancestry(a), down = ancestry(b);
  while (!up.empty() && !down.empty() && up.back() == down.back()) {
    up.pop_back();
    down.pop_back();
  }
  up.insert(up.end(), down.rbegin(), down.rend());
  return up;
}

/// The effect of the joints on a geometry: `effects[i]` is that of the joints 0 to i - 1, the next to the geometry
/// first.
template <typename Joints>
std::vector<double> effectsOn(const Carried& who, const Joints& joints, const JointDeviations& deviations,
                              PosesInTime& poses) {
  constexpr double kMiddle = 0.5;
  const Isometry3d pose = poses.pose(who.frame, kMiddle);
  std::vector<double> effects{0.0};
  double growth = 0.0;  // [m] of the distance from an axis, by the motion of the joints so far
  for (const int frame : joints) {
    double effect = 0.0;
    if (frame < static_cast<int>(deviations.size())) {
      const JointDeviation& joint = deviations[frame];
      double radius = 1.0;  // of a translation
      if (joint.turns) {
        const Isometry3d carried = poses.pose(frame, kMiddle);
        radius = radiusAbout(carried.linear() * joint.axis, SeenBounds(who.bounds, pose, carried.translation()));
        effect = (radius + growth) * joint.most;
      } else {
        effect = joint.most;
      }
      growth += radius * joint.half_travel;
    }
    effects.push_back(effects.back() + effect);
  }
  return effects;
}

}  // namespace

JointDeviations jointDeviations(const RobotModel& robot, const std::vector<double>& travel,
                                const std::vector<double>& most) {
  JointDeviations deviations(robot.bodies.size());
  for (std::size_t i = 0; i < robot.bodies.size(); ++i) {
    const int index = robot.bodies[i].joint;
    if (index < 0 || !hasOnePosition(robot.joints[index])) continue;
    const Joint& joint = robot.joints[index];
    const Joint::Mimic leader = robot.leaderOf(index);
    const double scale = std::abs(leader.multiplier);
    deviations[i] = {joint.type != Joint::Type::Prismatic, joint.axis, scale * most[leader.joint],
                     0.5 * scale * std::abs(travel[leader.joint])};
  }
  return deviations;
}

double distanceDeviation(const JointDeviations& deviations, const Carried& a, const Carried& b, PosesInTime& poses) {
  if (deviations.empty()) return 0.0;
  std::vector<int> joints = jointsBetween(a.frame, b.frame, poses);
  const std::vector<double> on_a = effectsOn(a, joints, deviations, poses);
  std::reverse(joints.begin(), joints.end());
  const std::vector<double> on_b = effectsOn(b, joints, deviations, poses);
  double smallest = on_a.front() + on_b.back();
  for (std::size_t i = 1; i < on_a.size(); ++i) smallest = std::min(smallest, on_a[i] + on_b[on_b.size() - 1 - i]);
  return (1.0 + kPoseRounding) * smallest;
}

}  // namespace proximity_server::scene
