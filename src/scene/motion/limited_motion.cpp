#include "proximity_server/scene/motion/limited_motion.h"

#include "proximity_server/narrowphase/angle.h"
#include "proximity_server/scene/model/kinematics.h"
#include "scene/model/numbers.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

namespace proximity_server::scene {
namespace {

using Eigen::Isometry3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;

constexpr double kTurn = 2.0 * 3.14159265358979323846;

/// The position that a pose tells: one of the numbers value + n * spacing.
struct PosedPosition {
  double value;
  double spacing;  ///< 0: the value is the only one

  PosedPosition mirrored() const { return {-value, spacing}; }
  double atOrAbove(double position) const { return value + std::ceil((position - value) / spacing) * spacing; }
  double atOrBelow(double position) const { return value + std::floor((position - value) / spacing) * spacing; }
  double nearestTo(double position) const { return value + std::round((position - value) / spacing) * spacing; }
};

struct Limits {
  double lower, upper;

  Limits mirrored() const { return {-upper, -lower}; }
  double excess(double position) const { return std::max(lower - position, position - upper); }
};

/// Returns the position nearest to the stated one. Without a stated one, returns the lowest of the positions that the
/// limits allow, or, if they allow none, the position nearest to the limits.
double positionWithin(const Limits& limits, const PosedPosition& position, const std::optional<double>& stated) {
  if (!(position.spacing > 0.0)) return position.value;
  if (stated) return position.nearestTo(*stated);
  const double lowest = std::isinf(limits.lower) ? limits.lower : position.atOrAbove(limits.lower - kBeyondLimit);
  const double highest = position.atOrBelow(limits.upper + kBeyondLimit);
  return lowest > highest && limits.excess(highest) < limits.excess(lowest) ? highest : lowest;
}

/// The time in [0, 1] at which a joint reaches a limit; infinity if it reaches none.
double stopTime(PosedPosition position, Limits limits, std::optional<double> stated, double travel) {
  if (travel == 0.0) return kInfinity;
  if (travel < 0.0) {
    position = position.mirrored();
    limits = limits.mirrored();
    if (stated) stated = -*stated;
  }
  if (std::isinf(limits.upper)) return kInfinity;
  return std::max(0.0, limits.upper - positionWithin(limits, position, stated)) / std::abs(travel);
}

bool turns(const Joint& joint) { return joint.type == Joint::Type::Revolute || joint.type == Joint::Type::Continuous; }
bool slides(const Joint& joint) { return joint.type == Joint::Type::Prismatic; }

/// Throws unless the stated position of each joint that moves is so near to its limits that the turn is known.
void requireNearLimits(const RobotModel& model, const std::vector<double>& travel,
                       const std::vector<std::optional<double>>& stated) {
  for (std::size_t i = 0; i < stated.size(); ++i) {
    const Joint& joint = model.joints[i];
    if (!stated[i] || joint.mimic || !turns(joint) || travel[i] == 0.0) continue;
    if (Limits{joint.lower, joint.upper}.excess(*stated[i]) <= 0.5 * kTurn) continue;
    throw std::invalid_argument("joint '" + joint.name + "' is stated to be at " + std::to_string(*stated[i]) +
                                " rad, more than half a turn beyond its limits of " + std::to_string(joint.lower) +
                                " and " + std::to_string(joint.upper) + ": which turn it is on is not known");
  }
}

/// For each of RobotModel::joints that is a leader, the position that its own pose tells, or else the pose of a
/// follower.
std::vector<std::optional<PosedPosition>> positionsOf(const RobotModel& model, const RobotMotion& motion) {
  std::vector<std::optional<PosedPosition>> positions(model.joints.size());
  for (std::size_t i = 0; i < model.bodies.size(); ++i) {
    const int index = model.bodies[i].joint;
    if (index < 0 || !motion.segments()[i].is_known) continue;
    const Joint& joint = model.joints[index];
    if (!turns(joint) && !slides(joint)) continue;
    const Joint::Mimic leader = model.leaderOf(index);
    auto& position = positions[leader.joint];
    if (leader.multiplier == 0.0 || (position && leader.joint != index)) continue;
    const double own = jointPosition(model, joint, motion.segments()[i].motion.start);
    const double spacing = turns(joint) ? kTurn / std::abs(leader.multiplier) : 0.0;
    const PosedPosition told{(own - leader.offset) / leader.multiplier, spacing};
    if (std::isfinite(told.value) && std::isfinite(told.spacing)) position = told;
  }
  return positions;
}

std::vector<JointStop> stopsOf(const RobotModel& model, const RobotMotion& unlimited, const std::vector<double>& travel,
                               const std::vector<std::optional<double>>& stated) {
  const std::vector<std::optional<PosedPosition>> positions = positionsOf(model, unlimited);
  std::vector<JointStop> stops;
  for (std::size_t i = 0; i < model.joints.size(); ++i) {
    if (!positions[i]) continue;
    const Joint& joint = model.joints[i];
    const std::optional<double> own = stated.empty() ? std::nullopt : stated[i];
    const double time = stopTime(*positions[i], {joint.lower, joint.upper}, own, travel[i]);
    if (time < 1.0) stops.push_back({static_cast<int>(i), time});
  }
  std::stable_sort(stops.begin(), stops.end(), [](const JointStop& p, const JointStop& q) { return p.time < q.time; });
  return stops;
}

/// Returns 0, the different times of the stops, and 1.
std::vector<double> borders(const std::vector<JointStop>& stops) {
  std::vector<double> times{0.0};
  for (const JointStop& stop : stops) {
    if (stop.time > times.back()) times.push_back(stop.time);
  }
  times.push_back(1.0);
  return times;
}

std::vector<double> travelDuring(double begin, double end, const std::vector<JointStop>& stops,
                                 std::vector<double> travel) {
  for (double& joint : travel) joint *= end - begin;
  for (const JointStop& stop : stops) {
    if (stop.time <= begin) travel[stop.joint] = 0.0;
  }
  return travel;
}

/// Returns a part of a motion, beginning at the time `begin`. The velocity of the origin at that time belongs to the
/// same screw.
RobotMotion::Segment during(double begin, double end, RobotMotion::Segment segment) {
  narrowphase::ScrewMotion& motion = segment.motion;
  if (!segment.is_known || motion.isRest()) return segment;
  const Isometry3d start = motion.at(begin);
  const Vector3d velocity = motion.linear + motion.angular.cross(start.translation() - motion.start.translation());
  motion = {start, (end - begin) * velocity, (end - begin) * motion.angular};
  return segment;
}

}  // namespace

PhasedMotion::PhasedMotion(RobotMotion motion) : phases_{{0.0, 1.0, std::move(motion)}} {}

PhasedMotion::PhasedMotion(std::vector<Phase> phases) : phases_(std::move(phases)) {
  double time = 0.0;
  for (const Phase& phase : phases_) {
    if (phase.begin != time || !(phase.end > phase.begin))
      throw std::invalid_argument("the phases of a motion do not follow each other");
    time = phase.end;
  }
  if (time != 1.0) throw std::invalid_argument("the phases of a motion do not end at 1");
}

const PhasedMotion::Phase& PhasedMotion::phaseAt(double time) const {
  const auto is_later = [](double t, const Phase& phase) { return t < phase.begin; };
  return *std::prev(std::upper_bound(phases_.begin() + 1, phases_.end(), time, is_later));
}

BodyPoses PhasedMotion::at(double time) const {
  const Phase& phase = phaseAt(time);
  return phase.motion.at((time - phase.begin) / (phase.end - phase.begin));
}

RobotMotion::State PhasedMotion::inWorld(double time) const {
  const Phase& phase = phaseAt(time);
  return phase.motion.inWorld((time - phase.begin) / (phase.end - phase.begin));
}

void PhasedMotion::carryObjects(const RobotMotion::ObjectFrames& frames) {
  for (Phase& phase : phases_) {
    RobotMotion::ObjectFrames part{during(phase.begin, phase.end, frames.world), {}};
    for (const RobotMotion::Segment& frame : frames.moving)
      part.moving.push_back(during(phase.begin, phase.end, frame));
    phase.motion.carryObjects(std::move(part));
  }
}

LimitedMotion motionWithinLimits(const RobotModel& model, const BodyPoses& start, const std::vector<double>& travel,
                                 const std::vector<std::optional<double>>& stated) {
  const RobotMotion unlimited = RobotMotion::ofTravel(model, start, travel);
  if (!stated.empty() && stated.size() != model.joints.size())
    throw std::invalid_argument("there are " + std::to_string(stated.size()) + " stated positions for " +
                                std::to_string(model.joints.size()) + " joints");
  requireNearLimits(model, travel, stated);
  std::vector<JointStop> stops = stopsOf(model, unlimited, travel, stated);
  if (stops.empty()) return {unlimited, {}};
  const std::vector<double> times = borders(stops);
  std::vector<PhasedMotion::Phase> phases;
  BodyPoses poses = start;
  for (std::size_t i = 0; i + 1 < times.size(); ++i) {
    const std::vector<double> during = travelDuring(times[i], times[i + 1], stops, travel);
    phases.push_back({times[i], times[i + 1], RobotMotion::ofTravel(model, poses, during)});
    poses = phases.back().motion.at(1.0);
  }
  return {PhasedMotion(std::move(phases)), std::move(stops)};
}

}  // namespace proximity_server::scene
