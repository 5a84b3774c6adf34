#pragma once

#include "proximity_server/scene/model/kinematics.h"

#include <Eigen/Geometry>

#include <limits>
#include <vector>

namespace proximity_server::scene {

/// A state within the uncertainty, in which a pair is certainly closer than a threshold.
struct ReachedState {
  std::vector<double> displacements;  ///< [rad] or [m] of the position of each of RobotModel::joints, also of followers
  BodyPoses poses;                    ///< of all bodies, with displaced joints, frames and bases
  /// The motion of each of the two shapes from its present pose, in the frame of the poses; the motion of an object
  /// includes its own uncertainty.
  Eigen::Isometry3d displacement_a = Eigen::Isometry3d::Identity(), displacement_b = Eigen::Isometry3d::Identity();
  double upper_bound = std::numeric_limits<double>::infinity();  ///< [m] of the signed distance, with swollen surfaces
};

}  // namespace proximity_server::scene
