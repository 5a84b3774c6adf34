#pragma once

#include "oracle/motion_oracle.h"

#include <array>
#include <vector>

namespace proximity_server::narrowphase {

/// A convex shape for questions about points and lines, in long double: sphere, capsule, box, cylinder, or a hull without
/// margin. Of a hull it takes vertices and triangles as they are, and shares no other code with the library.
class PointOracle {
 public:
  /// Throws std::invalid_argument for any other shape.
  explicit PointOracle(const Shape& shape);

  /// A ball about the shape.
  const Vector3l& centre() const { return centre_; }
  long double radius() const { return radius_; }

  /// The signed distance of a point, in the shape's frame.
  ///
  /// Closed forms: within rounding.
  /// Hulls: proven from both sides. Outside, the nearest point of the triangles is a point of the hull, and no vertex lies
  ///        nearer than `low` along the direction from it. Inside, each plane along the normal of a triangle with all
  ///        vertices behind it is a way out; and if the triangles are the whole surface, none of them is nearer than
  ///        -`high`.
  DistanceBounds distance(const Vector3l& p) const;

  /// The part of a line within the shape.
  struct Section {
    long double begin, end;  ///< [m] from the origin; begin > end: the line misses the shape
    Vector3l entry_normal;   ///< of the surface at the begin

    bool isEmpty() const { return !(begin <= end); }
  };
  /// `direction`: of unit length. No line meets a hull that is a segment or a point, nor a polygon in whose plane it is.
  /// Error: that of a shape whose surface is displaced by rounding.
  Section section(const Vector3l& origin, const Vector3l& direction) const;

 private:
  struct Plane {
    Vector3l normal;
    long double height;  ///< of the vertex that is the farthest along the normal
  };

  void addHull();
  void addPlane(const Vector3l& normal);
  Vector3l corner(int vertex) const { return shape_.hull().vertices()[vertex].cast<long double>(); }
  DistanceBounds hullDistance(const Vector3l& p) const;
  Section polygonSection(const Vector3l& origin, const Vector3l& direction) const;

  Shape shape_;
  Vector3l centre_ = Vector3l::Zero();
  long double radius_;
  Vector3l normal_ = Vector3l::Zero();              ///< of the largest triangle of the hull
  std::vector<Plane> planes_;                       ///< of the hull: all of it is behind each of them
  std::vector<std::array<Vector3l, 3>> triangles_;  ///< its surface
  struct Rounded {
    std::array<Eigen::Vector3d, 3> corners;
    Eigen::Vector3d centre;
    double radius;  ///< of a ball about the centre that has the corners
  };
  std::vector<Rounded> rounded_;  ///< the triangles
};

/// The point of a triangle that is nearest to `p`. A triangle that is a segment or a point is legal.
template <typename Real>
Eigen::Matrix<Real, 3, 1> nearestOf(const std::array<Eigen::Matrix<Real, 3, 1>, 3>& corners,
                                    const Eigen::Matrix<Real, 3, 1>& p);

}  // namespace proximity_server::narrowphase
