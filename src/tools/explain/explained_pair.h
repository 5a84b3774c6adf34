#pragma once

#include "proximity_server/narrowphase/shape/shape.h"

#include <Eigen/Geometry>

#include <string>
#include <vector>

namespace proximity_server::tools {

/// A shape, and what people call it and its vertices.
struct ExplainedShape {
  narrowphase::Shape shape;
  std::string description;
  std::vector<Eigen::Vector3d> points;  ///< the points of a hull, in the order in which it names them; else empty
};

/// The pair that is explained: two shapes, and the pose of b in the frame of a.
struct ExplainedPair {
  ExplainedShape a, b;
  Eigen::Isometry3d a_T_b;
};

}  // namespace proximity_server::tools
