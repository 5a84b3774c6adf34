#pragma once

// The laws of all questions about two shapes, each written once: for the pairs of tests, of ./dev stress and of the fuzzer.

#include "stress/families.h"

#include <optional>
#include <string>

namespace proximity_server::narrowphase {

/// Allowed error of an answer that converged to this part of the size, against the oracle.
constexpr double kPolytopeErrorLimit = 1e-10;
constexpr double kCurvedErrorLimit = 1e-9;

/// A promise that was not kept, and the pair that shows it: the one observed or a relative of it.
struct Failure {
  std::string sentence;
  StressPair pair;
};

/// The result of one pair.
struct Observation {
  SignedDistance result;
  double size = 0.0;            ///< [m] ShapePair::scale()
  double microseconds = 0.0;    ///< of the query; the shorter of two
  std::optional<double> error;  ///< [m] of the distance, where the oracle was asked
  std::optional<Failure> failure;
};

/// Asks the pair and checks everything that a result promises: its proof from scratch, the same bits for the same
/// input, and that swapped, moved, shifted and warm-started queries and those with a threshold agree within their
/// bounds; swapped with the opposite normal.
Observation observe(const StressPair& stress_pair);

/// Does the same, and two checks that take longer: the answer against the independent oracle, and whether shapes of a
/// quarter of the size have a quarter of the distance.
Observation observeWithOracle(const StressPair& stress_pair);

}  // namespace proximity_server::narrowphase
