#pragma once

#include <Eigen/Geometry>
#include <array>
#include <vector>

#include "proximity_server/narrowphase/shape/eigen_alignment.h"

namespace proximity_server::narrowphase {

/// Convex hull of a point cloud, with the adjacency of its vertices.
///
/// Degenerate clouds are legal: one point, a segment, a flat polygon (dimension() tells). Vertices are a subset of
/// the input, bit for bit.
/// Frame:   that of the points. Metres.
/// Error:   a point that lies beyond the hull of the others by no more than qhull's rounding may be left out: as seen
///          among near-duplicates, up to 2e-14 of the size of the cloud.
/// Failure: throws std::invalid_argument for an empty cloud or a coordinate that is not finite.
/// Source:  Barber, Dobkin, Huhdanpaa, The Quickhull Algorithm for Convex Hulls, ACM TOMS 1996 (qhull).
class ConvexHull {
 public:
  explicit ConvexHull(const std::vector<Eigen::Vector3d>& points);

  int size() const { return static_cast<int>(vertices_.size()); }
  const std::vector<Eigen::Vector3d>& vertices() const { return vertices_; }

  /// Affine dimension of the cloud within rounding: 0 point, 1 segment, 2 polygon, 3 solid.
  int dimension() const { return dimension_; }

  /// Outward triangles of a solid hull, counter-clockwise from outside; of a polygon one side; else empty.
  const std::vector<std::array<int, 3>>& triangles() const { return triangles_; }

  /// Vertices that share an edge with `vertex`: neighbours()[i] for i in [begin, end).
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

  /// Index of the vertex farthest along `direction`. A small hull is scanned whole; on a large one the search climbs
  /// from neighbour to neighbour, beginning at `start` (any value is legal, the last answer is the best) or at the
  /// vertex that was found at load time for directions like this one, whichever lies farther.
  int farthestVertex(const Eigen::Vector3d& direction, int start) const;

  /// Enclosed volume [m^3]; 0 for a degenerate hull.
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
  std::vector<int> offsets_;              // of each vertex into neighbours_
  std::vector<int> neighbours_;           // grouped by vertex
  std::vector<double> scan_coordinates_;  // all x, all y, all z, each filled up to the scan's stride with the first
  int scan_count_ = 0;
  int cells_ = 0;            // along an edge of the cube of directions; 0: small enough for the scan
  std::vector<int> starts_;  // for each cell of its six sides a vertex that lies far along it
};

}  // namespace proximity_server::narrowphase
