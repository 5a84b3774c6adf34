#pragma once

#include "proximity_server/narrowphase/query_types.h"
#include "proximity_server/narrowphase/shape/shape.h"

#include <Eigen/Geometry>

#include <array>
#include <optional>

namespace proximity_server::narrowphase {

/// Two boxes and their fifteen separating axes: the face normals of each box, and the cross products of an edge of a
/// and an edge of b.
///
/// The penetration depth of overlapping boxes is along one of these axes, so the greatest separation is their signed
/// distance. Boxes that are apart may be farther from each other than the greatest separation.
///
/// Frame:   the frame of a.
/// Error:   a few eps of the sizes and the offset. Every edge of a lies along a coordinate axis, so the axes are exact.
/// Source:  Gottschalk, Lin, Manocha, OBBTree, SIGGRAPH 1996, Theorem 1.
/// Differs: depth and points are computed, too. Edges count as parallel only if their product has no direction.
class BoxPair {
 public:
  BoxPair(const Eigen::Vector3d& half_a, const Eigen::Vector3d& half_b, const Eigen::Isometry3d& a_T_b);

  /// [m] Greatest separation, along normal(). It is the signed distance of boxes that overlap, and a lower bound of it
  /// for boxes that are apart.
  double separation() const { return separations_[best_]; }
  Eigen::Vector3d normal() const { return normalOf(best_); }

  /// The signed distance without bounds, if it is the greatest separation: of boxes that overlap, and of boxes apart
  /// whose nearest points are a vertex and a point of a face, or points of two edges. Returns nullopt if, within
  /// `tolerance` [m], the feature along the normal is not a single vertex or a single pair of edges, or if the points
  /// lie outside of the boxes by more than about `rounding` [m], by which the caller widens the bounds.
  std::optional<SignedDistance> distanceAlongNormal(double tolerance, double rounding) const;

 private:
  // Axes 0 to 2 are the face normals of a, 3 to 5 the ones of b; axis 6 + 3 i + j is the product of edges i of a and j
  // of b.
  static constexpr int kAxes = 15;

  Eigen::Vector3d axisOf(int axis) const;
  Eigen::Vector3d normalOf(int axis) const;
  void measure(int axis, double separation);
  bool isUnique(const Eigen::Vector3d& best, double tolerance) const;
  std::optional<Eigen::Vector3d> deepestOnA(const Eigen::Vector3d& normal, double tolerance) const;
  std::optional<Eigen::Vector3d> vertexInFaceOfA(const Eigen::Vector3d& normal, double tolerance) const;
  std::optional<Eigen::Vector3d> vertexInFaceOfB(const Eigen::Vector3d& normal, double tolerance) const;
  std::optional<Eigen::Vector3d> onCrossingEdges(const Eigen::Vector3d& normal, double tolerance) const;

  const Eigen::Vector3d& half_a_;
  const Eigen::Vector3d& half_b_;
  const Eigen::Isometry3d& a_T_b_;
  std::array<double, kAxes> separations_;
  int best_ = 0;
};

/// [m] Upper bound of the signed distance of two boxes that overlap, by their fifteen axes. It is infinite if they leave
/// open whether the boxes do.
///
/// It takes neither a root nor a division, as the products of edges are not normalised. None is longer than 1, so a
/// negative separation along it, times its length, is not less than the separation. The component of the product of two
/// axes of b along an edge of a is the component of the third axis of b.
///
/// The products of nearly parallel edges have no direction and leave open whether the boxes overlap. Let the tilt be the
/// largest sum of the two smaller cosines of an axis of one box with the axes of the other one. If b reaches farther
/// than the tilt times its largest half size in each direction, it contains a box parallel to a whose half sizes are
/// smaller by that, and which reaches less far along the axes of a than b does by at most twice that. Two parallel
/// boxes overlap by as much as along the axis along which they overlap the least.
///
/// Error: none, if `rounding` is csoRounding() and isRotation() is true. The axes of b then differ by less than 96 eps
///        from a rotation, so that the product of two and the third differ by less than 170 eps. That changes a
///        separation by less than 30 roundings, and a length above 1 by 4; the bound has 64 more than the separation.
double overlapByAxes(const Eigen::Vector3d& half_a, const Eigen::Vector3d& half_b, const Eigen::Isometry3d& a_T_b,
                     double rounding);

/// The points of two boxes that are the nearest to each other, and the gap [m] between the support planes across their
/// difference.
struct NearestOfBoxes {
  Eigen::Vector3d on_a, on_b;
  double distance;  ///< [m] between the points, never less than between the boxes
  double gap;  ///< [m] between the support planes, never more than the distance of the boxes; both but for rounding
};

/// Nearest points of two boxes that are apart.
///
/// 1. Start with the point of a nearest to the centre of b, and take the point of b nearest to it.
/// 2. Move the point of b along each of b's three edges in turn. The squared distance from a is a piecewise quadratic
///    function of the place along an edge, with a piece for each face, edge and corner of a. Newton's method on the
///    piece of the present place gives the next one; the box limits it.
/// 3. End if the support planes across the difference of both points are as far from each other as the points, within
///    `tolerance` [m]. Otherwise repeat from step 2.
///
/// If the nearest points are unique, at most two coordinates of both together are inside of their limits. So the steps
/// end in the nearest point as soon as they know its features: after one sweep in 82 %, after two in 95 % of random
/// pairs.
///
/// Frame:   the frame of a.
/// Failure: nullopt if the boxes overlap or are less than 1e-140 m apart, or if the points are not found in a few sweeps.
/// Source:  Bertsekas, Nonlinear Programming, 1999, 2.7 (block coordinate descent); Ericson, Real-Time Collision
///          Detection, 2005, 5.1.4 (the point of a box nearest to a point).
std::optional<NearestOfBoxes> nearestOfBoxes(const Eigen::Vector3d& half_a, const Eigen::Vector3d& half_b,
                                             const Eigen::Isometry3d& a_T_b, double tolerance);

/// True if, within the tolerance, only one pair of points of two boxes has the distance along this unit normal: the
/// features of the boxes along it (vertex, edge or face) have no direction in common.
bool boxesMeetInOnePoint(const Eigen::Vector3d& half_a, const Eigen::Vector3d& half_b, const Eigen::Isometry3d& a_T_b,
                         const Eigen::Vector3d& normal, double tolerance);

}  // namespace proximity_server::narrowphase
