#pragma once

#include "stress/families.h"
#include "stress/motion_families.h"

#include <optional>
#include <string>
#include <vector>

// Cases that were once wrong, one in a line of a JSON file. Every double is written with all of its digits; "inf" and
// "nan" stand in quotes. Shapes have half extents in metres; a pose is given by the rows of [R | t].

namespace proximity_server::narrowphase {

/// One line of test/data/recorded_pairs.jsonl. Options and warm start are left out where they do not matter.
struct RecordedPair {
  std::string name;  ///< of a stress pair its family, seed and number, which repeat it with its relatives
  StressPair pair;
  std::optional<double> expected;      ///< signed distance by branch and bound in long double (test/oracle/oracle.h)
  std::optional<int> most_iterations;  ///< it converges at the default tolerance within so many iterations
};

/// One line of test/data/recorded_motions.jsonl.
struct RecordedMotion {
  std::string name;  ///< its family, seed and number, which repeat it, and what was wrong
  StressMotion motion;
};

std::string toJsonLine(const RecordedPair& recorded);
std::string toJsonLine(const RecordedMotion& recorded);

/// Throws std::runtime_error if a shape has a kind that is not known.
RecordedPair pairFromJsonLine(const std::string& line);
RecordedMotion motionFromJsonLine(const std::string& line);

/// Returns every case of the file of that name in test/data. Throws std::runtime_error if it cannot be read.
std::vector<RecordedPair> readRecordedPairs();
std::vector<RecordedMotion> readRecordedMotions();

}  // namespace proximity_server::narrowphase
