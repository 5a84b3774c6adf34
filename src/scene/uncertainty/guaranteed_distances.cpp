#include "proximity_server/scene/uncertainty/guaranteed_distances.h"

#include "scene/filter/given_model.h"
#include "scene/model/numbers.h"
#include "scene/uncertainty/pair_bounds.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

namespace proximity_server::scene {

GuaranteedDistances::GuaranteedDistances(const std::shared_ptr<const SceneModel>& model)
    : bounds_((given(model), std::make_unique<PairBounds>(model))) {}
GuaranteedDistances::~GuaranteedDistances() = default;
GuaranteedDistances::GuaranteedDistances(GuaranteedDistances&&) noexcept = default;
GuaranteedDistances& GuaranteedDistances::operator=(GuaranteedDistances&&) noexcept = default;

void GuaranteedDistances::assume(const Uncertainty& uncertainty) { bounds_->assume(uncertainty); }
const Uncertainty& GuaranteedDistances::uncertainty() const { return bounds_->uncertainty(); }

void GuaranteedDistances::use(std::shared_ptr<const Objects> objects) { bounds_->use(std::move(objects)); }
void GuaranteedDistances::use(std::shared_ptr<const Objects> objects, ObjectCarriers carriers) {
  bounds_->use(std::move(objects), std::move(carriers));
}

void GuaranteedDistances::update(const BodyPoses& poses) { bounds_->update(poses); }
void GuaranteedDistances::update(const BodyPoses& poses, const FramePoses& frames) { bounds_->update(poses, frames); }

double GuaranteedDistances::of(const PairProximity& pair, double enough) { return bounds_->of(pair, enough); }

const ReachedState* GuaranteedDistances::reached(const PairProximity& pair, double threshold) {
  return bounds_->reached(pair, threshold);
}

double GuaranteedDistances::largestLoss() { return bounds_->largestLoss({}); }
double GuaranteedDistances::largestLoss(const std::vector<double>& travel) { return bounds_->largestLoss(travel); }

GuaranteedMinimum GuaranteedDistances::find(Scene& scene, const PairDistances& thresholds) {
  return find(scene, scene.candidates(), thresholds);
}

GuaranteedMinimum GuaranteedDistances::find(Scene& scene, const Pairs& pairs, const PairDistances& thresholds,
                                            Question question) {
  if (&scene.model() != &bounds_->joints().model()) throw std::invalid_argument("the scene is of another robot");
  if (scene.objects() != bounds_->joints().objects()) throw std::invalid_argument("the scene has other objects");
  if (!thresholds.areFinite()) throw std::invalid_argument("the thresholds must be finite");
  question.thresholds = &thresholds;
  question.threshold = kInfinity;
  const double loss = largestLoss();
  const double lowest_threshold = thresholds.range(pairs.areCandidates() ? pairs.kind() : PairKind::Any).smallest;
  for (;; closest_ *= 2) {
    const std::vector<PairProximity>& closest = scene.closest(pairs, closest_, question);
    GuaranteedMinimum minimum;
    minimum.unknown = scene.counts().unknown;
    // True if pairs with this lower bound cannot have a smaller result. Where surfaces may meet, interiors count.
    const auto isSettled = [&](double excess, double threshold) {
      return excess - loss >= minimum.excess && (!bounds_->haveInteriors() || excess + threshold - loss > 0.0);
    };
    double last = -kInfinity;
    int needed = 0;
    for (const PairProximity& pair : closest) {
      const double threshold = thresholds.of(pair.asked);
      last = std::min(pair.result.distance, pair.result.lower_bound) - threshold;
      if (isSettled(last, threshold)) continue;
      ++needed;
      const double guaranteed = of(pair, minimum.excess + threshold);
      if (std::isnan(guaranteed)) {
        ++minimum.unknown;
      } else if (guaranteed - threshold < minimum.excess) {
        minimum.pair = pair;
        minimum.guaranteed = guaranteed;
        minimum.excess = guaranteed - threshold;
      }
    }
    const bool are_all = static_cast<int>(closest.size()) < closest_;
    if (are_all || isSettled(last - question.tolerance, lowest_threshold)) {
      closest_ = std::max(2, needed + 1);
      return minimum;
    }
  }
}

}  // namespace proximity_server::scene
