#include "scene/query/part_distance.h"

#include "scene/query/half_space.h"
#include "scene/query/interior_search.h"

#include <algorithm>

namespace proximity_server::scene {
namespace {

/// Keeps only the lower bound of a result beyond the threshold: it proves the answer.
narrowphase::SignedDistance onlyProof(narrowphase::SignedDistance result) {
  const narrowphase::SignedDistance nothing;
  result.status = narrowphase::Status::Threshold;
  result.distance = result.lower_bound;
  result.point_a = result.point_b = nothing.point_a;
  result.has_points = false;
  return result;
}

}  // namespace

ClosestPieces closestOf(PieceSearch& search, const PlacedPair& pair, const LeafPair& guess, double limit,
                        const Question& question) {
  const Part &a = pair.a, &b = pair.b;
  const bool have_interior = haveInterior(a, b);
  if (!b.isUnbounded() && !have_interior) return search.between(pair, guess, limit, question);
  ClosestPieces closest;
  if (b.isUnbounded()) closest = closestToHalfSpaces(pair, limit, question, search.skipping());
  if (b.whole().isEmpty()) return closest;
  if (search.memory() == Memory::None) {
    // Pieces that overlap often are deeper than interiors can be. No answer depends on this order where nothing is kept;
    // otherwise it would change the warm starts of the pieces.
    const ClosestPieces pieces = search.between(pair, guess, limit, question, &closest);
    if (have_interior) findInteriorDepths(pair, limit, question, search.skipping(), 0.0, closest, &pieces);
    closest.add(pieces);
    return closest;
  }
  if (have_interior) findInteriorDepths(pair, limit, question, search.skipping(), 0.0, closest);
  return search.between(pair, guess, limit, question, &closest);
}

bool depthIsExact(const Part& a, const Part& b) {
  // The way out of one half-space is the same for all pieces.
  if (b.isUnbounded()) return b.whole().isEmpty() && b.halfSpaces().size() == 1;
  return a.whole().isLeaf() && b.whole().isLeaf();
}

PairProximity proofOf(const Part& a, const Part& b, double lower_bound) {
  PairProximity proximity;
  proximity.representation = std::max(a.whole().representation, b.whole().representation);
  proximity.result.lower_bound = lower_bound;
  proximity.result = onlyProof(proximity.result);
  return proximity;
}

PairProximity answerOf(const RobotModel& robot, const PlacedPair& pair, const ClosestPieces& closest, double limit,
                       const Question& question) {
  PairProximity answer = proofOf(pair.a, pair.b, closest.lower_bound);
  answer.result = closest.result;
  answer.result.lower_bound = closest.lower_bound;
  answer.result.upper_bound = closest.upper_bound;
  if (!closest.empty()) {
    const Part &a = pair.a, &b = pair.b;
    const LeafPair& leaves = closest.leaves;
    const bool is_plane = leaves.hasHalfSpace();  // a half-space is exact
    answer.collision_a = collisionNumber(robot, a.pieces[a[leaves.a].piece], a.object);
    answer.collision_b =
        is_plane ? b.shapeNumber(leaves.half_space) : collisionNumber(robot, b.pieces[b[leaves.b].piece], b.object);
    answer.representation = a[leaves.a].representation;
    if (!is_plane) answer.representation = std::max(answer.representation, b[leaves.b].representation);
    const bool too_wide = closest.upper_bound - closest.lower_bound > narrowphase::usableTolerance(question.tolerance);
    if (closest.result.status == narrowphase::Status::Converged && too_wide)
      answer.result.status = closest.lower_bound_status;
  }
  answer.depth_is_lower_bound = closest.result.distance < 0.0 && !depthIsExact(pair.a, pair.b);
  if (isBeyond(answer.result, limit)) answer.result = onlyProof(answer.result);
  return answer;
}

}  // namespace proximity_server::scene
