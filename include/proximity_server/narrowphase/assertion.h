#pragma once

#include <cmath>
#include <cstdio>
#include <cstdlib>

/// PROXIMITY_ASSERT(condition, advice) states a precondition of an inner function, which no input of a user can break.
/// Without NDEBUG, as in the sanitized builds and the fuzzers, the program ends if the condition is false, and prints
/// the place, the condition and the advice: the likely cause and the cure. In a release build the condition is
/// compiled, but no instruction is executed.
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

/// True if a vector of Eigen has the length 1, within 5e-10: a normalised vector is off by a few eps, and one that was
/// not normalised by more. False for NaN.
template <typename Vector>
bool isUnit(const Vector& v) {
  return std::abs(v.squaredNorm() - 1.0) <= 1e-9;
}

/// True if a number is the index of one of `size` elements.
template <typename Number, typename Size>
bool isPlace(Number place, Size size) {
  return static_cast<long>(place) >= 0 && static_cast<long>(place) < static_cast<long>(size);
}

}  // namespace proximity_server::narrowphase
