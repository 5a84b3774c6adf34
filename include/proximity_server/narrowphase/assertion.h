#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstdio>
#include <cstdlib>

#include "proximity_server/narrowphase/shape/eigen_alignment.h"

/// PROXIMITY_ASSERT(condition, advice): a precondition of an inner function, which no input of a user can break. Without NDEBUG,
/// as in the sanitized builds and the fuzzers, the program ends where it does not hold, with the place, the condition and the
/// advice: the likely cause, and the cure. In a release build it is compiled, but takes no instruction.
#ifndef NDEBUG
#define PROXIMITY_ASSERT(condition, advice) \
  ((condition) ? static_cast<void>(0)       \
               : ::proximity_server::narrowphase::failAssertion(__FILE__, __LINE__, #condition, advice))
#else
#define PROXIMITY_ASSERT(condition, advice) (true ? static_cast<void>(0) : static_cast<void>(condition))
#endif

namespace proximity_server::narrowphase {

[[noreturn, gnu::cold]] inline void failAssertion(const char* file, int line, const char* condition,
                                                  const char* advice) {
  std::fprintf(stderr, "%s:%d: assertion failed: %s\n%s\n", file, line, condition, advice);
  std::abort();
}

/// Whether a vector has the length 1, up to the rounding of some steps. False for NaN.
inline bool isUnit(const Eigen::Vector3d& v) {
  constexpr double kRounding = 1e-9;
  return std::abs(v.squaredNorm() - 1.0) <= kRounding;
}

/// Whether a number is the place of one of `size` elements.
template <typename Number, typename Size>
bool isPlace(Number place, Size size) {
  return static_cast<long>(place) >= 0 && static_cast<long>(place) < static_cast<long>(size);
}

}  // namespace proximity_server::narrowphase
