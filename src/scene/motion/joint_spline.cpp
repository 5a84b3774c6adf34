#include "proximity_server/scene/motion/joint_spline.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

namespace proximity_server::scene {
namespace {

constexpr double kWholeTurn = 2.0 * 3.14159265358979323846;
constexpr double kAccuracyOfExtremes = 1e-9;  // [rad] or [m]

std::string placeOf(const TrajectoryPoint& point) { return "the point at " + std::to_string(point.time) + " s"; }

void requireNumbers(const RobotModel& robot, const TrajectoryPoint& point, const Positions& numbers,
                    const std::string& what) {
  if (numbers.size() != robot.joints.size())
    throw std::invalid_argument(placeOf(point) + " has " + std::to_string(numbers.size()) + " " + what + " for " +
                                std::to_string(robot.joints.size()) + " joints");
  for (std::size_t i = 0; i < numbers.size(); ++i)
    if (!std::isfinite(numbers[i]))
      throw std::invalid_argument(placeOf(point) + ": joint '" + robot.joints[i].name + "': one of the " + what +
                                  " is not finite");
}

void requireUsable(const RobotModel& robot, const TrajectoryPoint& point) {
  if (!std::isfinite(point.time)) throw std::invalid_argument("the time of a point is not finite");
  requireNumbers(robot, point, point.positions, "positions");
  if (!point.velocities.empty()) requireNumbers(robot, point, point.velocities, "velocities");
  if (!point.accelerations.empty()) requireNumbers(robot, point, point.accelerations, "accelerations");
}

/// One joint at both ends of a segment. Velocities and accelerations are those in the time of the segment.
struct Ends {
  double from, to;
  double velocity_from, velocity_to;
  double acceleration_from, acceleration_to;
};

Ends linear(double from, double to) { return {from, to, to - from, to - from, 0.0, 0.0}; }

std::array<double, 6> controlValues(const Ends& ends) {
  return {ends.from,
          ends.from + ends.velocity_from / 5.0,
          ends.from + 2.0 * ends.velocity_from / 5.0 + ends.acceleration_from / 20.0,
          ends.to - 2.0 * ends.velocity_to / 5.0 + ends.acceleration_to / 20.0,
          ends.to - ends.velocity_to / 5.0,
          ends.to};
}

Ends cubic(double from, double to, double velocity_from, double velocity_to) {
  const double way = to - from;
  return {from,
          to,
          velocity_from,
          velocity_to,
          6.0 * way - 4.0 * velocity_from - 2.0 * velocity_to,
          -6.0 * way + 2.0 * velocity_from + 4.0 * velocity_to};
}

}  // namespace

std::vector<TrajectoryPoint> drivenFrom(const RobotModel& robot, TrajectoryPoint start,
                                        const std::vector<TrajectoryPoint>& points) {
  start.time = 0.0;
  std::vector<TrajectoryPoint> driven{std::move(start)};
  std::copy_if(points.begin(), points.end(), std::back_inserter(driven),
               [](const TrajectoryPoint& point) { return point.time > 0.0; });
  if (driven.size() == 1) throw std::invalid_argument("no point of the trajectory is later than its start");
  for (const TrajectoryPoint& point : driven) requireNumbers(robot, point, point.positions, "positions");
  for (std::size_t joint = 0; joint < robot.joints.size(); ++joint) {
    if (robot.joints[joint].type != Joint::Type::Continuous) continue;
    const double first = driven[1].positions[joint], way = first - driven[0].positions[joint];
    const double offset = std::remainder(way, kWholeTurn) - way;
    for (std::size_t i = 1; i < driven.size(); ++i) driven[i].positions[joint] += offset;
  }
  return driven;
}

SplineSegment::SplineSegment(const RobotModel& robot, const TrajectoryPoint& from, const TrajectoryPoint& to)
    : begin_(from.time), end_(to.time) {
  requireUsable(robot, from);
  requireUsable(robot, to);
  if (!(to.time > from.time)) throw std::invalid_argument(placeOf(to) + " is not later than " + placeOf(from));
  const double duration = to.time - from.time;
  const bool has_velocities = !from.velocities.empty() && !to.velocities.empty();
  const bool has_accelerations = has_velocities && !from.accelerations.empty() && !to.accelerations.empty();
  for (std::size_t i = 0; i < robot.joints.size(); ++i) {
    Ends ends = linear(from.positions[i], to.positions[i]);
    if (has_velocities) ends = cubic(ends.from, ends.to, duration * from.velocities[i], duration * to.velocities[i]);
    if (has_accelerations) {
      ends.acceleration_from = duration * duration * from.accelerations[i];
      ends.acceleration_to = duration * duration * to.accelerations[i];
    }
    joints_.push_back(controlValues(ends));
    for (const double value : joints_.back())
      if (!std::isfinite(value - ends.from))
        throw std::invalid_argument(placeOf(to) + ": joint '" + robot.joints[i].name + "' is too fast or too far away");
  }
}

/// The control values of a part: for the k-th, k of the five steps of de Casteljau's algorithm are made at the end of
/// the part, and the others at its begin.
SplineSegment::ControlValues SplineSegment::part(const ControlValues& whole, double from, double to) {
  ControlValues values;
  for (std::size_t k = 0; k < values.size(); ++k) {
    ControlValues row = whole;
    for (std::size_t step = 0; step + 1 < row.size(); ++step) {
      const double time = step < k ? to : from;
      for (std::size_t i = 0; i + 1 + step < row.size(); ++i) row[i] = (1.0 - time) * row[i] + time * row[i + 1];
    }
    values[k] = row[0];
  }
  return values;
}

double SplineSegment::valueAt(const ControlValues& values, double time) {
  ControlValues row = values;
  for (std::size_t size = row.size() - 1; size > 0; --size)
    for (std::size_t i = 0; i < size; ++i) row[i] = (1.0 - time) * row[i] + time * row[i + 1];
  return row[0];
}

Positions SplineSegment::at(double time) const {
  Positions positions;
  at(time, positions);
  return positions;
}

void SplineSegment::at(double time, Positions& positions) const {
  positions.clear();
  for (const ControlValues& values : joints_) positions.push_back(valueAt(values, time));
}

double SplineSegment::largestSpeed(int joint) const {
  const ControlValues& values = joints_[joint];
  double largest = 0.0;
  for (std::size_t i = 0; i + 1 < values.size(); ++i) largest = std::max(largest, std::abs(values[i + 1] - values[i]));
  return 5.0 * largest / (end_ - begin_);
}

/// The values before the last steps of de Casteljau's algorithm give the derivatives.
TrajectoryPoint SplineSegment::stateAt(double time) const {
  const double duration = end_ - begin_;
  TrajectoryPoint state{begin_ + time * duration, {}};
  for (const ControlValues& values : joints_) {
    ControlValues row = values;
    const auto step = [&](int size) {
      for (int i = 0; i < size; ++i) row[i] = (1.0 - time) * row[i] + time * row[i + 1];
    };
    for (const int size : {5, 4, 3}) step(size);
    state.accelerations.push_back(20.0 * (row[2] - 2.0 * row[1] + row[0]) / (duration * duration));
    step(2);
    state.velocities.push_back(5.0 * (row[1] - row[0]) / duration);
    step(1);
    state.positions.push_back(row[0]);
  }
  return state;
}

void SplineSegment::rest(double begin, double end, const Positions& positions) {
  begin_ = begin;
  end_ = end;
  joints_.resize(positions.size());
  for (std::size_t i = 0; i < positions.size(); ++i) joints_[i].fill(positions[i]);
}

void SplineSegment::goStraight(int joint, double from, double to) { joints_[joint] = controlValues(linear(from, to)); }

void SplineSegment::copy(int joint, const SplineSegment& other, double from, double to) {
  joints_[joint] = part(other.joints_[joint], from, to);
}

SplineSegment SplineSegment::between(double from, double to) const {
  SplineSegment segment = *this;
  segment.begin_ = begin_ + from * (end_ - begin_);
  segment.end_ = to < 1.0 ? begin_ + to * (end_ - begin_) : end_;
  for (ControlValues& values : segment.joints_) values = part(values, from, to);
  return segment;
}

void SplineSegment::chord(double from, double to, Chord& chord) const {
  chord.from.clear();
  chord.to.clear();
  chord.deviation.clear();
  for (const ControlValues& whole : joints_) {
    const ControlValues values = part(whole, from, to);
    double largest = 0.0, deviation = 0.0;
    for (const double value : whole) largest = std::max(largest, std::abs(value));
    for (std::size_t i = 0; i < values.size(); ++i) {
      const double on_line = values.front() + static_cast<double>(i) / 5.0 * (values.back() - values.front());
      deviation = std::max(deviation, std::abs(values[i] - on_line));
    }
    chord.from.push_back(values.front());
    chord.to.push_back(values.back());
    chord.deviation.push_back(deviation + kRounding * largest);
  }
}

/// Halves the parts that can be higher than all that was found. Their control values approach the polynomial by a factor
/// of four with each halving.
double SplineSegment::timeOfHighest(const ControlValues& values) {
  double best = values.front() < values.back() ? 1.0 : 0.0;
  double highest = std::max(values.front(), values.back());
  std::vector<std::pair<double, double>> parts{{0.0, 1.0}};
  while (!parts.empty()) {
    const auto [from, to] = parts.back();
    parts.pop_back();
    const ControlValues here = part(values, from, to);
    const double middle = 0.5 * (from + to);
    const bool is_short = !(middle > from && middle < to);
    if (is_short || !(*std::max_element(here.begin(), here.end()) > highest + kAccuracyOfExtremes)) continue;
    if (const double value = valueAt(values, middle); value > highest) {
      highest = value;
      best = middle;
    }
    parts.emplace_back(from, middle);
    parts.emplace_back(middle, to);
  }
  return best;
}

std::vector<SplineSegment::Excess> SplineSegment::beyondLimits(const RobotModel& robot) const {
  std::vector<Excess> beyond;
  for (std::size_t i = 0; i < joints_.size(); ++i) {
    const Joint& joint = robot.joints[i];
    if (joint.mimic || !hasOnePosition(joint)) continue;
    ControlValues mirrored = joints_[i];
    for (double& value : mirrored) value = -value;
    const double highest = timeOfHighest(joints_[i]), lowest = timeOfHighest(mirrored);
    const Excess above{static_cast<int>(i), highest, valueAt(joints_[i], highest), joint.upper};
    const Excess below{static_cast<int>(i), lowest, valueAt(joints_[i], lowest), joint.lower};
    if (above.position > above.limit + kAccuracyOfExtremes) beyond.push_back(above);
    if (below.position < below.limit - kAccuracyOfExtremes) beyond.push_back(below);
  }
  return beyond;
}

std::vector<SplineSegment::Break> SplineSegment::brokenInequalities(
    const RobotModel& robot, const std::vector<std::optional<double>>& resting) const {
  std::vector<Break> broken;
  for (const JointInequality& inequality : robot.inequalities) {
    ControlValues excess;
    excess.fill(-inequality.bound);
    for (const JointInequality::Term& term : inequality.terms) {
      const bool rests = !resting.empty() && resting[term.joint];
      for (std::size_t i = 0; i < excess.size(); ++i)
        excess[i] += term.coefficient * (rests ? *resting[term.joint] : joints_[term.joint][i]);
    }
    const double time = timeOfHighest(excess), highest = valueAt(excess, time);
    if (highest > inequality.tolerance()) broken.push_back({&inequality, time, highest});
  }
  return broken;
}

}  // namespace proximity_server::scene
