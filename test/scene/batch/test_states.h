#pragma once

#include "proximity_server/scene/model/robot_model.h"

#include <Eigen/Core>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

namespace proximity_server::scene {

/// Uniform within the limits of each joint, and from -pi to pi where it has none.
inline Eigen::MatrixXd randomStates(const RobotModel& robot, int count, unsigned seed) {
  std::mt19937 random(seed);
  Eigen::MatrixXd states(count, static_cast<Eigen::Index>(robot.joints.size()));
  for (Eigen::Index i = 0; i < states.rows(); ++i) {
    for (Eigen::Index j = 0; j < states.cols(); ++j) {
      const Joint& joint = robot.joints[j];
      const double lower = std::max(joint.lower, -M_PI), upper = std::min(joint.upper, M_PI);
      states(i, j) = lower < upper ? std::uniform_real_distribution<double>(lower, upper)(random) : lower;
    }
  }
  return states;
}

inline std::vector<double> positionsOf(const Eigen::MatrixXd& states, Eigen::Index state) {
  std::vector<double> positions;
  for (Eigen::Index j = 0; j < states.cols(); ++j) positions.push_back(states(state, j));
  return positions;
}

}  // namespace proximity_server::scene
