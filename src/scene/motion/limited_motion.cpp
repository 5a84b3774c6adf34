#include "proximity_server/scene/motion/limited_motion.h"

#include "proximity_server/narrowphase/angle.h"
#include "proximity_server/scene/model/kinematics.h"
#include "scene/model/numbers.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <tuple>
#include <utility>

namespace proximity_server::scene {
namespace {

constexpr double kTurn = 2.0 * 3.14159265358979323846;

/// The time in [0, 1] at which a joint reaches a limit; infinity if it reaches none.
struct StopTime {
  double time = kInfinity;
  bool is_assumed = false;  ///< on another turn that the limits allow, it would be earlier, and below 1
};
StopTime stopTime(PosedPosition position, PositionLimits limits, std::optional<double> stated, double travel) {
  if (travel == 0.0) return {};
  if (travel < 0.0) {
    position = position.mirrored();
    limits = limits.mirrored();
    if (stated) stated = -*stated;
  }
  if (std::isinf(limits.upper)) return {};
  const auto timeFrom = [&](double start) { return std::max(0.0, limits.upper - start) / std::abs(travel); };
  const double start = positionWithin(limits, position, stated);
  if (stated || !(position.spacing > 0.0)) return {timeFrom(start)};
  const double last = position.atOrBelow(limits.upper + kBeyondLimit);
  return {timeFrom(start), last > start + 0.5 * position.spacing && timeFrom(last) < 1.0};
}

bool turns(const Joint& joint) { return joint.type == Joint::Type::Revolute || joint.type == Joint::Type::Continuous; }

/// Throws unless the stated position of each joint that moves is so near to its limits that the turn is known.
void requireNearLimits(const RobotModel& model, const std::vector<double>& travel,
                       const std::vector<std::optional<double>>& stated) {
  for (std::size_t i = 0; i < stated.size(); ++i) {
    const Joint& joint = model.joints[i];
    if (!stated[i] || joint.mimic || !turns(joint) || travel[i] == 0.0) continue;
    if (PositionLimits{joint.lower, joint.upper}.excess(*stated[i]) <= 0.5 * kTurn) continue;
    throw std::invalid_argument("joint '" + joint.name + "' is stated to be at " + std::to_string(*stated[i]) +
                                " rad, more than half a turn beyond its limits of " + std::to_string(joint.lower) +
                                " and " + std::to_string(joint.upper) + ": which turn it is on is not known");
  }
}

void findStops(const RobotModel& model, const BodyPoses& start, const std::vector<double>& travel,
               const std::vector<std::optional<double>>& stated, MotionLimits& limits) {
  limits.stops.clear();
  limits.assumed.clear();
  for (std::size_t i = 0; i < model.joints.size(); ++i) {
    const Joint& joint = model.joints[i];
    if (joint.mimic || travel[i] == 0.0) continue;
    const std::optional<PosedPosition> position = posedPosition(model, start, static_cast<int>(i));
    if (!position) continue;
    const std::optional<double> own = stated.empty() ? std::nullopt : stated[i];
    const StopTime stop = stopTime(*position, {joint.lower, joint.upper}, own, travel[i]);
    if (stop.time < 1.0) limits.stops.push_back({static_cast<int>(i), stop.time});
    if (stop.is_assumed) limits.assumed.push_back(static_cast<int>(i));
  }
  std::sort(limits.stops.begin(), limits.stops.end(), [](const JointStop& p, const JointStop& q) {
    return std::tie(p.time, p.joint) < std::tie(q.time, q.joint);
  });
}

/// The time at which the excess of an inequality is above what it may be: 0 at most, or what it is at the start and a
/// tolerance; infinity if it never is. `excess` is that at the start.
double breakTime(const JointInequality& inequality, double excess, const std::vector<double>& travel,
                 const std::vector<JointStop>& stops) {
  const double allowed = std::max(0.0, excess + inequality.tolerance());
  double time = 0.0;
  for (std::size_t stopped = 0;; ++stopped) {
    const auto rests = [&](int joint) {
      return std::any_of(stops.begin(), stops.begin() + static_cast<std::ptrdiff_t>(stopped),
                         [&](const JointStop& stop) { return stop.joint == joint; });
    };
    double rate = 0.0;
    for (const JointInequality::Term& term : inequality.terms)
      if (!rests(term.joint)) rate += term.coefficient * travel[term.joint];
    const double reached = rate > 0.0 ? time + (allowed - excess) / rate : kInfinity;
    if (stopped == stops.size() || reached < stops[stopped].time) return reached;
    excess = std::min(allowed, excess + rate * (stops[stopped].time - time));
    time = stops[stopped].time;
  }
}

std::optional<InequalityBreak> firstBreak(const RobotModel& model, const BodyPoses& start,
                                          const std::vector<double>& travel, const std::vector<JointStop>& stops,
                                          const std::vector<std::optional<double>>& stated) {
  std::optional<InequalityBreak> first;
  for (const JointInequality& inequality : model.inequalities) {
    const std::optional<double> excess = excessAt(model, inequality, start, stated);
    const double time = excess ? breakTime(inequality, *excess, travel, stops) : kInfinity;
    if (time < (first ? first->time : 1.0))
      first = InequalityBreak{static_cast<int>(&inequality - model.inequalities.data()), time};
  }
  return first;
}

}  // namespace

void findLimits(const RobotModel& model, const BodyPoses& start, const std::vector<double>& travel,
                const std::vector<std::optional<double>>& stated, MotionLimits& limits) {
  if (!stated.empty() && stated.size() != model.joints.size())
    throw std::invalid_argument("there are " + std::to_string(stated.size()) + " stated positions for " +
                                std::to_string(model.joints.size()) + " joints");
  requireNearLimits(model, travel, stated);
  findStops(model, start, travel, stated, limits);
  limits.broken = firstBreak(model, start, travel, limits.stops, stated);
}

double nextStop(const std::vector<JointStop>& stops, double begin) {
  const auto next = std::find_if(stops.begin(), stops.end(), [&](const JointStop& stop) { return stop.time > begin; });
  return next == stops.end() ? 1.0 : next->time;
}

void restrictTravel(double begin, double end, const std::vector<JointStop>& stops, std::vector<double>& travel) {
  for (double& joint : travel) joint *= end - begin;
  for (const JointStop& stop : stops) {
    if (stop.time <= begin) travel[stop.joint] = 0.0;
  }
}

LimitedMotion motionWithinLimits(const RobotModel& model, const BodyPoses& start, const std::vector<double>& travel,
                                 const std::vector<std::optional<double>>& stated) {
  RobotMotion unlimited = RobotMotion::ofTravel(model, start, travel);
  MotionLimits limits;
  findLimits(model, start, travel, stated, limits);
  if (limits.stops.empty()) return {std::move(limits), std::move(unlimited)};
  std::vector<Motion::Piece> pieces;
  BodyPoses poses = start;
  double end = 0.0;
  while (end < 1.0) {
    const double begin = end;
    end = nextStop(limits.stops, begin);
    std::vector<double> during = travel;
    restrictTravel(begin, end, limits.stops, during);
    pieces.push_back({begin, end, RobotMotion::ofTravel(model, poses, during)});
    pieces.back().robot.at(1.0, poses);
  }
  return {std::move(limits), Motion(std::move(pieces))};
}

}  // namespace proximity_server::scene
