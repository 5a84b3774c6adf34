#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "proximity_server/scene/batch/scene_batch.h"
#include "proximity_server/scene/levels/level_thresholds.h"
#include "proximity_server/scene/motion/moving_scene.h"
#include "python/pair_numbers.h"

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

/// RobotMinimum of an edge: the closest pair at its time, with the bounds of the whole edge. Numpy sees the fields of the pair, of which
/// `state` is called `edge`, and the time.
struct MinimumRow {
  PairRow pair;
  double time = std::numeric_limits<double>::quiet_NaN();
};
static_assert(sizeof(MinimumRow) == sizeof(PairRow) + 8 && offsetof(MinimumRow, pair) == 0);

/// RobotContact of an edge. Without a contact there is no pair.
struct ContactRow {
  std::int64_t edge = 0;
  std::uint8_t status = 0;
  bool contact = false;
  bool unique = false;
  std::uint8_t representation = 0;
  std::int32_t pair = -1;
  double t_free = 0.0;
  double t_contact = std::numeric_limits<double>::quiet_NaN();
  double distance = t_contact;
  double lower = -std::numeric_limits<double>::infinity();
  double upper = std::numeric_limits<double>::infinity();
  std::array<double, 3> point_a{t_contact, t_contact, t_contact};
  std::array<double, 3> point_b = point_a;
  std::array<double, 3> normal = point_a;
};

/// The row of a pair, which is Unknown if it has no number. Without thresholds (nullptr) it has no level.
LevelRow rowOf(Eigen::Index state, const scene::PairProximity& pair, const PairNumbers& numbers,
               const scene::LevelThresholds* thresholds);
MinimumRow rowOf(Eigen::Index edge, const scene::RobotMinimum& minimum, const PairNumbers& numbers);
ContactRow rowOf(Eigen::Index edge, const scene::RobotContact& contact, const PairNumbers& numbers);
VerdictRow rowOf(const scene::StateVerdict& verdict);

}  // namespace proximity_server::python
