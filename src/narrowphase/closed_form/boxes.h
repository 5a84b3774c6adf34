#pragma once

#include <Eigen/Geometry>
#include <array>
#include <optional>

#include "proximity_server/narrowphase/query_types.h"
#include "proximity_server/narrowphase/shape/shape.h"

namespace proximity_server::narrowphase {

/// Two boxes by their fifteen separating axes: the face normals of each, and the products of an edge of each.
///
/// Frame: that of a. Overlapping boxes leave each other along one of these axes, so the greatest separation is their
/// signed distance; boxes that are apart may be farther than that.
/// Error: a few eps of the sizes and the offset: the axes are exact, as every product has one edge along a coordinate.
/// Source: Gottschalk, Lin, Manocha, OBBTree, SIGGRAPH 1996, Theorem 1; here with the depth, points and no tolerance
/// for
///         parallel edges but the one that their product has no direction.
class BoxPair {
 public:
  BoxPair(const Eigen::Vector3d& half_a, const Eigen::Vector3d& half_b, const Eigen::Isometry3d& a_T_b);

  /// [m] along normal(): a lower bound of the signed distance of any two boxes, and that of two that overlap.
  double separation() const { return separations_[static_cast<std::size_t>(best_)]; }
  Eigen::Vector3d normal() const { return normalOf(best_); }

  /// The answer for boxes that overlap, bounds left out. Nothing where an edge or a face, and no single vertex or pair
  /// of edges, lies deepest within `tolerance` [m], or where the points miss the boxes by more than `rounding` [m],
  /// what the bounds are widened by.
  std::optional<SignedDistance> overlap(double tolerance, double rounding) const;

 private:
  // Axes 0-2 are the normals of a, 3-5 those of b, 6 + 3 i + j the product of edge i of a and edge j of b.
  static constexpr int kAxes = 15;

  Eigen::Vector3d axisOf(int axis) const;
  Eigen::Vector3d normalOf(int axis) const;
  void measure(int axis, double separation);
  bool isUnique(double tolerance) const;
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
