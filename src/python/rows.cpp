#include "python/rows.h"

#include "proximity_server/scene/levels/clearance_level.h"

#include <algorithm>

namespace proximity_server::python {
namespace {

using narrowphase::Status;
using scene::Representation;

// The enumerations in src/python/proximity/__init__.py have the same numbers.
static_assert(static_cast<int>(Status::Unknown) == 0 && static_cast<int>(Status::Converged) == 1 &&
              static_cast<int>(Status::Threshold) == 2 && static_cast<int>(Status::IterationLimit) == 3 &&
              static_cast<int>(Status::Degenerate) == 4);
static_assert(static_cast<int>(scene::StateVerdict::Kind::Unknown) == 0 &&
              static_cast<int>(scene::StateVerdict::Kind::Above) == 1 &&
              static_cast<int>(scene::StateVerdict::Kind::Below) == 2);
static_assert(static_cast<int>(Representation::Exact) == 0 && static_cast<int>(Representation::ConvexHull) == 1 &&
              static_cast<int>(Representation::Decomposed) == 2 && static_cast<int>(Representation::Triangles) == 3);

static_assert(static_cast<int>(scene::ClearanceLevel::Clear) == 0 &&
              static_cast<int>(scene::ClearanceLevel::Warn) == 1 &&
              static_cast<int>(scene::ClearanceLevel::Stop) == 2 &&
              static_cast<int>(scene::ClearanceLevel::Collision) == 3 && kInvalidLevel == 4);

std::array<double, 3> arrayOf(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

/// The number of a link in Robot.links, or of an object behind them in the order of Robot.objects; -1: neither.
std::int32_t linkNumber(const scene::ShapeRef& ref, const scene::Objects& objects) {
  if (!ref.isObject()) return ref.link();
  const std::vector<int>& numbers = objects.numbers();
  const auto place = std::find(numbers.begin(), numbers.end(), ref.object()) - numbers.begin();
  return static_cast<std::int32_t>(objects.model().robot.links.size() + static_cast<std::size_t>(place));
}

/// The row without the number of the pair.
PairRow rowOf(Eigen::Index state, const scene::PairProximity& pair) {
  PairRow row;
  row.state = state;
  const narrowphase::SignedDistance& result = pair.result;
  if (result.status == Status::Unknown) return row;
  row.status = static_cast<std::uint8_t>(result.status);
  row.unique = result.unique;
  row.depth_is_lower_bound = pair.depth_is_lower_bound;
  row.representation = static_cast<std::uint8_t>(pair.representation);
  row.distance = result.distance;
  row.lower = result.lower_bound;
  row.upper = result.upper_bound;
  row.point_a = arrayOf(result.point_a);
  row.point_b = arrayOf(result.point_b);
  row.normal = arrayOf(result.normal);
  return row;
}

}  // namespace

LevelRow rowOf(Eigen::Index state, const scene::PairProximity& pair, const PairNumbers& numbers,
               const scene::LevelThresholds* thresholds) {
  LevelRow with_level{rowOf(state, pair)};
  if (pair.result.status == Status::Unknown) return with_level;
  with_level.pair.pair = numbers.of(pair.asked);
  if (thresholds) with_level.level = static_cast<std::int64_t>(levelOf(pair, *thresholds).level);
  return with_level;
}

MinimumRow rowOf(Eigen::Index edge, const scene::RobotMinimum& minimum, const PairNumbers& numbers) {
  MinimumRow row;
  row.pair = rowOf(edge, minimum.pair, numbers, nullptr).pair;
  row.pair.status = static_cast<std::uint8_t>(minimum.status);
  row.pair.lower = minimum.lower_bound;
  row.pair.upper = minimum.upper_bound;
  row.time = minimum.time;
  return row;
}

ContactRow rowOf(Eigen::Index edge, const scene::RobotTimeOfContact& contact, const PairNumbers& numbers) {
  ContactRow row;
  row.edge = edge;
  row.status = static_cast<std::uint8_t>(contact.status);
  row.t_free = contact.t_free;
  if (!contact.contact) return row;
  const PairRow pair = rowOf(edge, contact.pair, numbers, nullptr).pair;
  row.contact = true;
  row.t_contact = contact.t_contact;
  row.unique = pair.unique;
  row.representation = pair.representation;
  row.pair = pair.pair;
  row.distance = pair.distance;
  row.lower = pair.lower;
  row.upper = pair.upper;
  row.point_a = pair.point_a;
  row.point_b = pair.point_b;
  row.normal = pair.normal;
  return row;
}

PointRow rowOf(Eigen::Index state, Eigen::Index point, const scene::PairProximity& closest,
               const scene::Objects& objects) {
  PointRow row{rowOf(state, closest), point};
  row.pair.pair = linkNumber(closest.asked.a, objects);
  return row;
}

HitRow rowOf(Eigen::Index state, Eigen::Index number, const scene::Ray& ray, const scene::RayHit& hit,
             const scene::Objects& objects) {
  constexpr std::int32_t kUnknown = 0, kHit = 1, kFree = 2;  // the numbers of RayHit.msg
  HitRow row;
  row.state = state;
  row.ray = number;
  row.link = linkNumber(hit.shape, objects);
  row.hit = hit.status != Status::Converged ? kUnknown : row.link >= 0 ? kHit : kFree;
  row.distance = hit.distance;
  row.free_until = hit.free;
  if (row.link >= 0) row.point = arrayOf(hit.pointOn(ray));
  row.normal = arrayOf(hit.normal);
  return row;
}

VerdictRow rowOf(const scene::StateVerdict& verdict) { return {static_cast<std::int32_t>(verdict.kind), verdict.pair}; }

ProofRow rowOf(std::int32_t pair, const scene::PairProof& proof) {
  ProofRow row;
  row.pair = pair;
  row.outcome = proof.outcome == scene::ProofOutcome::Undecided ? 0
                : proof.outcome == scene::ProofOutcome::Proven  ? 1
                                                                : 2;
  row.lower = proof.lower_bound;
  row.upper = proof.closest_upper_bound;
  row.undecided = proof.undecided;
  return row;
}

}  // namespace proximity_server::python
