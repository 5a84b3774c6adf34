#pragma once

#include "proximity_server/narrowphase/shape/eigen_alignment.h"

#include <Eigen/Core>

namespace proximity_server::scene {

/// The joint positions [rad] or [m] of many states: a row for each state, a column for each of RobotModel::joints. The
/// entries of mimic joints are ignored. Any strides are legal, so that the positions of a joint or of a state may be
/// adjacent in memory.
using States = Eigen::Ref<const Eigen::MatrixXd, 0, Eigen::Stride<Eigen::Dynamic, Eigen::Dynamic>>;

}  // namespace proximity_server::scene
