#include "scene/bounds/bounds.h"

#include "proximity_server/narrowphase/shape/support.h"
#include "scene/model/pieces.h"

#include <Eigen/Eigenvalues>

#include <algorithm>

namespace proximity_server::scene {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Pieces = std::vector<const Piece*>;

/// The largest coordinate of a piece along a unit direction, in the body's frame.
double extentAlong(const Vector3d& direction, const Piece& piece) {
  int vertex = 0;
  const Vector3d in_piece = piece.body_T_piece.linear().transpose() * direction;
  return direction.dot(piece.body_T_piece * supportPoint(piece.shape, in_piece, vertex)) + piece.shape.margin();
}

double extentAlong(const Vector3d& direction, const Pieces& pieces) {
  double extent = -std::numeric_limits<double>::infinity();
  for (const Piece* piece : pieces) extent = std::max(extent, extentAlong(direction, *piece));
  return extent;
}

/// The smallest box with these axes, without a sphere.
Bounds boxAlong(const Matrix3d& axes, const Pieces& pieces) {
  Bounds box;
  box.axes = axes;
  for (int k = 0; k < 3; ++k) {
    const double high = extentAlong(axes.col(k), pieces), low = -extentAlong(-axes.col(k), pieces);
    box.half[k] = 0.5 * (high - low);
    box.centre += 0.5 * (high + low) * axes.col(k);
  }
  return box;
}

double reachFrom(const Vector3d& centre, const Pieces& pieces) {
  double reach = 0.0;
  for (const Piece* piece : pieces) reach = std::max(reach, reachFrom(centre, *piece));
  return reach;
}

/// The box with the smallest sum of edges, and the sphere about its centre.
Bounds smallest(const std::vector<Matrix3d>& choices, const Pieces& pieces) {
  Bounds bounds = boxAlong(choices.front(), pieces);
  for (std::size_t i = 1; i < choices.size(); ++i) {
    const Bounds other = boxAlong(choices[i], pieces);
    if (other.half.sum() < bounds.half.sum()) bounds = other;
  }
  bounds.radius = reachFrom(bounds.centre, pieces);
  bounds.reach = reachFrom(Vector3d::Zero(), pieces);
  const double rounding = kPoseRounding * bounds.reach;
  bounds.radius += rounding;
  bounds.half.array() += rounding;
  return bounds;
}

Matrix3d principalAxes(const std::vector<Vector3d>& points) {
  Vector3d mean = Vector3d::Zero();
  for (const Vector3d& point : points) mean += point / static_cast<double>(points.size());
  Matrix3d covariance = Matrix3d::Zero();
  for (const Vector3d& point : points) covariance += (point - mean) * (point - mean).transpose();
  return Eigen::SelfAdjointEigenSolver<Matrix3d>(covariance).eigenvectors();
}

/// The distance of the origin from a box along the coordinate axes with the centre `offset` and the half edges `half`.
/// If the origin is inside, minus its distance from the nearest side.
inline double distanceFromBox(const Vector3d& offset, const Vector3d& half) {
  const Vector3d gaps = offset.cwiseAbs() - half;
  const double largest = gaps.maxCoeff();
  return largest > 0.0 ? gaps.cwiseMax(0.0).norm() : largest;
}

}  // namespace

Bounds boundsOf(const Piece& piece) {
  const Matrix3d frame = piece.body_T_piece.linear();
  std::vector<Matrix3d> choices{frame};
  if (piece.shape.kind() == narrowphase::Shape::Kind::Hull)
    choices.push_back(frame * principalAxes(piece.shape.hull().vertices()));
  return smallest(choices, {&piece});
}

Bounds boundsOf(const Pieces& pieces, const std::vector<const Bounds*>& each) {
  constexpr std::size_t kFewPieces = 8;  // more pieces are not tried one by one, because that takes quadratic time
  if (pieces.size() == 1) return *each.front();
  std::vector<Matrix3d> choices{Matrix3d::Identity()};
  if (pieces.size() <= kFewPieces) {
    for (const Bounds* bounds : each)
      if (std::find(choices.begin(), choices.end(), bounds->axes) == choices.end()) choices.push_back(bounds->axes);
  } else {
    std::vector<Vector3d> centres;
    for (const Bounds* bounds : each) centres.push_back(bounds->centre);
    choices.push_back(principalAxes(centres));
  }
  return smallest(choices, pieces);
}

Bounds boundsOf(const Eigen::AlignedBox3d& box) {
  Bounds bounds;
  bounds.centre = box.center();
  bounds.half = 0.5 * box.sizes();
  bounds.reach = bounds.centre.norm() + bounds.half.norm();
  bounds.half.array() += kPoseRounding * bounds.reach;
  bounds.radius = (1.0 + kPoseRounding) * bounds.half.norm();
  return bounds;
}

double boxGap(const Bounds& a, const Bounds& b, const RelativePose& a_T_b) {
  return boxGap(centreOffset(a, b, a_T_b), a, a.axes, b, a_T_b.rotation * b.axes);
}

double boxGap(const Vector3d& between, const Bounds& a, const Matrix3d& axes_a, const Bounds& b,
              const Matrix3d& axes_b) {
  const Matrix3d cosines = (axes_a.transpose() * axes_b).cwiseAbs();
  const Vector3d in_a = axes_a.transpose() * between, in_b = axes_b.transpose() * between;
  const double from_a = distanceFromBox(in_a, a.half + cosines * b.half);
  const double from_b = distanceFromBox(in_b, b.half + cosines.transpose() * a.half);
  const double distance = between.norm();
  const double widths = a.half.dot(in_a.cwiseAbs()) + b.half.dot(in_b.cwiseAbs());
  const double along_line = distance > 0.0 ? distance - widths / distance : from_a;
  return std::max({from_a, from_b, along_line}) - kPoseRounding * distance;
}

}  // namespace proximity_server::scene
