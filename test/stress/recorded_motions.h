#pragma once

#include <string>
#include <vector>

#include "stress/motion_families.h"

namespace proximity_server::narrowphase {

/// One line of test/data/recorded_motions.jsonl: a motion that an answer was once wrong for; shapes and poses as in
/// recorded_pairs.h.
struct RecordedMotion {
  std::string name;  ///< its family, seed and number, which repeat it, and what was wrong
  StressMotion motion;
};

std::string toJsonLine(const RecordedMotion& recorded);
RecordedMotion motionFromJsonLine(const std::string& line);

/// Every line of the file. Throws std::runtime_error where it cannot be read.
std::vector<RecordedMotion> readRecordedMotions(const std::string& path);

}  // namespace proximity_server::narrowphase
