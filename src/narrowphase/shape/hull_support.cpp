#include "proximity_server/narrowphase/shape/hull_support.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

namespace proximity_server::narrowphase {
namespace {

using Eigen::Vector3d;

/// Up to this many vertices a hull is scanned. Evidence: distance queries of hulls apart, 1000 pairs, smallest of 60
/// rounds, AMD EPYC (Zen 5), 2026-11: with 8 vertices the scan took 0.88 of the time of the table, with 16 0.99, with
/// 32 1.33.
constexpr int kMaxScanned = 16;

constexpr int kMinCells = 4;

/// Numbers in the lists of the crowded cells, for each vertex: in a table with more of them, each cell becomes four
/// times as large. A hull hardly larger than the rounding of its place has nearly all vertices in each cell, and would
/// take 100 MB. The smallest table, each cell of which has all vertices and their number, does not have more.
constexpr std::size_t kMostCrowded = 2 * 6 * kMinCells * kMinCells;

/// Number of cells along an edge of the cube. Four cells for each vertex leave about two vertices in a cell, and one
/// cell of 30 crowded (ellipsoids of 16 to 1000 vertices). Evidence: eight were 10 % faster for two hulls of 200
/// vertices alone, but not for forty hulls that share a cache of 1 MB (rows "hull 200" and "hull 1000" of ./dev bench
/// narrowphase). 128 x 128 cells a side take 0.8 MB.
int cellsFor(int vertices) {
  constexpr int kMaxCells = 128, kCellsPerVertex = 4;
  int cells = kMinCells;
  while (cells < kMaxCells && 6 * cells * cells < kCellsPerVertex * vertices) cells *= 2;
  return cells;
}

/// A square of cells on a side of the cube.
struct Square {
  int side, row, column, size;

  /// The direction through a place on the square: 0 and 1 are its edges.
  Vector3d direction(double down, double across, int cells) const {
    const int axis = side / 2;
    Vector3d d;
    d[axis] = side % 2 == 0 ? 1.0 : -1.0;
    d[(axis + 1) % 3] = 2.0 * (row + down * size) / cells - 1.0;
    d[(axis + 2) % 3] = 2.0 * (column + across * size) / cells - 1.0;
    return d;
  }
};

/// Finds, for each cell, the vertices that are the farthest along some direction through it.
class FarthestVertices {
 public:
  FarthestVertices(const std::vector<Vector3d>& vertices, int cells) : vertices_(vertices), cells_(cells) {
    double largest = 0.0;
    for (const Vector3d& v : vertices) largest = std::max(largest, v.cwiseAbs().maxCoeff());
    // The height of a vertex along a direction whose largest entry is 1 has an error of at most 3 * 3 eps / 2 times
    // `largest`; the place of a direction on its side one of 2 eps, which changes a height by at most 4 eps * largest.
    // This is for a difference of two heights, with a reserve.
    slack_ = 64.0 * std::numeric_limits<double>::epsilon() * largest;
  }

  template <typename Visit>
  void forEachCell(Visit visit) {
    std::vector<int> all(vertices_.size());
    std::iota(all.begin(), all.end(), 0);
    for (int side = 0; side < 6; ++side) divide({side, 0, 0, cells_}, all, visit);
  }

 private:
  using Heights = std::array<double, 5>;  // along the directions through the corners and the centre of a square

  template <typename Visit>
  void divide(const Square& square, const std::vector<int>& among, Visit visit) {
    std::vector<int> fewer;
    if (among.size() > 1) fewer = farthestIn(square, among);
    const std::vector<int>& vertices = among.size() > 1 ? fewer : among;
    if (square.size == 1) return visit(square, vertices);
    const int half = square.size / 2;
    for (const int row : {square.row, square.row + half})
      for (const int column : {square.column, square.column + half})
        divide({square.side, row, column, half}, vertices, visit);
  }

  /// `among`: the vertices that are the farthest along some direction through a larger square.
  std::vector<int> farthestIn(const Square& square, const std::vector<int>& among) {
    const std::array<Vector3d, 5> directions{square.direction(0, 0, cells_), square.direction(0, 1, cells_),
                                             square.direction(1, 0, cells_), square.direction(1, 1, cells_),
                                             square.direction(0.5, 0.5, cells_)};
    heights_.clear();
    std::array<std::size_t, 5> farthest{};
    for (std::size_t i = 0; i < among.size(); ++i) {
      Heights& heights = heights_.emplace_back();
      for (std::size_t d = 0; d < 5; ++d) {
        heights[d] = vertices_[among[i]].dot(directions[d]);
        if (heights[d] > heights_[farthest[d]][d]) farthest[d] = i;
      }
    }
    std::vector<int> left;
    for (std::size_t i = 0; i < among.size(); ++i)
      if (std::all_of(farthest.begin(), farthest.end(),
                      [&](std::size_t other) { return isAsFarAtACorner(heights_[i], heights_[other]); }))
        left.push_back(among[i]);
    return left;
  }

  bool isAsFarAtACorner(const Heights& heights, const Heights& others) const {
    return heights[0] >= others[0] - slack_ || heights[1] >= others[1] - slack_ || heights[2] >= others[2] - slack_ ||
           heights[3] >= others[3] - slack_;
  }

