#pragma once

#include <gtest/gtest.h>
#include <Eigen/Geometry>

namespace proximity_server::narrowphase {

/// Whether two vectors are closer than `tolerance` to each other; false for NaN.
inline testing::AssertionResult isNear(const Eigen::Vector3d& actual, const Eigen::Vector3d& expected,
                                       double tolerance) {
  const double off = (actual - expected).norm();
  if (off <= tolerance) return testing::AssertionSuccess();
  return testing::AssertionFailure() << "(" << actual.transpose() << ") is off (" << expected.transpose() << ") by "
                                     << off;
}

}  // namespace proximity_server::narrowphase
