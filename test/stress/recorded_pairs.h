#pragma once

#include <optional>
#include <string>
#include <vector>

#include "stress/families.h"

namespace proximity_server::narrowphase {

/// One line of test/data/recorded_pairs.jsonl: a pair that was once wrong. Half extents in metres, a_T_b: rows of
/// [R | t], every double with all of its digits; "inf" and "nan" in quotes. Options and warm start where they matter.
struct RecordedPair {
  std::string name;  ///< of a stress pair its family, seed and number, which repeat it with its relatives
  StressPair pair;
  std::optional<double> expected;      ///< signed distance by branch and bound in long double (test/oracle/oracle.h)
  std::optional<int> most_iterations;  ///< it converges at the default tolerance within so many iterations
};

std::string toJsonLine(const RecordedPair& recorded);
RecordedPair fromJsonLine(const std::string& line);

/// Every line of the file. Throws std::runtime_error where it cannot be read.
std::vector<RecordedPair> readRecordedPairs(const std::string& path);

}  // namespace proximity_server::narrowphase
