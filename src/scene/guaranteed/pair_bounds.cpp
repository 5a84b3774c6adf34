#include "scene/guaranteed/pair_bounds.h"

#include "scene/model/numbers.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

namespace proximity_server::scene {

using Eigen::Vector3d;
using narrowphase::SignedDistance;

namespace {

constexpr double kEpsilon = std::numeric_limits<double>::epsilon();

constexpr std::int64_t kStepsOfPair = 300;  // of LimitedWork, see displaced_pair.cpp

/// [m] What a lower bound loses if the points of the two come closer by `way`; 0 if nothing is uncertain.
double lossOf(double way, double lower_bound) {
  return way == 0.0 ? 0.0 : (1.0 + 4.0 * kEpsilon) * way + kEpsilon * std::abs(lower_bound);
}

}  // namespace

// --- the ways of shapes

void ShapeWays::forget() {
  const State& state = places_.state();
  ways_.resize(static_cast<std::size_t>(state.volumes()->rootCount() + state.objects()->numberLimit()));
  for (Ways& ways : ways_) {
    ways.is_begun = false;
    ways.relative_to.reserve(places_.robot().bodies.size() + 1);
  }
}

/// Adds the ways by some displacements [m].
void ShapeWays::Ways::add(const std::vector<Displacement>& displacements, double& sum) const {
  for (const Displacement& own : displacements) {
    if (!own.turns()) {
      sum += own.width;
      continue;
    }
    Vector3d lever = centre - own.origin;
    if (own.kind == Displacement::Kind::Turn) lever = own.axis.cross(lever);
    sum += own.width * ((1.0 + kPoseRounding) * (lever.norm() + radius) + rounding);
  }
}

/// Begins with the ways of a shape relative to its body.
void ShapeWays::begin(const ShapeRef& ref, Ways& ways) {
  double sum = places_.place(ref, 0, seen_) ? 0.0 : std::numeric_limits<double>::quiet_NaN();
  const Bounds& bounds = seen_.part.whole().bounds;
  ways.is_begun = true;
  ways.centre = seen_.pose * bounds.centre;
  ways.radius = bounds.radius;
  ways.rounding = kPoseRounding * (bounds.reach + seen_.pose.translation().norm());
  ways.body = places_.state().bodyOf(ref);
  ways.add(seen_.chain, sum);
  ways.relative_to.assign(1, sum);
}

/// [m] An upper bound of the way of a shape's points relative to the body that is so many steps before its own one.
double ShapeWays::wayOf(const ShapeRef& ref, std::size_t steps) {
  Ways& ways = ways_[places_.state().volumes()->of(ref)];
  if (!ways.is_begun) begin(ref, ways);
  while (ways.relative_to.size() <= steps) {
    const UncertainPlaces::Place& place = places_.placeOf(ways.body);
    double sum = place.is_known ? ways.relative_to.back() : std::numeric_limits<double>::quiet_NaN();
    ways.add(place.displacements, sum);
    ways.relative_to.push_back(sum);
    ways.body = places_.robot().bodies[ways.body].parent;
  }
  return ways.relative_to[steps];
}

double ShapeWays::ofPair(const ShapeRefPair& pair) {
  if (places_.isUnbounded(pair.a) || places_.isUnbounded(pair.b)) return kInfinity;
  const RobotModel& robot = places_.robot();
  int a = places_.state().bodyOf(pair.a), b = places_.state().bodyOf(pair.b);
  std::size_t steps_a = 0, steps_b = 0;
  while (a != b) {
    int& later = a > b ? a : b;  // parents come first
    ++(a > b ? steps_a : steps_b);
    later = robot.bodies[later].parent;
  }
  const double way = wayOf(pair.a, steps_a) + wayOf(pair.b, steps_b);
  const double rounding = static_cast<double>(4 * robot.bodies.size() + 8) * kEpsilon;  // of the sums
  return (1.0 + rounding) * way + places_.swellingOf(pair.a) + places_.swellingOf(pair.b);
}

// --- pairs

PairBounds::PairBounds(const SceneModel& model, UncertainPlaces& places)
    : places_(places),
      pair_(model, places, work_),
      pieces_(pair_, work_),
      reached_(places, pair_),
      divided_(places, pair_, pieces_, reached_, work_),
      ways_(places) {}

void PairBounds::limit(const GuaranteeLimits& limits) {
  work_.begin(limits);
  bounded_.clear();
}

void PairBounds::forgetState() {
  ways_.forget();
  bounded_.clear();
}

void PairBounds::forget() {
  pieces_.likely = {};
  bounded_.clear();
}

double PairBounds::of(const PairProximity& pair, double enough) {
  if (pair.result.status == narrowphase::Status::Unknown) return std::numeric_limits<double>::quiet_NaN();
  const auto before = std::find_if(bounded_.begin(), bounded_.end(),
                                   [&](const Bounded& bounded) { return bounded.pair.isSameAs(pair.asked); });
  if (before == bounded_.end()) return bounded_.emplace_back(Bounded{pair.asked, enough, boundOf(pair, enough)}).bound;
  if (before->enough < enough && before->bound < enough) {
    before->enough = enough;
    before->bound = std::max(before->bound, boundOf(pair, enough));
  }
  return std::min(before->bound, pair.result.lower_bound);
}

double PairBounds::boundOf(const PairProximity& pair, double enough) {
  const SignedDistance& known = pair.result;
  if (enough < known.lower_bound) {
    const double quick = known.lower_bound - lossOf(ways_.ofPair(pair.asked), known.lower_bound);
    if (quick >= enough) return quick;
  }
  work_.beginPair();
  work_.count(kStepsOfPair);
  pieces_.deciding.leaves = {};
  divided_.forgetNearest();
  if (!pair_.begin(pair.asked)) return std::numeric_limits<double>::quiet_NaN();
  const double loss = lossOf(pair_.travel(), known.lower_bound);
  if (loss == 0.0) return known.lower_bound;
  const double cheap = known.lower_bound - loss;
  if (cheap >= enough) return cheap;
  // Where surfaces may meet, one shape may also be inside of the other.
  constexpr double kApart = 1e-9;  // [m]
  const double apart = pair_.hasInterior() ? kApart - pair_.surfaces() : -kInfinity;
  enough = std::min(known.lower_bound, std::max(enough, apart));
  constexpr double kLittle = 3e-4;  // [m]
  const Vector3d normal = pair_.is_exchanged ? Vector3d(-known.normal) : known.normal;
  double bound = pieces_.ofAllPieces({normal, known.lower_bound, loss, cheap, kLittle}, enough);
  if (pieces_.deciding.leaves.areLeaves()) pieces_.likely = {pair.asked, pieces_.deciding.leaves};
  bound = divided_.improved(bound, known.lower_bound, enough);
  if (bound < apart) bound = std::min(bound, pieces_.ofInteriors(normal));
  return std::max(cheap, bound);
}

const ReachedState* PairBounds::reached(const PairProximity& pair, double threshold) {
  if (pair.result.status == narrowphase::Status::Unknown || !(boundOf(pair, kInfinity) < threshold)) return nullptr;
  return reached_.find(threshold, pair.result.upper_bound, divided_.nearestState(), pieces_.deciding);
}

}  // namespace proximity_server::scene
