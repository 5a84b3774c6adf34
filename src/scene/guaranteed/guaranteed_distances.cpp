#include "proximity_server/scene/guaranteed/guaranteed_distances.h"

#include "scene/guaranteed/largest_loss.h"
#include "scene/guaranteed/pair_bounds.h"
#include "scene/model/numbers.h"
#include "scene/scene_model/given_model.h"
#include "scene/uncertainty/uncertain_places.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <utility>

namespace proximity_server::scene {
namespace {

constexpr int kFewest = 2;                         // pairs that find() asks for
constexpr std::int64_t kStepsOfListedPair = 2500;  // of a pair that the scene lists

PairKind kindOf(const Pairs& pairs) { return pairs.areCandidates() ? pairs.kind() : PairKind::Any; }

bool isOf(PairKind kind, const ShapeRefPair& pair) {
  return kind == PairKind::Any || pair.areLinks() == (kind == PairKind::OfLinks);
}

/// Returns whether a search ends here, because its work is over. Then the minimum is lowered to a bound of all other
/// pairs. If there is none, as the largest loss is infinite, the search goes on: each pair has a bound of its own.
bool ends(LimitedWork& work, double excess_of_others, GuaranteedMinimum& minimum) {
  if (minimum.excess == kInfinity || excess_of_others == -kInfinity || !work.isSpent()) return false;
  if (excess_of_others < minimum.excess) {
    minimum.guaranteed -= minimum.excess - excess_of_others;
    minimum.excess = excess_of_others;
  }
  return true;
}

void requireFinite(const PairDistances& thresholds) {
  if (!thresholds.areFinite()) throw std::invalid_argument("the thresholds must be finite");
}

}  // namespace

struct GuaranteedDistances::Parts {
  explicit Parts(const std::shared_ptr<const SceneModel>& model)
      : places(model), bounds(*model, places), largest_loss(places) {}

