#include "scene/model/usable_pose.h"

#include <cmath>
#include <limits>

namespace proximity_server::scene {
namespace {

using Eigen::Isometry3d;
using Eigen::Matrix3d;

/// What a rotation matrix made of single precision numbers may be off: few float eps in each product of columns.
constexpr double kRotationTolerance = 16.0 * std::numeric_limits<float>::epsilon();

/// The largest entry of R^T R - 1.
double errorOf(const Matrix3d& rotation) {
  return (rotation.transpose() * rotation - Matrix3d::Identity()).cwiseAbs().maxCoeff();
}

/// Written so that NaN is refused too.
bool isPose(const Isometry3d& pose, double error) {
  return error <= kRotationTolerance && pose.linear().determinant() > 0.0 &&
         std::isfinite(pose.translation().squaredNorm());
}

/// The rotation nearest to a matrix that is one within `error`, which is at most kRotationTolerance.
///
/// Source: Higham, Computing the Polar Decomposition, SIAM J. Sci. Stat. Comput. 1986: the Newton-Schulz step squares
///         the error.
Matrix3d nearestRotation(Matrix3d matrix, double error) {
  for (; error > 4.0 * std::numeric_limits<double>::epsilon(); error *= error)
    matrix = 0.5 * matrix * (3.0 * Matrix3d::Identity() - matrix.transpose() * matrix);
  return matrix;
}

}  // namespace

std::optional<Isometry3d> usablePose(const std::optional<Isometry3d>& pose) {
  if (!pose) return std::nullopt;
  const double error = errorOf(pose->linear());
  if (!isPose(*pose, error)) return std::nullopt;
  Isometry3d usable = *pose;
  usable.linear() = nearestRotation(pose->linear(), error);
  return usable;
}

}  // namespace proximity_server::scene
