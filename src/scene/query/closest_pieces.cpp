#include "scene/query/closest_pieces.h"

#include "scene/model/numbers.h"

#include <algorithm>

namespace proximity_server::scene {
namespace {

/// The digits of an answer do not depend on what is remembered where the nearest features are clear; with Memory::None
/// they never do.
narrowphase::Options optionsFor(const Question& question, double limit, double padding, Memory memory) {
  using narrowphase::Repeatability;
  narrowphase::Options options;
  options.repeatability = memory == Memory::None ? Repeatability::Always : Repeatability::OfClearFeatures;
  options.distance_tolerance = question.tolerance;
  options.stop_above = limit + padding;
  if (question.depth == Question::Depth::NotWanted) options.stop_below = std::min(0.0, question.threshold) + padding;
  return options;
}

/// The number of pairs of pieces that are remembered: all pairs of a robot of up to 256 pieces.
std::size_t rememberedPieces(std::size_t pieces) { return std::min<std::size_t>(pieces * pieces / 2, 1u << 15); }

}  // namespace

narrowphase::SignedDistance padded(narrowphase::SignedDistance result, double padding) {
  result.distance -= padding;
  result.lower_bound -= padding;
  result.upper_bound -= padding;
  result.point_a += 0.5 * padding * result.normal;
  result.point_b = result.point_a + result.distance * result.normal;
  return result;
}

bool isFinal(const narrowphase::SignedDistance& result, const Question& question) {
  return question.depth == Question::Depth::NotWanted &&
         (result.distance <= 0.0 || result.status == narrowphase::Status::Threshold);
}

void ClosestPieces::offer(const LeafPair& pair, const narrowphase::SignedDistance& other, double limit) {
  add({pair, other, isBeyond(other, limit), other.lower_bound, other.upper_bound, other.status});
}

void ClosestPieces::add(const ClosestPieces& other) {
  if (other.lower_bound < lower_bound) {
    lower_bound = other.lower_bound;
    lower_bound_status = other.lower_bound_status;
  }
  upper_bound = std::min(upper_bound, other.upper_bound);
  const bool closer = is_beyond == other.is_beyond ? other.result.distance < result.distance : is_beyond;
  if (other.empty() || (!empty() && !closer)) return;
  leaves = other.leaves;
  result = other.result;
  is_beyond = other.is_beyond;
}

void ClosestPieces::leaveOut(double lower_bound_of_others) {
  if (!(lower_bound_of_others < lower_bound)) return;
  lower_bound = lower_bound_of_others;
  lower_bound_status = narrowphase::Status::Threshold;
}

double ClosestPieces::limit(double outer_limit, const Question& question) const {
  if (is_beyond) return outer_limit;
  return isFinal(result, question) ? -kInfinity : std::min(outer_limit, result.distance);
}

PieceSearch::PieceSearch(const PlacedRobot& robot, std::size_t pieces, Skipping skipping, Memory memory)
    : robot_(robot), skipping_(skipping), memory_(memory), warm_starts_(rememberedPieces(pieces)) {
  queue_.reserve(rememberedPieces(pieces));
}

void PieceSearch::makeRoomFor(std::size_t pieces) {
  // Only pairs that are near are computed again and again.
  warm_starts_.grow(std::min<std::size_t>(rememberedPieces(pieces), 1u << 12));
}

ClosestPieces PieceSearch::between(const Visit& pair, const RelativePose& a_T_b, const LeafPair& likely, double limit,
                                   const Question& question, const ClosestPieces* found) {
  ClosestPieces closest;
  if (found) closest = *found;
  a_ = robot_[pair.a];
  b_ = robot_[pair.b];
  const auto current_limit = [&] {
    return skipping_ == Skipping::On ? closest.limit(limit, question) : question.threshold;
  };
  // A guess is given along edges, where warm starts save time; the options keep answers from depending on them.
  const Memory start_from = likely.areLeaves() ? Memory::OfAnswers : memory_;
  const auto distanceOf = [&](const LeafPair& leaves) {
    const auto options = optionsFor(question, current_limit(), pair.padding, memory_);
    return distanceInBodyA(leaves, pair, a_T_b, options, start_from);
  };
  narrowphase::SignedDistance of_likely;
  const auto compute = [&](const LeafPair& leaves) {
    // With a smaller limit the search may end earlier, unless the answer is beyond that limit anyway.
    const bool is_known = of_likely.status == narrowphase::Status::Converged && leaves == likely &&
                          (!(current_limit() < limit) || isBeyond(of_likely, current_limit()));
    closest.offer(leaves, is_known ? of_likely : distanceOf(leaves), limit);
  };
  if (a_.whole().isLeaf() && b_.whole().isLeaf()) {
    compute({a_.root, b_.root});
    return closest;
  }
  if (likely.areLeaves() && memory_ == Memory::OfAnswers) {
    compute(likely);
  } else if (likely.areLeaves()) {
    of_likely = distanceOf(likely);
    if (of_likely.status == narrowphase::Status::Converged) limit = std::min(limit, of_likely.distance + kSettledFor);
  }
  for (begin(pair, a_T_b, current_limit()); !queue_.empty() && !(lowestBound() > current_limit());) {
    const VolumePair volumes = queue_.pop();
    if (!areLeaves(volumes)) {
      split(volumes, a_T_b, current_limit());
    } else if (const LeafPair leaves{volumes.a, volumes.b}; memory_ == Memory::None || !(leaves == likely)) {
      compute(leaves);
    }
  }
  closest.leaveOut(std::min(left_out_, lowestBound()));
  return closest;
}

bool PieceSearch::areBeyond(const Visit& pair, const RelativePose& a_T_b, double limit) {
  a_ = robot_[pair.a];
  b_ = robot_[pair.b];
  const narrowphase::Options options = narrowphase::Options::above(limit + pair.padding);
  const auto isBeyondIt = [&](const LeafPair& leaves) {
    return isBeyond(distanceInBodyA(leaves, pair, a_T_b, options, memory_), limit);
  };
  if (a_.whole().isLeaf() && b_.whole().isLeaf()) return isBeyondIt({a_.root, b_.root});
  for (begin(pair, a_T_b, limit); !queue_.empty() && !(lowestBound() > limit);) {
    const VolumePair volumes = queue_.pop();
    if (!areLeaves(volumes))
      split(volumes, a_T_b, limit);
    else if (!isBeyondIt({volumes.a, volumes.b}))
      return false;
  }
  return true;
}

narrowphase::SignedDistance PieceSearch::distanceInBodyA(const LeafPair& leaves, const Visit& pair,
                                                         const RelativePose& a_T_b, const narrowphase::Options& options,
                                                         Memory start_from) {
  narrowphase::WarmStart cold;
  const Leaf a(a_, leaves.a), b(b_, leaves.b);
  narrowphase::WarmStart& start = start_from == Memory::None ? cold : warm_starts_.of(a.number, b.number);
  return padded(PlacedRobot::distanceInBodyA(a, b, a_T_b, options, start), pair.padding);
}

/// [m] A lower bound of the distance of two volumes minus the padding: that of their spheres if it is above the limit,
/// else also that of their boxes. Evidence: boxes at once, in place of when a pair is the nearest in the queue, save 16 %
/// of the time of cold questions about one object of 10,000 boxes; those about robots take as long (AMD EPYC, 2026-11).
double PieceSearch::boundAbove(double limit, const Volume& a, const Volume& b, const RelativePose& a_T_b) {
  const CentreOffset offset = centreOffset(a.bounds, b.bounds, a_T_b);
  const double spheres = sphereGap(a.bounds, b.bounds, offset) - padding_;
  if (spheres > limit || !PlacedRobot::boxesPay(a, b)) return spheres;
  return std::max(spheres, box_gaps_.between(a.bounds, b.bounds, offset) - padding_);
}

/// Fills the queue with the volumes to visit. The bound of the pair is not used, so that among equally close pieces the
/// same ones are found, whatever is known of the pair.
void PieceSearch::begin(const Visit& pair, const RelativePose& a_T_b, double limit) {
  queue_.clear();
  pushed_ = 0;
  padding_ = pair.padding;
  left_out_ = kInfinity;
  if (skipping_ == Skipping::On && !a_.object && !b_.object) {
    const LeafBoxes &a = robot_.volumes().leavesOf(pair.a), &b = robot_.volumes().leavesOf(pair.b);
    if (LeafGaps::areFew(a, b, a_T_b)) {
      for (const LeafGaps::Gap& gap : gaps_.between(a, b, a_T_b, pair.padding, limit))
        queue_.push({gap.lower_bound, gap.number, gap.a, gap.b});
      left_out_ = gaps_.smallestOfOthers();
      return;
    }
  }
  box_gaps_.begin(a_T_b);
  split({-kInfinity, 0, a_.root, b_.root}, a_T_b, limit);
}

/// Replaces a pair of volumes by the pairs with the parts of one of them, see splitsFirst(). Pairs beyond the limit [m]
/// are left out.
void PieceSearch::split(const VolumePair& whole, const RelativePose& a_T_b, double limit) {
  const Volume &a = a_[whole.a], &b = b_[whole.b];
  const bool split_a = splitsFirst(a, b);
  for (const int part : split_a ? a.parts : b.parts) {
    VolumePair next{-kInfinity, pushed_++, split_a ? part : whole.a, split_a ? whole.b : part};
    // A bound of a whole also holds for its parts.
    if (skipping_ == Skipping::On)
      next.lower_bound = std::max(whole.lower_bound, boundAbove(limit, a_[next.a], b_[next.b], a_T_b));
    if (next.lower_bound > limit)
      left_out_ = std::min(left_out_, next.lower_bound);
    else
      queue_.push(next);
  }
}

}  // namespace proximity_server::scene
