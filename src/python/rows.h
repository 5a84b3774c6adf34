#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "proximity_server/scene/batch/scene_batch.h"
#include "proximity_server/scene/query/level_thresholds.h"

// The rows of the answers, as numpy sees them: every field is named and aligned, and no byte is left over between them, so that
// a file of them is a function of the answers.

namespace proximity_server::python {

/// PairProximity about one state. The default is no answer: narrowphase::Status::Unknown.
struct PairRow {
  std::int64_t state = 0;
  std::uint8_t status = 0;
  bool unique = false;
  bool depth_is_lower_bound = false;
  std::uint8_t representation = 0;
  std::int32_t pair = -1;
  double distance = std::numeric_limits<double>::quiet_NaN();
  double lower = -std::numeric_limits<double>::infinity();
  double upper = std::numeric_limits<double>::infinity();
  std::array<double, 3> point_a{distance, distance, distance};
  std::array<double, 3> point_b = point_a;
  std::array<double, 3> normal = point_a;
};
static_assert(sizeof(PairRow) == 8 + 4 + 4 + 12 * 8);

/// The number of a level that is not known, as a pair has no answer.
constexpr std::int64_t kInvalidLevel = 4;

/// The row of a robot with thresholds. Numpy sees the fields of the pair beside the level; without thresholds it sees the pair only.
struct LevelRow {
  PairRow pair;
  std::int64_t level = kInvalidLevel;
};
static_assert(sizeof(LevelRow) == sizeof(PairRow) + 8 && offsetof(LevelRow, pair) == 0);

/// StateVerdict about one state.
struct VerdictRow {
  std::int32_t verdict = 0;
  std::int32_t pair = -1;
};

/// The row of a pair, which is Unknown if it is none of the candidates. Without thresholds (nullptr) it has no level.
LevelRow rowOf(Eigen::Index state, const scene::PairProximity& pair, const scene::Candidates& candidates,
               const scene::LevelThresholds* thresholds);
VerdictRow rowOf(const scene::StateVerdict& verdict);

}  // namespace proximity_server::python
