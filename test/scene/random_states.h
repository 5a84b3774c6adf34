#pragma once

#include "chance.h"
#include "proximity_server/scene/model/robot_model.h"

#include <Eigen/Core>

#include <cmath>
#include <vector>

namespace proximity_server::scene {

/// Uniform within the limits of a joint, and from -pi to pi where it has none.
inline double randomPosition(const Joint& joint, Chance& chance) {
  return chance.between(std::isfinite(joint.lower) ? joint.lower : -M_PI,
                        std::isfinite(joint.upper) ? joint.upper : M_PI);
}

inline std::vector<double> randomPositions(const RobotModel& robot, Chance& chance) {
  std::vector<double> positions;
  for (const Joint& joint : robot.joints) positions.push_back(randomPosition(joint, chance));
  return positions;
}

/// A row for each state, a column for each of RobotModel::joints.
inline Eigen::MatrixXd randomStates(const RobotModel& robot, int count, unsigned seed) {
  Chance chance(seed);
  Eigen::MatrixXd states(count, static_cast<Eigen::Index>(robot.joints.size()));
  for (Eigen::Index i = 0; i < states.rows(); ++i)
    for (Eigen::Index j = 0; j < states.cols(); ++j) states(i, j) = randomPosition(robot.joints[j], chance);
  return states;
}

/// Edges between random states: some of a few states, others of many, each state near the one before.
inline Eigen::MatrixXd statesAlongEdges(const RobotModel& robot, int count, unsigned seed) {
  constexpr int kLengths[] = {150, 2, 9, 60, 5, 1, 8, 30};
  const Eigen::MatrixXd ends = randomStates(robot, count + 1, seed);
  Eigen::MatrixXd states(count, ends.cols());
  for (int edge = 0, first = 0; first < count; first += kLengths[edge++ % 8])
    for (int i = 0; i < kLengths[edge % 8] && first + i < count; ++i)
      states.row(first + i) = ends.row(edge) + 0.01 * i * (ends.row(edge + 1) - ends.row(edge));
  return states;
}

inline std::vector<double> positionsOf(const Eigen::MatrixXd& states, Eigen::Index state) {
  std::vector<double> positions;
  for (Eigen::Index j = 0; j < states.cols(); ++j) positions.push_back(states(state, j));
  return positions;
}

}  // namespace proximity_server::scene
