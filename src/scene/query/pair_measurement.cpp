#include "scene/query/pair_measurement.h"

#include "scene/model/numbers.h"
#include "scene/query/half_space.h"
#include "scene/query/interior_search.h"
#include "scene/query/part_distance.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

namespace proximity_server::scene {
namespace {

PairProximity unknown(const ShapeRefPair& pair) {
  PairProximity proximity;
  proximity.asked = pair;
  return proximity;
}

/// The number of pairs whose answers are kept: all candidates, and equally many other pairs.
std::size_t rememberedPairs(std::size_t candidates) {
  return std::clamp<std::size_t>(2 * candidates, 1u << 8, 1u << 14);
}

}  // namespace

int& countOf(Visit::Bound bound, PairCounts& counts) {
  switch (bound) {
    case Visit::Bound::Rest:
      return counts.at_rest;
    case Visit::Bound::Motion:
      return counts.by_motion;
    case Visit::Bound::Sphere:
    case Visit::Bound::Box:
      break;
  }
  return counts.by_bounds;
}

PairMeasurement::PairMeasurement(const SceneModel& model, Skipping skipping, Memory memory)
    : model_(model),
      skipping_(skipping),
      memory_(memory),
      pieces_(model.robot.pieces.size(), skipping, memory),
      kept_(memory == Memory::None ? 0 : rememberedPairs(model.pairs.checked.size())),
      paddings_(paddingsOf(model.pairs)) {}

void PairMeasurement::see(const PlacedRobot& robot) {
  robot_ = &robot;
  if (memory_ == Memory::None) return;
  if (robot.objects() != objects_) take(robot.objects());
}

/// Forgets what is kept about objects that have another geometry now.
void PairMeasurement::take(std::shared_ptr<const Objects> objects) {
  pieces_.makeRoomFor(model_.robot.pieces.size() + static_cast<std::size_t>(objects->pieceCount()));
  // Few of many objects are near, and the hierarchy settles the others without an entry here.
  const auto near = std::min<std::size_t>(static_cast<std::size_t>(objects->pairCount()), 1u << 10);
  kept_.grow(rememberedPairs(model_.pairs.checked.size() + near));
  const auto isChanged = [&](int part) {
    const int object = robot_->refOf(part).object();
    const PlacedObject *before = objects_->placed(object), *now = objects->placed(object);
    return before && !(now && now->geometry == before->geometry);
  };
  if (objects_) kept_.forget([&](int a, int b) { return isChanged(a) || isChanged(b); });
  objects_ = std::move(objects);
}

/// If one part has half-spaces, it becomes the second one.
// All numbers are there before the visit is made of them: a search asks for each of its pairs, and would wait for the
// parts of a visit that was just written to be read again as a whole.
std::optional<Visit> PairMeasurement::visitOf(const ShapeRefPair& pair, const PartPair& parts, int number) const {
  int a = std::min(parts.a, parts.b), b = std::max(parts.a, parts.b);
  if (!robot_->isPlaced(a) || !robot_->isPlaced(b)) return std::nullopt;
  if (robot_->isObject(b) && robot_->isUnboundedFirst(a, b)) std::swap(a, b);
  const double padding = paddings_.of(pair);
  const double lower_bound = skipping_ == Skipping::On ? robot_->sphereGap(a, b) - padding : -kInfinity;
  return Visit{{a, b}, lower_bound, number, padding};
}

Visit PairMeasurement::refined(Visit visit, double limit) {
  visit.bound = Visit::Bound::Box;
  if (skipping_ == Skipping::Off) return visit;
  const Part &a = (*robot_)[visit.a], &b = (*robot_)[visit.b];
  const RelativePose a_T_b = robot_->relative(visit.a, visit.b);
  if (const KeptAnswer* kept = keptOf(visit)) {
    const RelativeMotionBound motion = PlacedRobot::relativeMotion(a, b, kept->a_T_b, a_T_b);
    const double bound = kept->in_body_a.result.lower_bound - motion.distance_change;
    if (bound > visit.lower_bound) {
      visit.lower_bound = bound;
      visit.bound = motion.is_rest ? Visit::Bound::Rest : Visit::Bound::Motion;
    }
  }
  if (!(visit.lower_bound > limit) && PlacedRobot::boxesPay(a.whole(), b.whole()) && !b.isUnbounded()) {
    const double bound = boxGap(a.whole().bounds, b.whole().bounds, a_T_b) - visit.padding;
    if (bound > visit.lower_bound) {
      visit.lower_bound = bound;
      visit.bound = Visit::Bound::Box;
    }
  }
  return visit;
}

/// The kept answer if the two are at rest. Its bounds allow for the rounding of the new poses.
std::optional<PairProximity> PairMeasurement::answerAtRest(const Visit& visit, const RelativePose& a_T_b,
                                                           const Question& question) const {
  const KeptAnswer* kept = skipping_ == Skipping::On ? keptOf(visit) : nullptr;
  if (!kept || kept->in_body_a.result.status != narrowphase::Status::Converged) return std::nullopt;
  const RelativeMotionBound motion =
      PlacedRobot::relativeMotion((*robot_)[visit.a], (*robot_)[visit.b], kept->a_T_b, a_T_b);
  if (!motion.is_rest) return std::nullopt;
  PairProximity in_body_a = kept->in_body_a;
  in_body_a.result.lower_bound -= motion.distance_change;
  in_body_a.result.upper_bound += motion.distance_change;
  if (in_body_a.result.upper_bound - in_body_a.result.lower_bound > narrowphase::usableTolerance(question.tolerance))
    return std::nullopt;
  return in_body_a;
}

/// Returns only the proof if all pieces are beyond the limit.
PairProximity PairMeasurement::compute(const Visit& visit, const RelativePose& a_T_b, double limit,
                                       const Question& question, LeafPair* guess) {
  const KeptAnswer* kept = skipping_ == Skipping::On ? keptOf(visit) : nullptr;
  const LeafPair start = kept ? kept->leaves : guess ? *guess : LeafPair();
  const PlacedPair pair = placed(visit, a_T_b);
  const ClosestPieces closest = closestOf(pieces_, pair, start, limit, question);
  if (guess && !closest.empty()) *guess = closest.leaves;
  const PairProximity in_body_a = answerOf(model_.robot, pair, closest, limit, question);
  if (skipping_ == Skipping::On && memory_ != Memory::None)
    kept_.of(visit.a, visit.b) = {a_T_b, in_body_a, closest.leaves};
  return in_body_a;
}

PairProximity PairMeasurement::asAsked(const ShapeRefPair& pair, const Visit& visit,
                                       const PairProximity& in_body_a) const {
  PairProximity proximity = in_body_a;
  proximity.asked = pair;
  proximity.result = robot_->inPosesFrame(visit.a, proximity.result);
  if (robot_->numberOf(pair.a) == visit.a) return proximity;
  std::swap(proximity.collision_a, proximity.collision_b);
  std::swap(proximity.result.point_a, proximity.result.point_b);
  proximity.result.normal = -proximity.result.normal;
  return proximity;
}

PairProximity PairMeasurement::measure(const ShapeRefPair& pair, const Visit& visit, double limit,
                                       const Question& question, LeafPair* guess) {
  const RelativePose a_T_b = robot_->relative(visit.a, visit.b);
  if (const auto kept = answerAtRest(visit, a_T_b, question)) {
    ++counts_.at_rest;
    return asAsked(pair, visit, *kept);
  }
  if (question.deadline.hasPassed()) {
    ++counts_.unknown;
    return unknown(pair);
  }
  const PairProximity in_body_a = compute(visit, a_T_b, limit, question, guess);
  if (in_body_a.result.status == narrowphase::Status::Unknown)
    ++counts_.unknown;  // too far for the narrowphase
  else
    ++(in_body_a.collision_a > 0 ? counts_.computed : counts_.by_bounds);
  return asAsked(pair, visit, in_body_a);
}

PairProximity PairMeasurement::settle(const ShapeRefPair& pair, const Question& question, LeafPair* guess) {
  ++counts_.total;
  std::optional<Visit> visit = visitOf(pair, 0);
  if (!visit) {
    ++counts_.unknown;
    return unknown(pair);
  }
  if (question.thresholds) visit->threshold = question.thresholds->of(pair);
  const double limit = question.threshold + visit->threshold;
  if (limit < kInfinity && !(visit->lower_bound > limit)) visit = refined(*visit, limit);
  if (!(visit->lower_bound > limit)) return measure(pair, *visit, limit, question, guess);
  ++countOf(visit->bound, counts_);
  return asAsked(pair, *visit, proofOf((*robot_)[visit->a], (*robot_)[visit->b], visit->lower_bound));
}

bool PairMeasurement::isProvenBeyond(const Visit& visit, double distance) {
  if (visit.lower_bound > distance) return true;
  const Visit box = refined(visit, distance);
  return box.lower_bound > distance || arePiecesBeyond(box, distance);
}

bool PairMeasurement::arePiecesBeyond(const Visit& visit, double distance) {
  const PlacedPair pair = placed(visit, robot_->relative(visit.a, visit.b));
  if (const Part& b = pair.b; b.isUnbounded()) {
    if (!(closestToHalfSpaces(pair, distance, {}, skipping_).lower_bound > distance)) return false;
    if (b.whole().isEmpty()) return true;
  }
  if (!pieces_.areBeyond(pair, distance)) return false;
  if (!haveInterior(pair.a, pair.b)) return true;
  ClosestPieces inside;
  findInteriorDepths(pair, distance, {}, skipping_, 0.0, inside);
  return inside.lower_bound > distance;
}

DistanceBounds PairMeasurement::interiorOf(const ShapeRefPair& pair, double within) const {
  const std::optional<Visit> visit = visitOf(pair, 0);
  ClosestPieces closest;
  if (visit) {
    const PlacedPair placed_pair = placed(*visit, robot_->relative(visit->a, visit->b));
    findInteriorDepths(placed_pair, kInfinity, {}, skipping_, within, closest);
  }
  return {closest.lower_bound, closest.upper_bound};
}

bool PairMeasurement::isStillWithin(const Visit& visit, double threshold) const {
  const KeptAnswer* kept = keptOf(visit);
  if (!kept) return false;
  const RelativeMotionBound motion = PlacedRobot::relativeMotion((*robot_)[visit.a], (*robot_)[visit.b], kept->a_T_b,
                                                                 robot_->relative(visit.a, visit.b));
  return kept->in_body_a.result.upper_bound + motion.distance_change <= threshold;
}

}  // namespace proximity_server::scene
