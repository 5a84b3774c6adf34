#pragma once

#include "proximity_server/narrowphase/shape/convex_hull.h"

#include <Eigen/Core>

#include <array>
#include <cstdint>
#include <vector>

namespace proximity_server::narrowphase {

/// A convex hull with its support mapping: the vertex farthest along a direction.
///
/// A small hull is scanned. For a larger one a table names the few vertices that can be the farthest. Every direction
/// meets the surface of the cube [-1, 1]^3; each side of the cube is divided into equal square cells, and each cell
/// lists the vertices that are the farthest along some direction through it. The lists are made so:
///
/// 1. Begin with a whole side of the cube and all vertices.
/// 2. Find the vertices farthest along the directions through the four corners and the centre of the square.
/// 3. Leave out each vertex that lies less far than one of these five at all four corners: the difference of two
///    heights is linear over the square, so it lies less far everywhere in it.
/// 4. Divide the square into four, and repeat from step 2 with the vertices that are left, until the squares are cells.
///
/// A cell has room for four vertices. A longer list stands elsewhere, and all of it is compared: a climb from neighbour
/// to neighbour may end lower where many vertices are nearly in one plane. If such lists take too much memory, as in
/// a hull that is hardly larger than the rounding of its coordinates, the cells are made larger.
/// Frame:  the frame of the hull.
/// Error:  the height of the vertex found is within rounding of the greatest: the lists hold every vertex that may be
///         the farthest within rounding.
/// Source: the division of the directions is a cube map (Greene, Environment Mapping and Other Applications of World
///         Projections, IEEE CG&A 1986); the lists are ours.
class HullSupport {
 public:
  /// Allocates. The time grows with the number of vertices.
  explicit HullSupport(ConvexHull hull);

  const ConvexHull& hull() const { return hull_; }

  /// A vertex and its height along a direction: the dot product with it.
  struct Farthest {
    int vertex;
    double height;
  };

  /// The vertex farthest along `direction`; some vertex if its largest entry is not finite or below 1e-300.
  Farthest farthest(const Eigen::Vector3d& direction) const;
  int farthestVertex(const Eigen::Vector3d& direction) const { return farthest(direction).vertex; }

 private:
  using Candidates = std::array<std::uint16_t, 4>;  // may contain a number more than once
  /// Takes the place of the first candidate of a cell with a longer list. The next two candidates are then the upper
  /// and the lower half of the index in crowded_ at which the list begins.
  static constexpr std::uint16_t kCrowded = 0xffff;

  Farthest scan(const Eigen::Vector3d& direction) const;
  /// Fills the table. Returns false, and leaves it unfinished, if the lists of the crowded cells are too long.
  bool fillTable();
  Candidates storeCandidates(const std::vector<int>& vertices);
  Farthest searchCrowded(const Eigen::Vector3d& direction, const Candidates& cell) const;

  ConvexHull hull_;
  int cells_ = 0;  // along an edge of the cube; 0: the hull is scanned
  std::vector<Candidates> table_;
  std::vector<int> crowded_;  // the lists that do not fit into their cell, each after its length
};

}  // namespace proximity_server::narrowphase
