#include "scene/pieces/enclosed_space.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>

namespace proximity_server::scene {
namespace {

using Eigen::AngleAxisd;
using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

double cross(const Vector2d& a, const Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

/// True if a ray from `p` upwards may meet a triangle in the box.
bool mayMeet(const Eigen::AlignedBox3d& box, const Vector3d& p) {
  const Vector3d &low = box.min(), &high = box.max();
  return low.x() <= p.x() && p.x() <= high.x() && low.y() <= p.y() && p.y() <= high.y() && p.z() <= high.z();
}

/// How the ray from `p` upwards crosses one triangle.
struct Crossing {
  /// 1 if the corners are counter-clockwise as seen from above, -1 if clockwise, 0 if the ray misses the triangle
  int sign = 0;
  bool is_certain = true;  ///< true if rounding cannot have changed the sign
};

/// The relative error of the differences of coordinates is eps/2, the error of a product of two differences 3/2 eps,
/// and the error of the difference of two products 2 eps of the sum of their sizes, to first order in eps. The weighted
/// heights add as much. Rounded up to 8.
Crossing crossingOf(const Triangle& t, const Vector3d& p) {
  constexpr double kRounding = 8.0 * std::numeric_limits<double>::epsilon();
  const std::array<Vector3d, 3> corners{t[0] - p, t[1] - p, t[2] - p};
  // The sign of a difference is exact, so this decides most triangles for certain.
  const Vector3d low = corners[0].cwiseMin(corners[1]).cwiseMin(corners[2]);
  const Vector3d high = corners[0].cwiseMax(corners[1]).cwiseMax(corners[2]);
  if (low.x() > 0 || high.x() < 0 || low.y() > 0 || high.y() < 0 || high.z() < 0) return {};
  std::array<double, 3> weights{};  // twice the signed areas beside the ray, as seen from above
  std::array<double, 3> errors{};
  int positive = 0, negative = 0;  // the number of weights with this sign, beyond rounding
  for (std::size_t i = 0; i < 3; ++i) {
    const Vector3d &b = corners[(i + 1) % 3], &c = corners[(i + 2) % 3];
    weights[i] = cross(b.head<2>(), c.head<2>());
    errors[i] = kRounding * (std::abs(b.x() * c.y()) + std::abs(b.y() * c.x()));
    positive += weights[i] > errors[i];
    negative += weights[i] < -errors[i];
  }
  const bool is_beside = positive > 0 && negative > 0;
  if (is_beside) return {};
  double height = 0.0, error = 0.0;  // the height of the triangle above p, times its area
  for (std::size_t i = 0; i < 3; ++i) {
    height += weights[i] * corners[i].z();
    error += (errors[i] + kRounding * std::abs(weights[i])) * std::abs(corners[i].z());
  }
  const auto all = [&](auto has_sign) { return std::all_of(weights.begin(), weights.end(), has_sign); };
  const bool is_certain = positive + negative == 3 && std::abs(height) > error;
  if (height > 0 && all([](double weight) { return weight > 0; })) return {1, is_certain};
  if (height < 0 && all([](double weight) { return weight < 0; })) return {-1, is_certain};
  return {0, is_certain};
}

}  // namespace

EnclosedSpace::EnclosedSpace(const TriangleBoxes& closed)
    : views_{View(AngleAxisd(0.7391, Vector3d(0.317, 0.911, -0.263).normalized()).toRotationMatrix(), closed),
             View(AngleAxisd(2.1731, Vector3d(-0.571, 0.337, 0.749).normalized()).toRotationMatrix(), closed)} {}

bool EnclosedSpace::holds(const Vector3d& p, Effort& effort) const { return windingNumber(p, effort) != 0; }

int EnclosedSpace::windingNumber(const Vector3d& p, Effort& effort) const {
  const Winding first = views_[0].winding(p, effort);
  if (first.is_certain) return first.number;
  const Winding second = views_[1].winding(p, effort);
  return second.is_certain || std::abs(second.number) < std::abs(first.number) ? second.number : first.number;
}

bool EnclosedSpace::mayHold(const Vector3d& p) const {
  Effort unlimited(std::numeric_limits<double>::infinity());
  for (const View& view : views_)
    if (const Winding winding = view.winding(p, unlimited); winding.is_certain) return winding.number != 0;
  return true;
}

EnclosedSpace::Winding EnclosedSpace::View::winding(const Vector3d& point, Effort& effort) const {
  constexpr std::size_t kStepsPerNode = 2, kStepsPerTriangle = 5;
  std::size_t steps = 0;
  const Vector3d p = turn_ * point;
  Winding winding;
  const auto mayMeetRay = [&](const Eigen::AlignedBox3d& box) {
    steps += kStepsPerNode;
    return mayMeet(box, p);
  };
  tree_.anyLeaf(mayMeetRay, [&](const TriangleBoxes::Node& leaf) {
    steps += kStepsPerTriangle * static_cast<std::size_t>(leaf.end - leaf.begin);
    for (int i = leaf.begin; i < leaf.end; ++i) {
      const Crossing crossing = crossingOf(tree_.triangles[i], p);
      winding.number += crossing.sign;
      winding.is_certain &= crossing.is_certain;
    }
    return false;
  });
  effort.spend(steps);
  return winding;
}

}  // namespace proximity_server::scene
