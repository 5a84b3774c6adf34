#include "proximity_server/scene/sensed/sight_rays.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace proximity_server::scene {
namespace {

using Eigen::AlignedBox3d;
using Eigen::Vector3d;

/// A face of the cube is across an axis, at its negative or positive end. u and v are the other axes.
struct Face {
  int axis;
  bool is_negative;

  int number() const { return 2 * axis + (is_negative ? 1 : 0); }
  int u() const { return (axis + 1) % 3; }
  int v() const { return (axis + 2) % 3; }
};

Face faceOf(const Vector3d& direction) {
  Face face{};
  direction.cwiseAbs().maxCoeff(&face.axis);
  face.is_negative = std::signbit(direction[face.axis]);
  return face;
}

/// Whether the way from the origin to `end` enters the box from `low` to `high` and leaves it again.
bool passes(const Vector3d& end, const Vector3d& low, const Vector3d& high) {
  double enter = 0.0, leave = 1.0;
  for (int axis = 0; axis < 3; ++axis) {
    const double one = low[axis] / end[axis], other = high[axis] / end[axis];
    enter = std::max(enter, std::min(one, other));
    leave = std::min(leave, std::max(one, other));
  }
  return enter < leave && leave < 1.0;
}

}  // namespace

void SightRays::set(const Vector3d& origin, const std::vector<Vector3d>& ends) {
  const auto along = [](double tangent) {
    return std::min(static_cast<int>(0.5 * kCells * (tangent + 1.0)), kCells - 1);
  };
  origin_ = origin;
  ends_.resize(ends.size());
  if (ends.empty()) return;
  cells_.assign(6 * kCells * kCells + 1, {});
  cell_of_.clear();
  for (const Vector3d& end : ends) {
    const Vector3d to = end - origin;
    const Face face = faceOf(to);
    const double depth = std::abs(to[face.axis]);
    const int u = depth > 0.0 ? along(to[face.u()] / depth) : 0, v = depth > 0.0 ? along(to[face.v()] / depth) : 0;
    cell_of_.push_back(static_cast<std::uint32_t>((face.number() * kCells + v) * kCells + u));
    Cell& cell = cells_[cell_of_.back()];
    ++cell.begin;
    cell.depth =
        std::max(cell.depth, std::nextafter(static_cast<float>(depth), std::numeric_limits<float>::infinity()));
  }
  std::uint32_t sum = 0;
  for (Cell& cell : cells_) cell.begin = sum += cell.begin;
  for (std::size_t i = 0; i < ends.size(); ++i) ends_[--cells_[cell_of_[i]].begin] = ends[i] - origin;
}

bool SightRays::passThrough(const AlignedBox3d& box) const {
  if (ends_.empty()) return false;
  const Vector3d low = box.min() - origin_, high = box.max() - origin_;
  for (int number = 0; number < 6; ++number) {
    const Face face{number / 2, number % 2 == 1};
    const double near = face.is_negative ? -high[face.axis] : low[face.axis];
    const double far = face.is_negative ? -low[face.axis] : high[face.axis];
    if (!(far > 0.0)) continue;
    // The cells of this face in whose directions the box is.
    const auto cells = [&](int axis, int& first, int& last) {
      const double from = low[axis] / (low[axis] >= 0.0 ? far : std::max(0.0, near));
      const double to = high[axis] / (high[axis] < 0.0 ? far : std::max(0.0, near));
      const auto cell = [&](double tangent) {
        return static_cast<int>(0.5 * kCells * (std::min(std::max(tangent, -1.0), 1.0) + 1.0));
      };
      if (from > 1.0 || to < -1.0) return false;
      first = std::max(cell(from) - 1, 0);  // rounding may move a ray to the next cell
      last = std::min(cell(std::isnan(to) ? 1.0 : to) + 1, kCells - 1);
      return true;
    };
    int first_u = 0, last_u = 0, first_v = 0, last_v = 0;
    if (!cells(face.u(), first_u, last_u) || !cells(face.v(), first_v, last_v)) continue;
    for (int v = first_v; v <= last_v; ++v) {
      const Cell* const row = &cells_[static_cast<std::size_t>((number * kCells + v) * kCells)];
      for (int u = first_u; u <= last_u; ++u) {
        if (row[u].depth <= near) continue;
        for (std::uint32_t ray = row[u].begin; ray < row[u + 1].begin; ++ray)
          if (passes(ends_[ray], low, high)) return true;
      }
    }
  }
  return false;
}

}  // namespace proximity_server::scene
