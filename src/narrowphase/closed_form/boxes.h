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
/// Frame:   that of a.
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

  /// The signed distance of boxes that overlap, without bounds. Returns nullopt if, within `tolerance` [m], the deepest
  /// feature is not a single vertex or a single pair of edges, or if the points lie outside of the boxes by more than
  /// about `rounding` [m], by which the caller widens the bounds.
  std::optional<SignedDistance> overlap(double tolerance, double rounding) const;

 private:
  // Axes 0 to 2 are the face normals of a, 3 to 5 those of b; axis 6 + 3 i + j is the product of edges i of a and j of
  // b.
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

}  // namespace proximity_server::narrowphase
