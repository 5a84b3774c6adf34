#include "narrowphase/rotation_between.h"

#include <Eigen/Geometry>

namespace proximity_server {

Eigen::Matrix3d rotationBetween(const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
  return Eigen::Quaterniond::FromTwoVectors(from, to).toRotationMatrix();
}

}  // namespace proximity_server
