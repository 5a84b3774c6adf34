#pragma once

#include "scene/pieces/triangle_tree.h"

#include <Eigen/Geometry>

#include <array>
#include <vector>

namespace proximity_server::scene {

/// The space that closed triangles enclose, even if they overlap.
///
/// Method: a ray from the point counts the triangles that it crosses, with the sign of their side (the winding number,
///         which is 0 outside, and 0 in a cavity whose wall faces into it). There are two rays, in directions that are
///         unusual in files. A tree of boxes for each direction finds the triangles that the ray may cross.
class EnclosedSpace {
 public:
  explicit EnclosedSpace(const TriangleBoxes& closed);

  /// True if the winding number of p is not 0. May throw Effort::Exceeded.
  bool holds(const Eigen::Vector3d& p, Effort& effort) const;

  /// The winding number: how often the triangles surround a point, with the sign of their side. The first ray whose
  /// crossings rounding cannot change decides. If there is none, the smaller number is returned, so that a ray that grazes
  /// an edge does not turn outside into inside. May throw Effort::Exceeded.
  int windingNumber(const Eigen::Vector3d& p, Effort& effort) const;

  /// False only if p is proven to be outside, if it is farther from the triangles than rounding. The first ray whose
  /// crossings rounding cannot change decides: the winding number is the same along each such ray. True if there is none.
  bool mayHold(const Eigen::Vector3d& p) const;

 private:
  struct Winding {
    int number = 0;
    bool is_certain = true;  ///< true if rounding cannot have changed the number
  };

  /// The triangles in a frame whose z axis is the direction of the ray.
  class View {
   public:
    View(const Eigen::Matrix3d& turn, const TriangleBoxes& closed) : turn_(turn), tree_(closed, turn) {}
    Winding winding(const Eigen::Vector3d& p, Effort& effort) const;

   private:
    Eigen::Matrix3d turn_;
    TriangleBoxes tree_;
  };

  std::array<View, 2> views_;
};

}  // namespace proximity_server::scene
