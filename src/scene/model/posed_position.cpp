#include "proximity_server/scene/model/posed_position.h"

#include "scene/model/body_pose.h"

#include <cstddef>

namespace proximity_server::scene {
namespace {

constexpr double kTurn = 2.0 * 3.14159265358979323846;

/// The position of a joint that the pose of a body tells, which this joint carries, or one that follows it.
std::optional<PosedPosition> positionBy(const RobotModel& model, const BodyPoses& poses, std::size_t index) {
  const Body& body = model.bodies[index];
  const Joint& joint = model.joints[body.joint];
  const Joint::Mimic leader = model.leaderOf(body.joint);
  const std::optional<Eigen::Isometry3d> pose = usablePose(poses[index]), parent = usablePose(poses[body.parent]);
  if (!pose || !parent || leader.multiplier == 0.0 || !hasOnePosition(joint)) return std::nullopt;
  const double own = jointPosition(model, joint, parent->inverse() * *pose);
  const double spacing = joint.type == Joint::Type::Prismatic ? 0.0 : kTurn / std::abs(leader.multiplier);
  const PosedPosition told{(own - leader.offset) / leader.multiplier, spacing};
  if (!std::isfinite(told.value) || !std::isfinite(told.spacing)) return std::nullopt;
  return told;
}

}  // namespace

std::optional<PosedPosition> posedPosition(const RobotModel& model, const BodyPoses& poses, int joint) {
  std::optional<PosedPosition> position;
  for (std::size_t i = 0; i < model.bodies.size(); ++i) {
    const int own = model.bodies[i].joint;
    const bool is_better = own == joint || (!position && own >= 0 && model.leaderOf(own).joint == joint);
    if (!is_better) continue;
    if (const auto told = positionBy(model, poses, i)) position = told;
  }
  return position;
}

double positionWithin(const PositionLimits& limits, const PosedPosition& position,
                      const std::optional<double>& stated) {
  if (!(position.spacing > 0.0)) return position.value;
  if (stated) return position.nearestTo(*stated);
  const double lowest = std::isinf(limits.lower) ? limits.lower : position.atOrAbove(limits.lower - kBeyondLimit);
  const double highest = position.atOrBelow(limits.upper + kBeyondLimit);
  return lowest > highest && limits.excess(highest) < limits.excess(lowest) ? highest : lowest;
}

std::optional<double> excessAt(const RobotModel& model, const JointInequality& inequality, const BodyPoses& poses,
                               const std::vector<std::optional<double>>& stated) {
  double sum = -inequality.bound;
  for (const JointInequality::Term& term : inequality.terms) {
    const std::optional<PosedPosition> position = posedPosition(model, poses, term.joint);
    if (!position) return std::nullopt;
    const Joint& joint = model.joints[term.joint];
    const PositionLimits limits{joint.lower, joint.upper};
    std::optional<double> own = stated.empty() ? std::nullopt : stated[term.joint];
    if (!own && !std::isfinite(joint.upper - joint.lower)) own = 0.0;
    const double lowest = term.coefficient > 0.0
                              ? positionWithin(limits, *position, own)
                              : positionWithin(limits.mirrored(), position->mirrored(), own ? -*own : own);
    sum += std::abs(term.coefficient) * lowest;
  }
  return sum;
}

}  // namespace proximity_server::scene
