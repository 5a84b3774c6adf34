#pragma once

#include "proximity_server/scene/batch/scene_batch.h"
#include "proximity_server/scene/levels/level_thresholds.h"
#include "proximity_server/scene/motion/motion_question.h"
#include "proximity_server/scene/objects/objects.h"
#include "proximity_server/scene/points/ray_search.h"
#include "proximity_server/scene/proof/pair_proof.h"
#include "python/pair_numbers.h"

#include <Eigen/Core>

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>

// The rows of the answers, in the layout of numpy. All fields are aligned without unused bytes between them, so that
// files of equal answers have equal bytes.

namespace proximity_server::python {

/// The row of a PairProximity in one state. The default is a row without an answer: narrowphase::Status::Unknown.
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

/// The level of a pair that has no answer.
constexpr std::int64_t kInvalidLevel = 4;

/// The row of a pair with its level. In numpy the fields of the pair and the level are side by side; if the robot has
/// no thresholds, the level is left out.
struct LevelRow {
  PairRow pair;
  std::int64_t level = kInvalidLevel;
};
static_assert(sizeof(LevelRow) == sizeof(PairRow) + 8 && offsetof(LevelRow, pair) == 0);

/// The row of a StateVerdict.
struct VerdictRow {
  std::int32_t verdict = 0;
  std::int32_t pair = -1;
};

/// The row of a RobotMinimum of an edge: the closest pair at its time, with the bounds of the whole edge. In numpy the
/// fields of the pair and the time are side by side, and the field `state` is called `edge`.
struct MinimumRow {
  PairRow pair;
  double time = std::numeric_limits<double>::quiet_NaN();
};
static_assert(sizeof(MinimumRow) == sizeof(PairRow) + 8 && offsetof(MinimumRow, pair) == 0);

/// The row of a RobotTimeOfContact of an edge. Without a contact it has no pair.
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

/// The row of a point in a state: the pair of the closest link or object, and the ball about the point. In numpy the
/// fields of the pair and the number of the point are side by side, and the field `pair` is called `link`.
struct PointRow {
  PairRow pair;
  std::int64_t point = 0;
};
static_assert(sizeof(PointRow) == sizeof(PairRow) + 8 && offsetof(PointRow, pair) == 0);

/// The row of a RayHit in a state.
struct HitRow {
  std::int64_t state = 0;
  std::int64_t ray = 0;
  std::int32_t hit = 0;
  std::int32_t link = -1;
  double distance = std::numeric_limits<double>::quiet_NaN();
  double free_until = 0.0;
  std::array<double, 3> point{distance, distance, distance};
  std::array<double, 3> normal = point;
};

/// The row of a PairProof; `outcome` is 0 where nothing is decided.
struct ProofRow {
  std::int32_t pair = -1;
  std::int32_t outcome = 0;
  double lower = -std::numeric_limits<double>::infinity();
  double upper = std::numeric_limits<double>::infinity();
  double undecided = 1.0;
};

/// Makes the row of a pair. If `thresholds` is nullptr, its level stays at the default.
LevelRow rowOf(Eigen::Index state, const scene::PairProximity& pair, const PairNumbers& numbers,
               const scene::LevelThresholds* thresholds);
MinimumRow rowOf(Eigen::Index edge, const scene::RobotMinimum& minimum, const PairNumbers& numbers);
ContactRow rowOf(Eigen::Index edge, const scene::RobotTimeOfContact& contact, const PairNumbers& numbers);
PointRow rowOf(Eigen::Index state, Eigen::Index point, const scene::PairProximity& closest,
               const scene::Objects& objects);
HitRow rowOf(Eigen::Index state, Eigen::Index number, const scene::Ray& ray, const scene::RayHit& hit,
             const scene::Objects& objects);
VerdictRow rowOf(const scene::StateVerdict& verdict);
ProofRow rowOf(std::int32_t pair, const scene::PairProof& proof);

}  // namespace proximity_server::python
