#include "proximity_server/narrowphase/shape/rigid_pose.h"

#include <cmath>
#include <limits>

namespace proximity_server::narrowphase {
namespace {

using Eigen::Isometry3d;
using Eigen::Matrix3d;

/// The error that a rotation matrix of single precision numbers may have: a few float eps in each product of columns.
constexpr double kRotationTolerance = 16.0 * std::numeric_limits<float>::epsilon();

Matrix3d squareOf(const Matrix3d& matrix) { return matrix.transpose() * matrix; }

/// Written so that NaN is refused too.
bool isPose(const Isometry3d& pose, double error) {
  return error <= kRotationTolerance && pose.linear().determinant() > 0.0 && pose.translation().allFinite();
}

/// The rotation nearest to a matrix that is a rotation within `error`, which is at most kRotationTolerance: the
/// Newton-Schulz step squares the error. `square` is squareOf(matrix).
Matrix3d nearestRotation(Matrix3d matrix, Matrix3d square, double error) {
  constexpr double kRounding = 4.0 * std::numeric_limits<double>::epsilon();
  while (error > kRounding) {
    matrix = 0.5 * matrix * (3.0 * Matrix3d::Identity() - square);
    error *= error;
    if (error > kRounding) square = squareOf(matrix);
  }
  return matrix;
}

}  // namespace

std::optional<Isometry3d> rigidPose(const Isometry3d& pose) {
  const Matrix3d square = squareOf(pose.linear());
  const double error = (square - Matrix3d::Identity()).cwiseAbs().maxCoeff();
  if (!isPose(pose, error)) return std::nullopt;
  Isometry3d rigid = pose;
  rigid.linear() = nearestRotation(pose.linear(), square, error);
  return rigid;
}

}  // namespace proximity_server::narrowphase
