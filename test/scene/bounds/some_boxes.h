#pragma once

#include "chance.h"

#include <Eigen/Geometry>

#include <vector>

namespace proximity_server::scene {

/// Returns random boxes about the origin.
inline std::vector<Eigen::AlignedBox3d> someBoxes(int count, Chance& chance) {
  std::vector<Eigen::AlignedBox3d> boxes;
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector3d corner(chance.between(-5, 5), chance.between(-5, 5), chance.between(-5, 5));
    boxes.emplace_back(corner, corner + Eigen::Vector3d::Constant(chance.between(0, 1)));
  }
  return boxes;
}

}  // namespace proximity_server::scene
