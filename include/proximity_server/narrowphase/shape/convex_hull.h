#pragma once

#include <Eigen/Geometry>
#include <array>
#include <vector>

#include "proximity_server/narrowphase/shape/eigen_alignment.h"

namespace proximity_server::narrowphase {

/// Convex hull of a point cloud, with the adjacency of its vertices.
///
/// Degenerate clouds are legal: one point, a segment, a flat polygon; see dimension(). The vertices are a subset of the
/// input, bit for bit.
///
/// Frame:   that of the points. Metres.
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

  /// Index of the vertex farthest along `direction`. All vertices of a small hull are compared. On a large hull the
  /// search climbs from neighbour to neighbour. It begins at `start` (every value is legal; the last answer is the best
  /// one) or at the vertex that was found at load time for a similar direction, whichever lies farther.
  int farthestVertex(const Eigen::Vector3d& direction, int start) const;

  /// Enclosed volume [m^3]. It is 0 for a degenerate hull.
  double volume() const;

 private:
  void connectNeighbours();
  void storeForScan();
  void findStarts();
  int startTowards(const Eigen::Vector3d& direction) const;
  int climb(const Eigen::Vector3d& direction, int start) const;

  int dimension_ = 0;
  std::vector<Eigen::Vector3d> vertices_;
  std::vector<std::array<int, 3>> triangles_;
  std::vector<int> offsets_;              // where the neighbours of each vertex begin in neighbours_
  std::vector<int> neighbours_;           // grouped by vertex
  std::vector<double> scan_coordinates_;  // all x, all y, all z, each filled up to the stride with vertex 0
  int scan_count_ = 0;
  int cells_ = 0;            // number along an edge of the cube of directions; 0: the hull is small and is scanned
  std::vector<int> starts_;  // for each cell of the six sides of the cube, the vertex farthest along its centre
};

}  // namespace proximity_server::narrowphase
