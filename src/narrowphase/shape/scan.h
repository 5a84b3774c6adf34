#pragma once

#include <Eigen/Core>
#include <vector>

namespace proximity_server::narrowphase {

/// Index of the point with the greatest dot product with `direction`; of equal ones the first.
///
/// The `count` points are given as arrays of coordinates; `count` is a multiple of kScanStride. The widest vector unit
/// of the processor is chosen at run time. All widths give the same bits, as no product is fused with a sum.
int scan(const double* x, const double* y, const double* z, int count, const Eigen::Vector3d& direction);

constexpr int kScanStride = 16;

/// The scan with vectors of one width.
struct ScanOfWidth {
  int lanes;  ///< doubles in a vector
  int (*scan)(const double* x, const double* y, const double* z, int count, const double* direction);
};

/// The scans that the processor supports, narrowest first; scan() uses the last. Allocates.
std::vector<ScanOfWidth> availableScans();

}  // namespace proximity_server::narrowphase
