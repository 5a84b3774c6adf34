#include "scene/model/numbers.h"
#include "scene/uncertainty/pair_bounds.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace proximity_server::scene {

using Eigen::Isometry3d;
using Eigen::Vector3d;
using narrowphase::SignedDistance;

/// The joint that leads a displacement; nullptr if it is that of a frame, a base or an object.
const Joint::Mimic* PairBounds::leaderOf(const Displacement& own) const {
  const bool is_of_joint = own.kind == Displacement::Kind::Turn || own.kind == Displacement::Kind::Slide;
  return is_of_joint ? &leaders_[model_->robot.bodies[own.place].joint] : nullptr;
}

/// Returns false if no joint is between the two, or if one of them may be anywhere.
bool PairBounds::findLeadersBetween() {
  for (const int joint : leaders_between_) column_of_[joint] = kNoColumn;
  leaders_between_.clear();
  levers_.clear();
  for (const Side* side : {&a_, &b_}) {
    const Bounds& bounds = side->part.whole().bounds;
    for (const Displacement& own : side->chain) {
      const Joint::Mimic* leader = leaderOf(own);
      if (!leader) continue;
      if (!std::isfinite(own.width)) return false;
      std::size_t& column = column_of_[leader->joint];
      if (column == kNoColumn) {
        column = leaders_between_.size();
        leaders_between_.push_back(leader->joint);
        levers_.push_back(0.0);
      }
      const bool slides = own.kind == Displacement::Kind::Slide;
      const double lever =
          slides ? 1.0 : own.axis.cross(side->pose * bounds.centre - own.origin).norm() + bounds.radius;
      levers_[column] += std::abs(leader->multiplier) * lever;
    }
  }
  return !leaders_between_.empty();
}

/// Places one shape in the middle of a part, with what is left of its displacements. Returns the error of its points
/// [m]: a joint moves them by its position, which is off by half a unit in the last place, in a rotation and sums that
/// are off by less than 32 units in all.
double PairBounds::displaceSide(const Side& whole, const Box& box, Side& side) const {
  const Bounds& bounds = whole.part.whole().bounds;
  Isometry3d motion = Isometry3d::Identity();
  double rounding = 0.0;
  for (std::size_t i = whole.chain.size(); i-- > 0;) {  // that next to the common body first
    const Displacement& present = whole.chain[i];
    Displacement& own = side.chain[i];
    own.origin = motion * present.origin;
    own.axis = motion.linear() * present.axis;
    const Joint::Mimic* leader = leaderOf(present);
    if (!leader) continue;
    const auto [lower, upper] = intervals_[box.intervals + column_of_[leader->joint]];
    own.width = std::abs(leader->multiplier) * halfWidth(lower, upper);
    present.displaceAfter(motion, leader->multiplier * 0.5 * (lower + upper));
    const double lever = (whole.pose * bounds.centre - present.origin).norm() + bounds.radius;
    rounding += (1.0 + present.width) * (lever + present.origin.norm() + whole.pose.translation().norm());
  }
  side.pose = motion * whole.pose;
  return 64.0 * std::numeric_limits<double>::epsilon() * rounding;
}

/// Takes the state in the middle of a part. Returns the error of the distance in it [m].
double PairBounds::placeInMiddle(const Box& box) {
  const double rounding = displaceSide(whole_a_, box, a_) + displaceSide(whole_b_, box, b_);
  placeSides();
  loss_ = chains_[frame_].of_a.travel() + chains_[frame_].of_b.travel() + swelling_;
  return rounding;
}

/// The joint whose interval moves the points of the two the most.
std::size_t PairBounds::widestOf(const Box& box) const {
  std::size_t widest = 0;
  double most = -1.0;
  for (std::size_t column = 0; column < levers_.size(); ++column) {
    const auto [lower, upper] = intervals_[box.intervals + column];
    const double way = levers_[column] * (upper - lower);
    if (way > most) {
      most = way;
      widest = column;
    }
  }
  return widest;
}

