#pragma once

#include "scene/pieces/enclosed_space.h"
#include "scene/pieces/triangle_tree.h"

#include <Eigen/Geometry>

#include <limits>
#include <vector>

namespace proximity_server::scene {

/// The solid inside the closed parts of a mesh whose convex pieces leave some of it empty.
///
/// A point is inside if the winding number of all closed parts around it is not 0: parts that face outwards and overlap
/// are one solid, and a part inside another one that faces into a cavity takes the cavity away.
/// Frame: the frame of the mesh. Metres.
class Interior {
 public:
  /// `closed`: at least one triangle.
  explicit Interior(const std::vector<Triangle>& closed);

  /// The box of the whole solid.
  const Eigen::AlignedBox3d& box() const { return box_; }

  /// The place of a point relative to the solid.
  struct Place {
    double lower_bound, upper_bound;  ///< [m] bounds of its signed distance from the nearest triangle, negative inside
    Eigen::Vector3d nearest;          ///< the nearest point on that triangle
    /// A unit vector: the shortest way out, or, for a point outside, the direction from the triangle to the point.
    Eigen::Vector3d outwards;
  };

  /// Finds the place of a point. For a point outside that is farther than `reach` [m], the upper bound may be infinite.
  ///
  /// If closed parts overlap, the nearest triangle may lie within the solid. The depth in the solid is then larger.
  /// Error:  the bounds hold except for a rounding of a few eps of the coordinates. They are wider than that only at
  ///         triangles whose height is near to rounding.
  /// Source: Ericson, Real-Time Collision Detection, 2005 (nearest point of a triangle). Unlike there, the nearest
  ///         point is the best of face and edges, and the corner that is least far along the way to it proves the lower
  ///         bound.
  Place placeOf(const Eigen::Vector3d& p, double reach = std::numeric_limits<double>::infinity()) const;

  /// True if a triangle is found within `distance` [m] of a point, so that the point lies no deeper than that. Ends at the
  /// first such triangle, and asks no ray: it costs much less than placeOf(). A triangle at that distance within a
  /// rounding of a few eps of the coordinates may be missed.
  bool hasSurfaceWithin(const Eigen::Vector3d& p, double distance) const;

 private:
  TriangleBoxes surface_;
  EnclosedSpace space_;
  std::vector<Eigen::Vector3d> normals_;  ///< of the triangles of surface_; unit vectors, or zero
  Eigen::AlignedBox3d box_;
};

}  // namespace proximity_server::scene