  const std::vector<Vector3d>& vertices_;
  const int cells_;
  double slack_;
  std::vector<Heights> heights_;  // of the vertices that are compared
};

/// The state before a vertex is offered.
constexpr HullSupport::Farthest kNone{0, -std::numeric_limits<double>::infinity()};

/// Offers one more vertex.
void offer(int vertex, double height, HullSupport::Farthest& best) {
  const bool is_higher = height > best.height;
  best.vertex = is_higher ? vertex : best.vertex;
  best.height = is_higher ? height : best.height;
}

/// The first of the four greatest heights. There is no branch, as the farthest vertex along a random direction cannot
/// be predicted.
int greatest(double h0, double h1, double h2, double h3) {
  const int first = static_cast<int>(h1 > h0), second = static_cast<int>(h3 > h2) | 2;
  const int is_second = static_cast<int>(std::max(h3, h2) > std::max(h1, h0));
  return first ^ (-is_second & (first ^ second));
}

// There are no branches on the axis, as the axis of a random direction cannot be predicted.
int cellOf(const Vector3d& direction, int cells) {
  static constexpr std::array<int, 3> kNext{1, 2, 0}, kLast{2, 0, 1};
  // Neither the division nor the products overflow with it, if the direction is shorter.
  constexpr double kShortest = 1e-300;
  const Vector3d size = direction.cwiseAbs();
  const double largest_xy = std::max(size.y(), size.x());
  const int is_z = static_cast<int>(size.z() > largest_xy);
  const int is_y = static_cast<int>(size.y() > size.x()) & (1 - is_z);
  const int axis = 2 * is_z + is_y;
  const double half = 0.5 * cells, scale = half / std::max(std::max(size.z(), kShortest), largest_xy);
  // A direction without a length gives NaN here; the minimum with its arguments in this order turns NaN into a place.
  // No place is below -4 eps * half, which becomes 0.
  const auto place = [&](int along) {
    return static_cast<int>(std::min(cells - 1.0, direction[along] * scale + half));
  };
  const int side = 2 * axis + static_cast<int>(std::signbit(direction[axis]));
  return (side * cells + place(kNext[axis])) * cells + place(kLast[axis]);
}

}  // namespace

HullSupport::HullSupport(ConvexHull hull) : hull_(std::move(hull)) {
  if (hull_.size() <= kMaxScanned) return;
  cells_ = cellsFor(hull_.size());
  while (!fillTable()) cells_ /= 2;
}

bool HullSupport::fillTable() {
  const std::size_t most = kMostCrowded * hull_.vertices().size();
  table_.assign(6 * cells_ * cells_, Candidates());
  crowded_.clear();
  const auto setCell = [this, most](const Square& cell, const std::vector<int>& vertices) {
    if (crowded_.size() > most) return;
    table_[(cell.side * cells_ + cell.row) * cells_ + cell.column] = storeCandidates(vertices);
  };
  FarthestVertices(hull_.vertices(), cells_).forEachCell(setCell);
  return crowded_.size() <= most;
}

HullSupport::Candidates HullSupport::storeCandidates(const std::vector<int>& vertices) {
  Candidates candidates;
  if (vertices.size() <= candidates.size() && hull_.size() <= kCrowded) {
    candidates.fill(static_cast<std::uint16_t>(vertices.front()));
    std::copy(vertices.begin(), vertices.end(), candidates.begin());
    return candidates;
  }
  const int place = static_cast<int>(crowded_.size());
  crowded_.push_back(static_cast<int>(vertices.size()));
  crowded_.insert(crowded_.end(), vertices.begin(), vertices.end());
  return {kCrowded, static_cast<std::uint16_t>(place >> 16), static_cast<std::uint16_t>(place), 0};
}

HullSupport::Farthest HullSupport::farthest(const Vector3d& direction) const {
  if (cells_ == 0) return scan(direction);
  const Candidates& candidates = table_[cellOf(direction, cells_)];
  if (candidates[0] == kCrowded) return searchCrowded(direction, candidates);
  const Vector3d* const vertices = hull_.vertices().data();
  const auto height = [&](std::size_t i) { return vertices[candidates[i]].dot(direction); };
  const double h0 = height(0), h1 = height(1), h2 = height(2), h3 = height(3);
  return {candidates[greatest(h0, h1, h2, h3)], std::max(std::max(h3, h2), std::max(h1, h0))};
}

HullSupport::Farthest HullSupport::searchCrowded(const Vector3d& direction, const Candidates& cell) const {
  const int first = (cell[1] << 16 | cell[2]) + 1, end = first + crowded_[first - 1];
  Farthest best = kNone;
  for (int i = first; i < end; ++i) offer(crowded_[i], hull_.vertices()[crowded_[i]].dot(direction), best);
  return best;
}

HullSupport::Farthest HullSupport::scan(const Vector3d& direction) const {
  Farthest best = kNone;
  for (int vertex = 0; vertex < hull_.size(); ++vertex) offer(vertex, hull_.vertices()[vertex].dot(direction), best);
  return best;
}

}  // namespace proximity_server::narrowphase