  UncertainPlaces places;
  PairBounds bounds;
  LargestLoss largest_loss;
  std::optional<double> loss;  ///< [m] the largest at the present state
};

GuaranteedDistances::GuaranteedDistances(const std::shared_ptr<const SceneModel>& model)
    : parts_((given(model), std::make_unique<Parts>(model))) {}
GuaranteedDistances::~GuaranteedDistances() = default;
GuaranteedDistances::GuaranteedDistances(GuaranteedDistances&&) noexcept = default;
GuaranteedDistances& GuaranteedDistances::operator=(GuaranteedDistances&&) noexcept = default;

void GuaranteedDistances::assume(const Uncertainty& uncertainty) { parts_->places.assume(uncertainty); }
void GuaranteedDistances::divideInto(int most_parts) { parts_->bounds.divideInto(most_parts); }
const Uncertainty& GuaranteedDistances::uncertainty() const { return parts_->places.uncertainty(); }

void GuaranteedDistances::limit(const GuaranteeLimits& limits) { parts_->bounds.limit(limits); }
std::int64_t GuaranteedDistances::steps() const { return parts_->bounds.work().steps(); }
GuaranteeEnd GuaranteedDistances::end() const { return parts_->bounds.work().end(); }

void GuaranteedDistances::see(const State& state) {
  const UncertainPlaces::News news = parts_->places.see(state);
  if (news == UncertainPlaces::News::None) return;
  if (news == UncertainPlaces::News::Objects) parts_->bounds.forget();
  parts_->bounds.forgetState();
  parts_->loss.reset();
}

double GuaranteedDistances::of(const State& state, const PairProximity& pair, double enough) {
  see(state);
  return parts_->bounds.of(pair, enough);
}

const ReachedState* GuaranteedDistances::reached(const State& state, const PairProximity& pair, double threshold) {
  see(state);
  return parts_->bounds.reached(pair, threshold);
}

void GuaranteedDistances::forget() {
  parts_->bounds.forget();
  found_ = {};
  closest_ = kFewest;
}

double GuaranteedDistances::largestLoss(const State& state) {
  see(state);
  if (!parts_->loss) parts_->loss = parts_->largest_loss.of({});
  return *parts_->loss;
}

double GuaranteedDistances::largestLoss(const State& state, const std::vector<double>& travel) {
  see(state);
  return parts_->largest_loss.of(travel);
}

/// [m] Two free objects of a list may lose more than largestLoss() if they are not checked.
double GuaranteedDistances::largestLossOf(const State& state, const Pairs& pairs) {
  return pairs.areCandidates() ? largestLoss(state) : kInfinity;
}

/// Lowers the minimum to the minimum of the listed pairs of this kind, none of which loses more than `loss` [m].
/// Returns whether no other pair can be below it. `others` of the list is here a distance minus a threshold.
bool GuaranteedDistances::settle(const State& state, const ListedPairs& listed, PairKind kind,
                                 const PairDistances& thresholds, double enough, double loss,
                                 GuaranteedMinimum& minimum) {
  int needed = 0;
  const auto consider = [&](const PairProximity& pair) {
    const double threshold = thresholds.of(pair.asked);
    const double excess = std::min(pair.result.distance, pair.result.lower_bound) - threshold;
    if (!isOf(kind, pair.asked) || excess - loss >= minimum.excess) return;
    ++needed;
    const double guaranteed = of(state, pair, std::min(minimum.excess, enough) + threshold);
    if (std::isnan(guaranteed)) {
      ++minimum.unknown;
    } else if (guaranteed - threshold < minimum.excess) {
      minimum.pair = pair;
      minimum.guaranteed = guaranteed;
      minimum.excess = guaranteed - threshold;
    }
  };
  // The pair of the last minimum is likely to be the pair of this one, and then excludes most others by cheap bounds.
  ShapeRefPair& found = found_[static_cast<std::size_t>(kind)];
  const PairProximity* const last =
      std::find_if(listed.begin, listed.end, [&](const PairProximity& pair) { return pair.asked.isSameAs(found); });
  if (last != listed.end) consider(*last);
  for (const PairProximity* pair = listed.begin; pair != listed.end; ++pair)
    if (pair != last) consider(*pair);
  const bool are_all = listed.others == kInfinity;
  if (!are_all && !(listed.others - loss >= minimum.excess)) return false;
  found = minimum.pair.asked;
  closest_ = std::max(kFewest, needed + 1);
  return true;
}

GuaranteedMinimum GuaranteedDistances::find(Scene& scene, const State& state, const PairDistances& thresholds) {
  return find(scene, state, scene.candidates(), thresholds);
}

GuaranteedMinimum GuaranteedDistances::find(Scene& scene, const State& state, const Pairs& pairs,
                                            const PairDistances& thresholds, Question question, double enough) {
  requireFinite(thresholds);
  question.thresholds = &thresholds;
  question.threshold = kInfinity;
  const double loss = largestLossOf(state, pairs);
  for (;; closest_ *= 2) {
    const std::vector<PairProximity>& closest = scene.closest(state, pairs, closest_, question);
    GuaranteedMinimum minimum;
    minimum.unknown = scene.counts().unknown;
    double others = kInfinity;
    if (static_cast<int>(closest.size()) == closest_) {
      const PairProximity& last = closest.back();
      others = std::min(last.result.distance, last.result.lower_bound) - thresholds.of(last.asked) - question.tolerance;
    }
    const ListedPairs listed{closest.data(), closest.data() + closest.size(), others};
    if (settle(state, listed, kindOf(pairs), thresholds, enough, loss, minimum)) return minimum;
    parts_->bounds.work().count(kStepsOfListedPair * static_cast<std::int64_t>(closest.size()));
    if (ends(parts_->bounds.work(), others - loss, minimum)) return minimum;
  }
}

GuaranteedMinimum GuaranteedDistances::find(Scene& scene, const State& state, const Pairs& pairs,
                                            const PairDistances& thresholds, const ListedPairs& listed,
                                            const Question& question, double enough) {
  requireFinite(thresholds);
  GuaranteedMinimum minimum;
  const ListedPairs with_excess{listed.begin, listed.end, listed.others - thresholds.range(kindOf(pairs)).largest};
  const double loss = largestLossOf(state, pairs);
  if (settle(state, with_excess, kindOf(pairs), thresholds, enough, loss, minimum)) return minimum;
  if (ends(parts_->bounds.work(), with_excess.others - loss, minimum)) return minimum;
  return find(scene, state, pairs, thresholds, question, enough);
}

GuaranteedMinimum GuaranteedDistances::find(const State& state, const ListedPairs& listed,
                                            const PairDistances& thresholds) {
  GuaranteedMinimum minimum;
  const ListedPairs with_excess{listed.begin, listed.end, listed.others - thresholds.range(PairKind::Any).largest};
  if (!settle(state, with_excess, PairKind::Any, thresholds, kInfinity, largestLoss(state), minimum))
    minimum.unknown = 1;
  return minimum;
}

}  // namespace proximity_server::scene
