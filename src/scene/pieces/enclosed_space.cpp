#include "scene/pieces/enclosed_space.h"

#include <algorithm>

namespace proximity_server::scene {
namespace {

using Eigen::AngleAxisd;
using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

double cross(const Vector2d& a, const Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

std::vector<Triangle> turned(const std::vector<Triangle>& triangles, const Matrix3d& turn) {
  std::vector<Triangle> result;
  result.reserve(triangles.size());
  for (const auto& [a, b, c] : triangles) result.push_back({turn * a, turn * b, turn * c});
  return result;
}

/// Whether a ray from `p` upwards may meet something in the box.
bool mayMeet(const Eigen::AlignedBox3d& box, const Vector3d& p) {
  const Vector3d &low = box.min(), &high = box.max();
  return low.x() <= p.x() && p.x() <= high.x() && low.y() <= p.y() && p.y() <= high.y() && p.z() <= high.z();
}

/// 1 where the ray from `p` upwards crosses the triangle and sees its corners counter-clockwise, -1 clockwise, else 0.
int crossing(const Triangle& t, const Vector3d& p) {
  const auto flat = [&](std::size_t i) { return Vector2d((t[i] - p).head<2>()); };
  const Vector2d a = flat(0), b = flat(1), c = flat(2);
  const double u = cross(b, c), v = cross(c, a), w = cross(a, b);
  const bool counter_clockwise = u > 0 && v > 0 && w > 0;
  if (!counter_clockwise && !(u < 0 && v < 0 && w < 0)) return 0;
  const double z = (u * t[0].z() + v * t[1].z() + w * t[2].z()) / (u + v + w);
  if (!(z > p.z())) return 0;
  return counter_clockwise ? 1 : -1;
}

}  // namespace

EnclosedSpace::EnclosedSpace(const std::vector<Triangle>& closed)
    : views_{View(AngleAxisd(0.7391, Vector3d(0.317, 0.911, -0.263).normalized()).toRotationMatrix(), closed),
             View(AngleAxisd(2.1731, Vector3d(-0.571, 0.337, 0.749).normalized()).toRotationMatrix(), closed)} {}

bool EnclosedSpace::holds(const Vector3d& p, Effort& effort) const {
  return std::all_of(views_.begin(), views_.end(), [&](const View& view) { return view.winding(p, effort) != 0; });
}

EnclosedSpace::View::View(const Matrix3d& turn, const std::vector<Triangle>& closed)
    : turn_(turn), tree_(turned(closed, turn), TriangleBoxes::SplitAxes::XY) {}

int EnclosedSpace::View::winding(const Vector3d& point, Effort& effort) const {
  constexpr std::size_t kStepsPerNode = 2, kStepsPerTriangle = 5;
  std::size_t steps = 0;
  const Vector3d p = turn_ * point;
  int crossings = 0;
  // Halving leaves at most 31 levels below an int's worth of triangles; each holds one sibling back.
  std::array<int, 64> pending{0};
  for (int count = 1; count > 0;) {
    const TriangleBoxes::Node& node = tree_.nodes[pending[--count]];
    steps += kStepsPerNode;
    if (!mayMeet(node.box, p)) continue;
    if (node.left >= 0) {
      pending[count++] = node.left + 1;
      pending[count++] = node.left;
      continue;
    }
    steps += kStepsPerTriangle * static_cast<std::size_t>(node.end - node.begin);
    for (int i = node.begin; i < node.end; ++i) crossings += crossing(tree_.triangles[i], p);
  }
  effort.spend(steps);
  return crossings;
}

}  // namespace proximity_server::scene
