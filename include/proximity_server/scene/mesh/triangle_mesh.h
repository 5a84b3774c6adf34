#pragma once

#include "proximity_server/narrowphase/shape/eigen_alignment.h"

#include <Eigen/Core>

#include <array>
#include <string>
#include <vector>

namespace proximity_server::scene {

struct TriangleMesh {
  std::vector<Eigen::Vector3d> vertices;  ///< [m], in the frame of the <geometry>
  std::vector<std::array<int, 3>> triangles;
};

}  // namespace proximity_server::scene
