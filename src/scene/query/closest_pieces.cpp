#include "scene/query/closest_pieces.h"

#include "scene/model/numbers.h"

#include <algorithm>

namespace proximity_server::scene {
namespace {

/// The digits of an answer do not depend on what is remembered where the nearest features are clear; with Memory::None
/// they never do.
narrowphase::Options optionsFor(const Question& question, double limit, const PlacedPair& pair, Memory memory) {
  using narrowphase::Repeatability;
  narrowphase::Options options;
  options.repeatability = memory == Memory::None ? Repeatability::Always : Repeatability::OfClearFeatures;
  options.distance_tolerance = question.tolerance;
  options.stop_above = limit + pair.padding;
  if (question.depth == Question::Depth::NotWanted)
    options.stop_below = std::min(0.0, question.threshold + pair.threshold) + pair.padding;
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

PieceSearch::PieceSearch(std::size_t pieces, Skipping skipping, Memory memory)
    : skipping_(skipping), memory_(memory), warm_starts_(rememberedPieces(pieces)) {
  queue_.reserve(rememberedPieces(pieces));
}

void PieceSearch::makeRoomFor(std::size_t pieces) {
  // Only pairs that are near are computed again and again.
  warm_starts_.grow(std::min<std::size_t>(rememberedPieces(pieces), 1u << 12));
}

ClosestPieces PieceSearch::between(const PlacedPair& pair, const LeafPair& guess, double limit,
                                   const Question& question, const ClosestPieces* found) {
  ClosestPieces closest;
  if (found) closest = *found;
  a_ = pair.a;
  b_ = pair.b;
  const auto current_limit = [&] {
    return skipping_ == Skipping::On ? closest.limit(limit, question) : question.threshold + pair.threshold;
  };
  // A guess is given along edges, where warm starts save time; the options keep answers from depending on them.
  const Memory start_from = guess.areLeaves() ? Memory::OfAnswers : memory_;
  const auto distanceOf = [&](const LeafPair& leaves) {
    const auto options = optionsFor(question, current_limit(), pair, memory_);
    return distanceInBodyA(leaves, pair, options, start_from);
  };
  narrowphase::SignedDistance of_guess;
  const auto compute = [&](const LeafPair& leaves) {
    // With a smaller limit the search may end earlier, unless the answer is beyond that limit anyway.
    const bool is_known = of_guess.status == narrowphase::Status::Converged && leaves == guess &&
                          (!(current_limit() < limit) || isBeyond(of_guess, current_limit()));
    closest.offer(leaves, is_known ? of_guess : distanceOf(leaves), limit);
  };
  if (a_.whole().isLeaf() && b_.whole().isLeaf()) {
    compute({a_.root, b_.root});
    return closest;
  }
  if (guess.areLeaves() && memory_ == Memory::OfAnswers) {
    compute(guess);
  } else if (guess.areLeaves()) {
    of_guess = distanceOf(guess);
    if (of_guess.status == narrowphase::Status::Converged) limit = std::min(limit, of_guess.distance + kSettledFor);
  }
  for (begin(pair, current_limit()); !queue_.empty() && !(lowestBound() > current_limit());) {
    const VolumePair volumes = queue_.pop();
    if (!areLeaves(volumes)) {
      open(volumes, pair.a_T_b, current_limit());
    } else if (const LeafPair leaves{volumes.a, volumes.b}; memory_ == Memory::None || !(leaves == guess)) {
      compute(leaves);
    }
  }
  closest.leaveOut(std::min(left_out_, lowestBound()));
  return closest;
}

bool PieceSearch::areBeyond(const PlacedPair& pair, double limit) {
  a_ = pair.a;
  b_ = pair.b;
  const narrowphase::Options options = narrowphase::Options::above(limit + pair.padding);
  const auto isBeyondIt = [&](const LeafPair& leaves) {
    return isBeyond(distanceInBodyA(leaves, pair, options, memory_), limit);
  };
  if (a_.whole().isLeaf() && b_.whole().isLeaf()) return isBeyondIt({a_.root, b_.root});
  for (begin(pair, limit); !queue_.empty() && !(lowestBound() > limit);) {
    const VolumePair volumes = queue_.pop();
    if (!areLeaves(volumes))
      open(volumes, pair.a_T_b, limit);
    else if (!isBeyondIt({volumes.a, volumes.b}))
      return false;
  }
  return true;
}

narrowphase::SignedDistance PieceSearch::distanceInBodyA(const LeafPair& leaves, const PlacedPair& pair,
                                                         const narrowphase::Options& options, Memory start_from) {
  narrowphase::WarmStart cold;
  const Leaf a(a_, leaves.a), b(b_, leaves.b);
  narrowphase::WarmStart& start = start_from == Memory::None ? cold : warm_starts_.of(a.number, b.number);
  return padded(PlacedRobot::distanceInBodyA(a, b, pair.a_T_b, options, start), pair.padding);
}

/// Fills the queue with the volumes to visit. The bound of the pair is not used, so that among equally close pieces the
/// same ones are found, whatever is known of the pair.
void PieceSearch::begin(const PlacedPair& pair, double limit) {
  queue_.clear();
  pushed_ = 0;
  padding_ = pair.padding;
  left_out_ = kInfinity;
  const double reach = pair.a_T_b.translation.norm() + a_.whole().bounds.reach + b_.whole().bounds.reach;
  uses_bounds_ = skipping_ == Skipping::On && reach < LeafGaps::kMostReach;
  open({-kInfinity, 0, a_.root, b_.root}, pair.a_T_b, limit);
}

/// Replaces a pair of volumes by the pairs with the parts of the larger one. If both have few leaves, by all pairs of
/// these.
void PieceSearch::open(const VolumePair& whole, const RelativePose& a_T_b, double limit) {
  const WideVolume &a = a_.wide(whole.a), &b = b_.wide(whole.b);
  const bool is_a_larger = a_[whole.a].bounds.radius >= b_[whole.b].bounds.radius;
  if (a.hasLeaves() && b.hasLeaves())
    pushPairs(a.parts(), b.parts(), whole, a_T_b, limit);
  else if (b.hasLeaves() || (!a.hasLeaves() && is_a_larger))
    pushPairs(a.parts(), b.whole(), whole, a_T_b, limit);
  else
    pushPairs(a.whole(), b.parts(), whole, a_T_b, limit);
}

/// Puts the pairs of two volumes' parts into the queue. Pairs beyond the limit [m] are left out.
void PieceSearch::pushPairs(const LeafBoxes& a, const LeafBoxes& b, const VolumePair& whole, const RelativePose& a_T_b,
                            double limit) {
  const std::int64_t first = pushed_;
  pushed_ += static_cast<std::int64_t>(a.leaves().size() * b.leaves().size());
  if (!uses_bounds_) {
    std::int64_t number = first;
    for (const int part_a : a.leaves())
      for (const int part_b : b.leaves()) queue_.push({-kInfinity, number++, part_a, part_b});
    return;
  }
  // A bound of a whole also holds for its parts.
  for (const LeafGaps::Gap& gap : gaps_.between(a, b, a_T_b, padding_, limit))
    queue_.push({std::max(whole.lower_bound, gap.lower_bound), first + gap.number, gap.a, gap.b});
  left_out_ = std::min(left_out_, std::max(whole.lower_bound, gaps_.smallestOfOthers()));
}

}  // namespace proximity_server::scene
