#include "scene/model/body_pose.h"

#include "proximity_server/narrowphase/shape/rigid_pose.h"

#include <cmath>

namespace proximity_server::scene {

std::optional<Eigen::Isometry3d> usablePose(const std::optional<Eigen::Isometry3d>& pose) {
  if (!pose || !std::isfinite(pose->translation().squaredNorm())) return std::nullopt;
  return narrowphase::rigidPose(*pose);
}

}  // namespace proximity_server::scene
