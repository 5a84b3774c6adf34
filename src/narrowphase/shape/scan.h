#pragma once

#include <Eigen/Core>
#include <vector>

namespace proximity_server::narrowphase {

/// Index of the first of the greatest dot products of `direction` with `count` points given coordinate by coordinate.
///
/// `count` is a multiple of kScanStride. The widest vector unit of the processor is chosen at run time; all give the
/// same bits, as no product is fused with a sum.
int scan(const double* x, const double* y, const double* z, int count, const Eigen::Vector3d& direction);

constexpr int kScanStride = 16;

/// The scan on vectors of one width.
struct ScanOfWidth {
  int lanes;  ///< doubles in a vector
  int (*scan)(const double* x, const double* y, const double* z, int count, const double* direction);
};

/// The widths that the processor has, narrowest first; scan() takes the last. Allocates.
std::vector<ScanOfWidth> availableScans();

}  // namespace proximity_server::narrowphase
