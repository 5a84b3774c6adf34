#include "benchmark/motions.h"

#include "chance.h"
#include "proximity_server/scene/model/kinematics.h"

#include <algorithm>
#include <cmath>

namespace proximity_server::benchmark {

using namespace narrowphase;
using namespace scene;
namespace {

constexpr double kStep = 1e-3;  // [s]
constexpr double kPi = 3.14159265358979323846;

struct Range {
  double lower, upper;
  double middle() const { return 0.5 * (lower + upper); }
  double half() const { return 0.5 * (upper - lower); }
};

Range rangeOf(const Joint& joint) {
  return {std::isfinite(joint.lower) ? joint.lower : -kPi, std::isfinite(joint.upper) ? joint.upper : kPi};
}

/// position(t) = middle + amplitude * sin(frequency * t + phase)
struct Swing {
  double middle, amplitude;
  double frequency;  ///< [rad/s]
  double phase;

  double at(double time) const { return middle + amplitude * std::sin(frequency * time + phase); }
};

Swing swingOf(const Joint& joint, Chance& random) {
  const Range range = rangeOf(joint);
  const double wanted = joint.type == Joint::Type::Prismatic ? 0.1 : 1.0;
  const double speed = std::min(wanted, joint.max_velocity);
  const double slowest = 2.0 * kPi * random.between(0.1, 0.5), phase = random.between(0.0, 2.0 * kPi);
  const double amplitude = std::min(range.half(), speed / slowest);
  return {range.middle(), amplitude, amplitude > 0.0 ? speed / amplitude : 0.0, phase};
}

Eigen::RowVectorXd randomRow(const RobotModel& robot, Chance& random) {
  Eigen::RowVectorXd row(static_cast<Eigen::Index>(robot.joints.size()));
  for (std::size_t j = 0; j < robot.joints.size(); ++j) {
    const Range range = rangeOf(robot.joints[j]);
    row[static_cast<Eigen::Index>(j)] = random.between(range.lower, range.upper);
  }
  return row;
}

/// Returns how many steps of no more than 1 degree lead from one state to the other. Mimic joints do not count.
int stepsOf(const RobotModel& robot, const Eigen::RowVectorXd& from, const Eigen::RowVectorXd& to) {
  double longest = 0.0;
  for (std::size_t j = 0; j < robot.joints.size(); ++j) {
    const auto column = static_cast<Eigen::Index>(j);
    if (!robot.joints[j].mimic) longest = std::max(longest, std::abs(to[column] - from[column]));
  }
  return static_cast<int>(std::ceil(longest / (kPi / 180.0)));
}

}  // namespace

std::vector<BodyPoses> randomStates(const RobotModel& robot, int states) {
  const PositionTable table = randomPositions(robot, states);
  std::vector<BodyPoses> poses;
  for (int i = 0; i < states; ++i) poses.push_back(forwardKinematics(robot, positionsOf(table, i)));
  return poses;
}

std::vector<double> positionsOf(const PositionTable& table, Eigen::Index state) {
  const Eigen::VectorXd row = table.row(state);
  return {row.data(), row.data() + row.size()};
}

PositionTable randomPositions(const RobotModel& robot, int states) {
  Chance random(11);
  PositionTable table(states, static_cast<Eigen::Index>(robot.joints.size()));
  for (int i = 0; i < states; ++i) table.row(i) = randomRow(robot, random);
  return table;
}

PositionTable edgePositions(const RobotModel& robot, int states) {
  Chance random(14);
  PositionTable table(states, static_cast<Eigen::Index>(robot.joints.size()));
  Eigen::RowVectorXd from = randomRow(robot, random), to = randomRow(robot, random);
  for (int i = 0, step = 0; i < states; ++i, ++step) {
    int steps = std::max(stepsOf(robot, from, to), 1);
    if (step == steps) {
      from = to;
      to = randomRow(robot, random);
      steps = std::max(stepsOf(robot, from, to), 1);
      step = 0;
    }
    table.row(i) = from + (static_cast<double>(step) / steps) * (to - from);
  }
  return table;
}

std::vector<BodyPoses> coherentMotion(const RobotModel& robot, int states) {
  Chance random(12);
  std::vector<Swing> swings;
  for (const Joint& joint : robot.joints) swings.push_back(swingOf(joint, random));
  std::vector<BodyPoses> poses;
  std::vector<double> positions(robot.joints.size());
  for (int i = 0; i < states; ++i) {
    for (std::size_t j = 0; j < positions.size(); ++j) positions[j] = swings[j].at(kStep * i);
    poses.push_back(forwardKinematics(robot, positions));
  }
  return poses;
}

std::vector<JointMotion> randomJointMotions(const RobotModel& robot, int motions) {
  Chance random(13);
  std::vector<JointMotion> result;
  for (int i = 0; i < motions; ++i) {
    JointMotion motion;
    for (const Joint& joint : robot.joints) {
      const Range range = rangeOf(joint);
      const double fastest = std::isfinite(joint.max_velocity) ? joint.max_velocity : 1.0;
      motion.from.push_back(random.between(range.lower, range.upper));
      const double end = motion.from.back() + random.between(-fastest, fastest);
      motion.to.push_back(std::clamp(end, joint.lower, joint.upper));
    }
    result.push_back(motion);
  }
  return result;
}

}  // namespace proximity_server::benchmark
