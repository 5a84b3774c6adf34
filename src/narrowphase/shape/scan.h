#pragma once

#include <Eigen/Core>

namespace proximity_server::narrowphase {

/// Index of the first of the greatest dot products of `direction` with `count` points given coordinate by coordinate.
///
/// `count` is a multiple of kScanStride. The widest vector unit of the processor is chosen at run time; all give the
/// same bits, as no product is fused with a sum.
int scan(const double* x, const double* y, const double* z, int count, const Eigen::Vector3d& direction);

constexpr int kScanStride = 16;

}  // namespace proximity_server::narrowphase
