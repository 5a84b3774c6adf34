#include "scene/guaranteed/divided.h"

#include "scene/guaranteed/place_to_halve.h"
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
    : places_(places), pair_(pair), pieces_(pieces), reached_(reached), work_(work) {}

/// Takes the intervals of all joints whose positions displace the two relative to each other. Returns false if there
/// are none, or if one of them may be anywhere.
bool DividedBound::findLeadersBetween() {
  intervals_.clear();
  lever_arms_.assign(places_.leaders().size(), 0.0);
  for (const DisplacedShape* side : {&pair_.a, &pair_.b}) {
    const Bounds& bounds = side->part.whole().bounds;
    for (const Displacement& own : side->chain) {
      const Joint::Mimic* leader = places_.leaderOf(own);
      if (!leader) continue;
      if (!std::isfinite(own.width)) return false;
      const double most = places_.uncertainty().positions[leader->joint];
      if (findInterval(0, leader->joint) == intervals_.end()) intervals_.push_back({leader->joint, -most, most});
      const bool slides = own.kind == Displacement::Kind::Slide;
      const double lever_arm =
          slides ? 1.0 : own.axis.cross(side->pose * bounds.centre - own.origin).norm() + bounds.radius;
      lever_arms_[leader->joint] += std::abs(leader->multiplier) * lever_arm;
    }
  }
  leaders_between_ = intervals_.size();
  return leaders_between_ > 0;
}

/// The interval of a joint in the part whose intervals begin at a place.
std::vector<JointRange>::const_iterator DividedBound::findInterval(std::size_t begin, int joint) const {
  return std::find_if(intervals_.begin() + static_cast<std::ptrdiff_t>(begin), intervals_.end(),
                      [&](const JointRange& interval) { return interval.joint == joint; });
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
    const JointRange& left = *findInterval(box.intervals, leader->joint);
    own.width = std::abs(leader->multiplier) * halfWidth(left.lower, left.upper);
    present.displaceAfter(motion, leader->multiplier * 0.5 * (left.lower + left.upper));
    const double lever_arm = (whole.pose * bounds.centre - present.origin).norm() + bounds.radius;
    rounding += (1.0 + present.width) * (lever_arm + present.origin.norm() + whole.pose.translation().norm());
  }
  side.pose = motion * whole.pose;
  return 64.0 * std::numeric_limits<double>::epsilon() * rounding;
}

/// Divides a part where the points of the two move the most. It becomes the lower half; returns the upper one.
DividedBound::Box DividedBound::halve(const Box& box) {
  Box high = box;
  high.intervals = intervals_.size();
  for (std::size_t i = 0; i < leaders_between_; ++i) intervals_.push_back(JointRange(intervals_[box.intervals + i]));
  JointRange *lows = &intervals_[box.intervals], *highs = &intervals_[high.intervals];
  const auto way = [&](const JointRange& interval) { return lever_arms_[interval.joint] * interval.width(); };
  const int widest = std::max(0, placeToHalve(lows, leaders_between_, way));
  lows[widest].upper = highs[widest].lower = 0.5 * (lows[widest].lower + lows[widest].upper);
  return high;
}

/// Bounds the pair in a part, along a direction of its own. `nearest` [m] is lowered to the distance in its middle.
void DividedBound::boundPart(Box& box, double enough, double& nearest) {
  const double rounding = displaceSide(whole_a_, box, pair_.a) + displaceSide(whole_b_, box, pair_.b);
  pair_.place();
  const SignedDistance middle = pair_.measured(box.leaves, pair_.a_T_b, kInfinity);
  if (middle.upper_bound - pair_.swelling < nearest) {
    nearest = middle.upper_bound - pair_.swelling;
    nearest_state_.assign(lever_arms_.size(), 0.0);
    for (std::size_t i = 0; i < leaders_between_; ++i) {
      const JointRange& interval = intervals_[box.intervals + i];
      nearest_state_[interval.joint] = 0.5 * (interval.lower + interval.upper);
    }
  }
  pieces_.last_deciding = {pair_.asked, box.leaves};
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
  intervals_.reserve(most_boxes * leaders_between_);
  boxes_.assign(1, Box{0, whole, pieces_.deciding.leaves});
  if (isGood(boxes_.front())) return whole;
  const DisplacedPair::Where deciding = pieces_.deciding;
  whole_a_ = pair_.a;
  whole_b_ = pair_.b;
  for (int parts = 0; parts + 2 <= most_parts_ && !isGood(boxes_.front()) && !work_.isOver(); parts += 2) {
    std::pop_heap(boxes_.begin(), boxes_.end(), isAfter);
    Box low = boxes_.back(), high = halve(low);
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
  pieces_.last_deciding = {pair_.asked, deciding.leaves};
  return boxes_.front().bound;
}

}  // namespace proximity_server::scene
