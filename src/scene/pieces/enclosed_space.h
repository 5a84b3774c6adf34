#pragma once

#include <Eigen/Geometry>
#include <array>
#include <vector>

#include "scene/pieces/triangle_tree.h"

namespace proximity_server::scene {

/// The solid inside closed triangles, whichever way they overlap.
///
/// Method: a ray from the point counts the triangles that it crosses, with the sign of their side (the winding number,
///         which is 0 outside, and in a cavity whose wall faces into it). There are two rays in directions that are
///         unusual in files. A tree of boxes for each direction finds the triangles that the ray may cross.
class EnclosedSpace {
 public:
  explicit EnclosedSpace(const std::vector<Triangle>& closed);

  /// Two rays must agree, so that a ray which grazes an edge does not turn outside into inside. May throw
  /// Effort::Exceeded.
  bool holds(const Eigen::Vector3d& p, Effort& effort) const;

  /// How often the triangles surround a point, with the sign of their side; of two rays that disagree the smaller number. May
  /// throw Effort::Exceeded.
  int windingNumber(const Eigen::Vector3d& p, Effort& effort) const;

  /// False only where that is proven: by a ray on which no rounding can change a crossing, for points that are farther
  /// from the triangles than rounding. True also where neither ray is such a one.
  bool mayHold(const Eigen::Vector3d& p) const;

 private:
  struct Winding {
    int number = 0;
    bool is_certain = true;  ///< rounding cannot have changed it
  };

  /// The triangles in a frame whose z axis is the ray, which begins at a point and goes up.
  class View {
   public:
    View(const Eigen::Matrix3d& turn, const std::vector<Triangle>& closed);
    Winding winding(const Eigen::Vector3d& p, Effort& effort) const;

   private:
    Eigen::Matrix3d turn_;
    TriangleBoxes tree_;  ///< split along x and y only, across the ray
  };

  std::array<View, 2> views_;
};

}  // namespace proximity_server::scene
