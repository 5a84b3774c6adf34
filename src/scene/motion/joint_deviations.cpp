#include "scene/motion/joint_deviations.h"

#include "scene/bounds/seen_bounds.h"

#include <algorithm>
#include <cmath>

namespace proximity_server::scene {
namespace {

using Eigen::Isometry3d;

using Way = PosesInTime::Way;

/// How far the joints between a geometry and another frame, by their deviations, can move the points of the geometry. The
/// joint next to the geometry comes first.
class Effects {
 public:
  Effects(const Carried& who, const JointDeviations& deviations, PosesInTime& poses)
      : deviations_(deviations), poses_(poses), who_(who), pose_(poses.pose(who.frame, kMiddle)) {}

  /// Returns the effect [m] of the next joint.
  double of(int frame) {
    if (frame >= static_cast<int>(deviations_.size())) return 0.0;
    const JointDeviation& joint = deviations_[frame];
    double radius = 1.0, effect = joint.most;  // of a translation
    if (joint.turns) {
      const Isometry3d carried = poses_.pose(frame, kMiddle);
      radius = radiusAbout(carried.linear() * joint.axis, SeenBounds(who_.bounds, pose_, carried.translation()));
      effect = (radius + growth_) * joint.most;
    }
    growth_ += radius * joint.half_travel;
    return effect;
  }

 private:
  static constexpr double kMiddle = PosesInTime::kMiddle;

  const JointDeviations& deviations_;
  PosesInTime& poses_;
  const Carried& who_;
  const Isometry3d pose_;
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
  const double smallest = way.smallestSum(
      on_a, [&](int frame) { return of_a.of(frame); }, [&](int frame) { return of_b.of(frame); });
  return (1.0 + kPoseRounding) * smallest;
}

}  // namespace proximity_server::scene
