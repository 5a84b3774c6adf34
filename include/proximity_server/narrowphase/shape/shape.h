#pragma once

#include "proximity_server/narrowphase/shape/eigen_alignment.h"
#include "proximity_server/narrowphase/shape/hull_support.h"

#include <Eigen/Geometry>

#include <memory>

namespace proximity_server::narrowphase {

// The primitives, as URDF describes them: centred at the origin of their own frame, axis along z, full sizes, metres.
struct Sphere {
  double radius;
};
struct Capsule {
  double radius;
  double length;  ///< between the centres of the caps; a capsule of length 0 is a sphere
};
struct Box {
  Eigen::Vector3d size;  ///< full edge lengths
};
struct Cylinder {
  double radius;
  double length;
};
struct Cone {
  double radius;
  double length;  ///< base at z = -length/2, apex at z = +length/2
};
struct Ellipsoid {
  Eigen::Vector3d radii;
};

/// A convex shape: a core, enlarged by a ball of radius `margin` about each of its points.
///
/// GJK and EPA work on the core only; the margin is added in closed form. A sphere has a point as its core, a capsule a
/// segment, and padding is an exact offset of the surface.
///
/// Frame:   the shape's own. Metres.
/// Failure: the constructors throw std::invalid_argument naming the dimension that is not finite or not positive (a
///          capsule's length may be 0). Nothing is checked later.
class Shape {
 public:
  enum class Kind : unsigned char { Point, Segment, Box, Cylinder, Cone, Ellipsoid, Hull, Sweep };

  // Implicit on purpose: signedDistance(Sphere{0.2}, Box{{1, 1, 1}}, a_T_b).
  Shape(const Sphere& sphere);        // NOLINT(google-explicit-constructor)
  Shape(const Capsule& capsule);      // NOLINT(google-explicit-constructor)
  Shape(const Box& box);              // NOLINT(google-explicit-constructor)
  Shape(const Cylinder& cylinder);    // NOLINT(google-explicit-constructor)
  Shape(const Cone& cone);            // NOLINT(google-explicit-constructor)
  Shape(const Ellipsoid& ellipsoid);  // NOLINT(google-explicit-constructor)
  Shape(ConvexHull hull);             // NOLINT(google-explicit-constructor)

  /// Returns the same core with the margin enlarged by `padding` [m]: an exact offset of the surface.
  /// Throws std::invalid_argument if the margin would become negative or not finite.
  Shape padded(double padding) const;

  /// Returns the convex hull of the shape in its own place and the shape moved by `end`. Its support point is the
  /// farther one of the two support points. If `end` is a translation, this is the swept volume; see sweptShape() for
  /// other motions. Throws std::invalid_argument if rigidPose() refuses `end`.
  Shape sweptTo(const Eigen::Isometry3d& end) const;

  Kind kind() const { return kind_; }
  double margin() const { return margin_; }

  /// Half sizes of the core along x, y, z: (0, 0, length/2) for a segment, (r, r, length/2) for a cylinder or cone, the
  /// radii for an ellipsoid. They are zero for a point, and not used for a hull and a sweep.
  const Eigen::Vector3d& halfExtents() const { return half_extents_; }

  /// Vertices and adjacency, and the support mapping; only for Kind::Hull.
  const ConvexHull& hull() const { return hull_->hull(); }
  const HullSupport& hullSupport() const { return *hull_; }

  /// True if this is a hull whose distance from the origin of its frame is thousands of times its size. Such a hull has
  /// a copy with its first vertex at the origin: nearOrigin(), with the same margin. For any other shape, nearOrigin()
  /// returns the shape itself.
  bool isFarFromOrigin() const { return near_origin_ != nullptr; }
  Shape nearOrigin() const;

  /// The shape that is swept, and the pose at which the sweep ends; only for Kind::Sweep.
  struct Sweep;
  const Sweep& sweep() const { return *sweep_; }

  /// True if the core is the hull of finitely many points.
  bool isPolytope() const;

  /// A point inside of the core, and the radius [m] of a ball about it that contains the core (without the margin).
  const Eigen::Vector3d& centre() const { return centre_; }
  double coreRadius() const { return core_radius_; }

  /// [m] Radius of a ball about centre() that lies inside of the core: half the least size of a box, the least distance
  /// of a face of a hull; 0 for a point and a segment. It is negative, by a few roundings, for a flat hull: rounding
  /// may have moved the centre out of it by this much.
  double innerRadius() const { return inner_radius_; }

  /// [m] Upper bound of the distance of any point of the core from the origin of its frame.
  double coreReach() const { return core_reach_; }

 private:
  Shape(Kind kind, double margin, const Eigen::Vector3d& half_extents, double core_radius, double inner_radius);

  Kind kind_;
  double margin_;
  double core_radius_;
  double inner_radius_;
  double core_reach_;
  Eigen::Vector3d half_extents_;
  Eigen::Vector3d centre_ = Eigen::Vector3d::Zero();
  std::shared_ptr<const HullSupport> hull_;
  std::shared_ptr<const Shape> near_origin_;  // without margin
  std::shared_ptr<const Sweep> sweep_;
};

struct Shape::Sweep {
  Shape shape;  ///< without margin
  Eigen::Isometry3d end;
};

}  // namespace proximity_server::narrowphase
