#pragma once

#include <Eigen/Core>

#include <optional>

namespace proximity_server::scene {

/// The question of the example avoiding_controller, in C++: the velocity that is wanted, and its constraints.
struct VelocityProgram {
  Eigen::VectorXd wanted;
  Eigen::MatrixXd matrix;  ///< the rows, and the bound of each; -infinity if it does not count
  Eigen::VectorXd lower_bounds;
  Eigen::VectorXd lower, upper;  ///< of the velocity, around 0
};

struct YieldingVelocity {
  Eigen::VectorXd velocity;
  Eigen::VectorXd pushes;  ///< of each row: 0 if it could be left out
};

/// As yielding_velocity() in src/demo/avoiding_controller/allowed_velocity.py, where it is explained, with the same
/// algorithm; nullopt if rounding does not find it.
std::optional<YieldingVelocity> yieldingVelocity(const VelocityProgram& program);

}  // namespace proximity_server::scene
