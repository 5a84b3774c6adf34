#include "scene/motion/joint_deviations.h"

#include "scene/bounds/seen_bounds.h"

#include <algorithm>
#include <cmath>

namespace proximity_server::scene {
namespace {

using Eigen::Isometry3d;

using Way = PosesInTime::Way;

/// Sums up how far the joints between a geometry and another frame, by their deviations, can move the points of the
/// geometry. The joint next to the geometry comes first.
class Effects {
 public:
  Effects(const Carried& who, const JointDeviations& deviations, PosesInTime& poses)
      : deviations_(deviations), poses_(poses), who_(who), pose_(poses.pose(who.frame, kMiddle)) {}

  /// Returns the effect [m] of all joints until the next one.
  double with(int frame) {
    if (frame >= static_cast<int>(deviations_.size())) return sum_;
    const JointDeviation& joint = deviations_[frame];
    double radius = 1.0, effect = joint.most;  // of a translation
    if (joint.turns) {
      const Isometry3d carried = poses_.pose(frame, kMiddle);
      radius = radiusAbout(carried.linear() * joint.axis, SeenBounds(who_.bounds, pose_, carried.translation()));
      effect = (radius + growth_) * joint.most;
    }
    growth_ += radius * joint.half_travel;
    return sum_ += effect;
  }

 private:
  static constexpr double kMiddle = 0.5;

  const JointDeviations& deviations_;
  PosesInTime& poses_;
  const Carried& who_;
  const Isometry3d pose_;
  double sum_ = 0.0;
  double growth_ = 0.0;  // [m] of the distance from an axis, by the motion of the joints so far
};

}  // namespace

void setDeviations(const RobotModel& robot, const std::vector<double>& travel, const std::vector<double>& most,
                   JointDeviations& deviations) {
  deviations.assign(robot.bodies.size(), {});
  for (std::size_t i = 0; i < robot.bodies.size(); ++i) {
    const int index = robot.bodies[i].joint;
    if (index < 0 || !hasOnePosition(robot.joints[index])) continue;
    const Joint& joint = robot.joints[index];
    const Joint::Mimic leader = robot.leaderOf(index);
    const double scale = std::abs(leader.multiplier);
    deviations[i] = {joint.type != Joint::Type::Prismatic, joint.axis, scale * most[leader.joint],
                     0.5 * scale * std::abs(travel[leader.joint])};
  }
}

double distanceDeviation(const JointDeviations& deviations, const Carried& a, const Carried& b, PosesInTime& poses,
                         std::vector<double>& on_a) {
  if (deviations.empty()) return 0.0;
  const Way& way = poses.wayBetween(a.frame, b.frame);
  Effects of_a(a, deviations, poses), of_b(b, deviations, poses);
  on_a.assign(1, 0.0);
  for (std::size_t i = 0; i < way.size(); ++i) on_a.push_back(of_a.with(way.frame(i)));
  double smallest = on_a.back();
  for (std::size_t i = way.size(); i-- > 0;) smallest = std::min(smallest, on_a[i] + of_b.with(way.frame(i)));
  return (1.0 + kPoseRounding) * smallest;
}

}  // namespace proximity_server::scene
