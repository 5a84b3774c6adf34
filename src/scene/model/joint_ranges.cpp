#include "proximity_server/scene/model/joint_ranges.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <set>

namespace proximity_server::scene {
namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr double kGuess = 1.0;  // [m] in both directions, for a prismatic joint without limits

bool hasLimits(const Joint& joint) { return std::isfinite(joint.lower) && std::isfinite(joint.upper); }

bool hasFollowers(const RobotModel& robot, int joint) {
  return std::any_of(robot.joints.begin(), robot.joints.end(),
                     [&](const Joint& other) { return other.mimic && other.mimic->joint == joint; });
}

JointRange rangeOf(const RobotModel& robot, int index) {
  const Joint& joint = robot.joints[index];
  if (!hasLimits(joint)) {
    const double half = joint.type == Joint::Type::Prismatic ? kGuess : kPi;
    return {index, -half, half};
  }
  const double middle = 0.5 * (joint.lower + joint.upper);
  const bool repeats = joint.type == Joint::Type::Revolute && joint.upper - joint.lower > 2.0 * kPi;
  if (repeats && !hasFollowers(robot, index)) return {index, middle - kPi, middle + kPi};
  return {index, joint.lower, joint.upper};
}

}  // namespace

double JointRange::typeable(double position) const {
  if (!(width() > 0)) return lower;
  // Dividing by a power of ten gives the number that the decimals stand for; multiplying by 0.0001 does not.
  const double per_unit = std::pow(10.0, 4.0 - std::floor(std::log10(width())));
  return std::clamp(std::round(position * per_unit) / per_unit, lower, upper);
}

std::vector<JointRange> jointRanges(const RobotModel& robot) {
  std::vector<JointRange> ranges;
  for (int i = 0; i < static_cast<int>(robot.joints.size()); ++i) {
    const Joint& joint = robot.joints[i];
    if (hasOnePosition(joint) && !joint.mimic) ranges.push_back(rangeOf(robot, i));
  }
  return ranges;
}

bool hasKnownRange(const RobotModel& robot, int joint) {
  const int leader = robot.leaderOf(joint).joint;
  if (hasLimits(robot.joints[leader])) return true;
  // A full turn of a leader covers all of its own poses, but not all of its followers' poses.
  return leader == joint && hasOnePosition(robot.joints[joint]) && robot.joints[joint].type != Joint::Type::Prismatic;
}

const JointRange* intervalOf(const std::vector<JointRange>& box, int joint) {
  const auto found = std::find_if(box.begin(), box.end(), [&](const JointRange& own) { return own.joint == joint; });
  return found == box.end() ? nullptr : &*found;
}

Positions randomPositions(const RobotModel& robot, const std::vector<JointRange>& ranges, std::mt19937_64& random) {
  Positions positions(robot.joints.size(), 0.0);
  drawWithin(inequalitiesOver(ranges, robot), positions, [&](std::uint32_t) {
    for (const JointRange& range : ranges) {
      std::uniform_real_distribution<double> fraction;
      positions[range.joint] = range.typeable(range.lower + fraction(random) * range.width());
    }
  });
  return positions;
}

std::vector<JointInequality> inequalitiesOver(const std::vector<JointRange>& ranges, const RobotModel& robot) {
  std::vector<JointInequality> over;
  std::copy_if(robot.inequalities.begin(), robot.inequalities.end(), std::back_inserter(over),
               [&](const JointInequality& inequality) {
                 return std::all_of(
                     inequality.terms.begin(), inequality.terms.end(),
                     [&](const JointInequality::Term& term) { return intervalOf(ranges, term.joint) != nullptr; });
               });
  return over;
}

std::vector<int> jointsBetween(const RobotModel& robot, int body_a, int body_b) {
  std::vector<int> up, down;
  while (body_a != body_b) {  // parents come first, so the later body is the one whose joint is on the path
    const bool from_a = body_a > body_b;
    int& body = from_a ? body_a : body_b;
    if (robot.bodies[body].joint >= 0) (from_a ? up : down).push_back(robot.bodies[body].joint);
    body = robot.bodies[body].parent;
  }
  up.insert(up.end(), down.rbegin(), down.rend());
  return up;
}

std::vector<JointRange> rangesBetween(const RobotModel& robot, const std::vector<JointRange>& ranges, int link_a,
                                      int link_b) {
  std::set<int> leaders;
  for (const int joint : jointsBetween(robot, robot.links[link_a].body, robot.links[link_b].body)) {
    leaders.insert(robot.leaderOf(joint).joint);
  }
  std::vector<JointRange> between;
  std::copy_if(ranges.begin(), ranges.end(), std::back_inserter(between),
               [&](const JointRange& range) { return leaders.count(range.joint) > 0; });
  return between;
}

}  // namespace proximity_server::scene
