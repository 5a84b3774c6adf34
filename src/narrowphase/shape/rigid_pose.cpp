#include "proximity_server/narrowphase/shape/rigid_pose.h"

#include <cmath>
#include <limits>

namespace proximity_server::narrowphase {
namespace {

using Eigen::Isometry3d;
using Eigen::Matrix3d;

/// The error that a rotation matrix of single precision numbers may have: a few float eps in each product of columns.
constexpr double kRotationTolerance = 16.0 * std::numeric_limits<float>::epsilon();

/// The largest entry of R^T R - 1.
double errorOf(const Matrix3d& rotation) {
  return (rotation.transpose() * rotation - Matrix3d::Identity()).cwiseAbs().maxCoeff();
}

/// Written so that NaN is refused too.
bool isPose(const Isometry3d& pose, double error) {
  return error <= kRotationTolerance && pose.linear().determinant() > 0.0 && pose.translation().allFinite();
}

/// The rotation nearest to a matrix that is a rotation within `error`, which is at most kRotationTolerance: the
/// Newton-Schulz step squares the error.
Matrix3d nearestRotation(Matrix3d matrix, double error) {
  for (; error > 4.0 * std::numeric_limits<double>::epsilon(); error *= error)
    matrix = 0.5 * matrix * (3.0 * Matrix3d::Identity() - matrix.transpose() * matrix);
  return matrix;
}

}  // namespace

std::optional<Isometry3d> rigidPose(const Isometry3d& pose) {
  const double error = errorOf(pose.linear());
  if (!isPose(pose, error)) return std::nullopt;
  Isometry3d rigid = pose;
  rigid.linear() = nearestRotation(pose.linear(), error);
  return rigid;
}

}  // namespace proximity_server::narrowphase