/// Divides a part at the middle of its widest interval. Its intervals become those of the lower half.
std::pair<PairBounds::Box, PairBounds::Box> PairBounds::halve(const Box& box) {
  const std::size_t widest = widestOf(box), count = leaders_between_.size();
  Box high = box;
  high.intervals = intervals_.size();
  for (std::size_t i = 0; i < count; ++i) intervals_.push_back(std::array<double, 2>(intervals_[box.intervals + i]));
  auto& [lower, upper] = intervals_[box.intervals + widest];
  upper = intervals_[high.intervals + widest][0] = 0.5 * (lower + upper);
  return {box, high};
}

/// Bounds the pair in a part, along a direction of its own. `nearest` [m] is lowered to the distance in its middle.
void PairBounds::boundPart(Box& box, double enough, double& nearest) {
  const double rounding = placeInMiddle(box);
  const SignedDistance middle = measured(box.leaves, a_T_b_, kInfinity);
  if (middle.upper_bound - swelling_ < nearest) {
    nearest = middle.upper_bound - swelling_;
    nearest_state_.assign(leaders_.size(), 0.0);
    for (std::size_t column = 0; column < leaders_between_.size(); ++column) {
      const auto [lower, upper] = intervals_[box.intervals + column];
      nearest_state_[leaders_between_[column]] = 0.5 * (lower + upper);
    }
  }
  Known known{a_.pose.linear() * middle.normal, middle.lower_bound, box.bound, kNegligible};
  findGaps(known);
  likely_ = {asked_, box.leaves};
  deciding_.leaves = {};
  box.bound = std::max(box.bound, ofAllPieces(known, enough + rounding) - rounding);
  if (deciding_.leaves.areLeaves()) box.leaves = deciding_.leaves;
}

/// Divides the positions of the joints into parts, and bounds the pair in each of them: two states may need different
/// directions. The part with the lowest bound is divided next (Land, Doig, An Automatic Method of Solving Discrete
/// Programming Problems, 1960). This ends when the bound loses at most kMuch times as much as a state that was found, or
/// when such a state is in contact, or with the work of the pair. Returns a bound [m] of all states that is at least
/// `whole`, and not improved above `enough`.
double PairBounds::divided(double whole, const Known& known, double enough) {
  constexpr double kMuch = 1.5;
  const double present = known.lower_bound - swelling_;
  nearest_state_.clear();
  if (whole >= enough || present <= 0.0 || present - whole <= kNegligible || most_parts_ == 0) return whole;
  if (work_.isOver()) return whole;
  if (!deciding_.leaves.areLeaves() || b_.part.isUnbounded() || !findLeadersBetween()) return whole;
  Deciding where = deciding_;
  double nearest = where.normal.allFinite() ? bringTogether(where) : present;
  const auto isGood = [&](const Box& box) {
    return box.bound >= enough || nearest <= 0.0 || present - box.bound <= kMuch * (present - nearest) + kNegligible;
  };
  const auto isAfter = [](const Box& one, const Box& other) { return one.bound > other.bound; };
  intervals_.clear();
  for (const int joint : leaders_between_) {
    const double most = uncertainty_.positions[joint];
    intervals_.push_back({-most, most});
  }
  boxes_.assign(1, Box{0, whole, deciding_.leaves});
  if (isGood(boxes_.front())) return whole;
  const Deciding deciding = deciding_;
  whole_a_ = a_;
  whole_b_ = b_;
  for (int parts = 0; parts + 2 <= most_parts_ && !isGood(boxes_.front()) && !work_.isOver(); parts += 2) {
    std::pop_heap(boxes_.begin(), boxes_.end(), isAfter);
    auto [low, high] = halve(boxes_.back());
    boxes_.pop_back();
    for (Box* half : {&low, &high}) {
      boundPart(*half, enough, nearest);
      boxes_.push_back(*half);
      std::push_heap(boxes_.begin(), boxes_.end(), isAfter);
    }
  }
  a_ = whole_a_;
  b_ = whole_b_;
  placeSides();
  deciding_ = deciding;
  likely_ = {asked_, deciding.leaves};
  return boxes_.front().bound;
}

}  // namespace proximity_server::scene
