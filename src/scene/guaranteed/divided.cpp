#include "scene/guaranteed/divided.h"

#include "scene/model/numbers.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace proximity_server::scene {

using Eigen::Isometry3d;
using Eigen::Vector3d;
using narrowphase::SignedDistance;

DividedBound::DividedBound(const UncertainPlaces& places, DisplacedPair& pair, PiecesBound& pieces,
                           ReachedStates& reached, LimitedWork& work)
    : places_(places),
      pair_(pair),
      pieces_(pieces),
      reached_(reached),
      work_(work),
      column_of_(places.robot().joints.size(), kNoColumn) {}

/// Returns false if no joint is between the two, or if one of them may be anywhere.
bool DividedBound::findLeadersBetween() {
  for (const int joint : leaders_between_) column_of_[joint] = kNoColumn;
  leaders_between_.clear();
  levers_.clear();
  for (const DisplacedShape* side : {&pair_.a, &pair_.b}) {
    const Bounds& bounds = side->part.whole().bounds;
    for (const Displacement& own : side->chain) {
      const Joint::Mimic* leader = places_.leaderOf(own);
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
double DividedBound::displaceSide(const DisplacedShape& whole, const Box& box, DisplacedShape& side) const {
  const Bounds& bounds = whole.part.whole().bounds;
  Isometry3d motion = Isometry3d::Identity();
  double rounding = 0.0;
  for (std::size_t i = whole.chain.size(); i-- > 0;) {  // that next to the common body first
    const Displacement& present = whole.chain[i];
    Displacement& own = side.chain[i];
    own.origin = motion * present.origin;
    own.axis = motion.linear() * present.axis;
    const Joint::Mimic* leader = places_.leaderOf(present);
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

/// The joint whose interval moves the points of the two the most.
std::size_t DividedBound::widestOf(const Box& box) const {
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
std::pair<DividedBound::Box, DividedBound::Box> DividedBound::halve(const Box& box) {
  const std::size_t widest = widestOf(box), count = leaders_between_.size();
  Box high = box;
  high.intervals = intervals_.size();
  for (std::size_t i = 0; i < count; ++i) intervals_.push_back(std::array<double, 2>(intervals_[box.intervals + i]));
  auto& [lower, upper] = intervals_[box.intervals + widest];
  upper = intervals_[high.intervals + widest][0] = 0.5 * (lower + upper);
  return {box, high};
}

/// Bounds the pair in a part, along a direction of its own. `nearest` [m] is lowered to the distance in its middle.
void DividedBound::boundPart(Box& box, double enough, double& nearest) {
  const double rounding = displaceSide(whole_a_, box, pair_.a) + displaceSide(whole_b_, box, pair_.b);
  pair_.place();
  const SignedDistance middle = pair_.measured(box.leaves, pair_.a_T_b, kInfinity);
  if (middle.upper_bound - pair_.swelling < nearest) {
    nearest = middle.upper_bound - pair_.swelling;
    nearest_state_.assign(places_.leaders().size(), 0.0);
    for (std::size_t column = 0; column < leaders_between_.size(); ++column) {
      const auto [lower, upper] = intervals_[box.intervals + column];
      nearest_state_[leaders_between_[column]] = 0.5 * (lower + upper);
    }
  }
  pieces_.likely = {pair_.asked, box.leaves};
  const Vector3d normal = pair_.a.pose.linear() * middle.normal;
  const double of_pieces =
      pieces_.ofAllPieces({normal, middle.lower_bound, pair_.travel(), box.bound, kNegligible}, enough + rounding);
  box.bound = std::max(box.bound, of_pieces - rounding);
  if (pieces_.deciding.leaves.areLeaves()) box.leaves = pieces_.deciding.leaves;
}

double DividedBound::improved(double whole, double lower_bound, double enough) {
  constexpr double kMuch = 1.5;
  const double present = lower_bound - pair_.swelling;
  nearest_state_.clear();
  if (whole >= enough || present <= 0.0 || present - whole <= kNegligible || most_parts_ == 0) return whole;
  if (work_.isOver()) return whole;
  if (!pieces_.deciding.leaves.areLeaves() || pair_.b.part.isUnbounded() || !findLeadersBetween()) return whole;
  DisplacedPair::Where where = pieces_.deciding;
  double nearest = where.normal.allFinite() ? reached_.bringTogether(where) : present;
  const auto isGood = [&](const Box& box) {
    return box.bound >= enough || nearest <= 0.0 || present - box.bound <= kMuch * (present - nearest) + kNegligible;
  };
  const auto isAfter = [](const Box& one, const Box& other) { return one.bound > other.bound; };
  // At once, so that a cycle of the monitor takes no memory where the time of the earlier ones was over.
  const auto most_boxes = static_cast<std::size_t>(std::min(most_parts_, kUsualParts) / 2 + 1);
  boxes_.reserve(most_boxes);
  intervals_.reserve(most_boxes * leaders_between_.size());
  intervals_.clear();
  for (const int joint : leaders_between_) {
    const double most = places_.uncertainty().positions[joint];
    intervals_.push_back({-most, most});
  }
  boxes_.assign(1, Box{0, whole, pieces_.deciding.leaves});
  if (isGood(boxes_.front())) return whole;
  const DisplacedPair::Where deciding = pieces_.deciding;
  whole_a_ = pair_.a;
  whole_b_ = pair_.b;
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
  pair_.a = whole_a_;
  pair_.b = whole_b_;
  pair_.place();
  pieces_.deciding = deciding;
  pieces_.likely = {pair_.asked, deciding.leaves};
  return boxes_.front().bound;
}

}  // namespace proximity_server::scene
