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

PairBounds::PairBounds(const SceneModel& model, UncertainPlaces& places)
    : pair_(model, places, work_),
      pieces_(pair_, work_),
      reached_(places, pair_),
      divided_(places, pair_, pieces_, reached_, work_) {}

void PairBounds::limit(const GuaranteeLimits& limits) {
  work_.begin(limits);
  bounded_.clear();
}

void PairBounds::forget() {
  pieces_.last_deciding = {};
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
  work_.beginPair();
  work_.count(kStepsOfPair);
  pieces_.deciding.leaves = {};
  divided_.forgetNearest();
  if (!pair_.begin(pair.asked)) return std::numeric_limits<double>::quiet_NaN();
  const double loss = lossOf(pair_.travel(), known.lower_bound);
  if (loss == 0.0) return known.lower_bound;
  const double cheap = known.lower_bound - loss;
  if (cheap >= enough) return cheap;
  // If the surfaces may meet, one shape may also lie inside the other: then interiors are bounded, too.
  constexpr double kApart = 1e-9;  // [m]
  const double apart = pair_.hasInterior() ? kApart - pair_.surfaces() : -kInfinity;
  enough = std::min(known.lower_bound, std::max(enough, apart));
  constexpr double kNegligible = 3e-4;  // [m]
  const Vector3d normal = pair_.is_exchanged ? Vector3d(-known.normal) : known.normal;
  double bound = pieces_.ofAllPieces({normal, known.lower_bound, loss, cheap, kNegligible}, enough);
  if (pieces_.deciding.leaves.areLeaves()) pieces_.last_deciding = {pair.asked, pieces_.deciding.leaves};
  bound = divided_.improved(bound, known.lower_bound, enough);
  if (bound < apart) bound = std::min(bound, pieces_.ofInteriors(normal));
  return std::max(cheap, bound);
}

const ReachedState* PairBounds::reached(const PairProximity& pair, double threshold) {
  if (pair.result.status == narrowphase::Status::Unknown || !(boundOf(pair, kInfinity) < threshold)) return nullptr;
  return reached_.find(threshold, pair.result.upper_bound, divided_.nearestState(), pieces_.deciding);
}

}  // namespace proximity_server::scene
