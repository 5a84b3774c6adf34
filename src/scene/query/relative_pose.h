#pragma once

#include <Eigen/Core>

namespace proximity_server::scene {

/// Where the body of one volume stands in the frame of the body of another.
struct RelativePose {
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();
};

}  // namespace proximity_server::scene
