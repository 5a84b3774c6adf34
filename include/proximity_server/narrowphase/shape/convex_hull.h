#pragma once

#include "proximity_server/narrowphase/shape/eigen_alignment.h"

#include <Eigen/Geometry>

#include <array>
#include <vector>

namespace proximity_server::narrowphase {

/// Convex hull of a point cloud, with the adjacency of its vertices.
///
/// Degenerate clouds are legal: one point, a segment, a flat polygon; see dimension(). The vertices are a subset of the
/// input, bit for bit.
/// Frame:   the frame of the points. Metres.
/// Error:   a point that lies outside of the hull of the others by no more than qhull's rounding may be left out. Among
///          near-duplicates, up to 2e-14 of the size of the cloud has been observed.
/// Failure: throws std::invalid_argument for an empty cloud or a coordinate that is not finite.
/// Source:  Barber, Dobkin, Huhdanpaa, The Quickhull Algorithm for Convex Hulls, ACM TOMS 1996 (qhull).
class ConvexHull {
 public:
  explicit ConvexHull(const std::vector<Eigen::Vector3d>& points);

  int size() const { return static_cast<int>(vertices_.size()); }
  const std::vector<Eigen::Vector3d>& vertices() const { return vertices_; }

  /// Affine dimension of the cloud, within rounding: 0 point, 1 segment, 2 polygon, 3 solid.
  int dimension() const { return dimension_; }

  /// Triangles of a solid hull, counter-clockwise from outside. A polygon has the triangles of one side; a segment or a
  /// point has none.
  const std::vector<std::array<int, 3>>& triangles() const { return triangles_; }

  /// Range of the numbers of the vertices that share an edge with a vertex.
  struct Range {
    const int* first;
    const int* last;
    const int* begin() const { return first; }
    const int* end() const { return last; }
  };
  Range neighbours(int vertex) const {
    const std::size_t v = static_cast<std::size_t>(vertex);
    return {neighbours_.data() + offsets_[v], neighbours_.data() + offsets_[v + 1]};
  }

  /// The hull with each vertex moved by `offset` [m], and rounded. Numbers and adjacency are the same.
  ConvexHull movedBy(const Eigen::Vector3d& offset) const;

  /// Enclosed volume [m^3]. It is 0 for a degenerate hull.
  double volume() const;

 private:
  void connectNeighbours();

  int dimension_ = 0;
  std::vector<Eigen::Vector3d> vertices_;
  std::vector<std::array<int, 3>> triangles_;
  std::vector<int> offsets_;     // the begin of the neighbours of each vertex in neighbours_
  std::vector<int> neighbours_;  // grouped by vertex
};

}  // namespace proximity_server::narrowphase
