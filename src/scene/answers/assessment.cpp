#include "proximity_server/scene/answers/assessment.h"

#include "proximity_server/scene/derivative/derivatives.h"
#include "proximity_server/scene/model/posed_position.h"
#include "scene/model/numbers.h"

#include <algorithm>
#include <cstddef>

namespace proximity_server::scene {
namespace {

/// Assesses one state.
class Assessor {
 public:
  Assessor(Scene& scene, const State& state, const AssessmentQuestion& asked, Assessment& found)
      : scene_(scene), state_(state), asked_(asked), found_(found), unlimited_(asked.question) {
    unlimited_.threshold = Question().threshold;
  }

  void assess() {
    const AssessedPair none;
    for (AssessedPair* pair :
         {&found_.minimum, &found_.deciding, &found_.of_links.closest, &found_.with_object.closest})
      pair->pair = none.pair;
    found_.level.reset();
    found_.reached = false;
    found_.ahead = nullptr;
    findBroken();
    list();
    const PairProximity* minimum =
        found_.listed.empty() ? scene_.minimum(state_, scene_.candidates(), unlimited_) : &found_.listed.front();
    found_.counts = scene_.counts();
    if (minimum && found_.counts.unknown == 0 && asked_.is_bounded)
      decide(PairProximity(*minimum));
    else
      found_.of_links.level = found_.with_object.level = std::nullopt;
    if (asked_.lookahead && found_.level)
      found_.ahead = &asked_.lookahead->find(scene_.candidates(), asked_.thresholds.stop, asked_.stated);
  }

 private:
  void findBroken() {
    found_.broken.reset();
    double largest = 1.0;
    for (const JointInequality& inequality : state_.robot().inequalities) {
      const auto excess = excessAt(state_.robot(), inequality, state_.poses(), asked_.stated);
      if (!excess || !(*excess / inequality.tolerance() > largest)) continue;
      largest = *excess / inequality.tolerance();
      found_.broken = BrokenInequality{&inequality, *excess};
    }
  }

  /// Lists at least one pair, as it is the minimum.
  void list() {
    const auto most = static_cast<std::size_t>(std::max(1, asked_.most_listed));
    found_.listed.reserve(most);
    found_.of_listed.resize(std::max(most, found_.of_listed.size()));
    for (PairFacts& facts : found_.of_listed) reserve(facts);
    const PairsBelow below = scene_.closestBelow(state_, scene_.candidates(), static_cast<int>(most), asked_.question);
    found_.below = below.count;
    found_.listed = below.closest;
    const std::size_t assessed = std::min(found_.listed.size(), static_cast<std::size_t>(asked_.most_listed));
    for (std::size_t i = 0; i < assessed; ++i) assessPair(found_.listed[i], found_.of_listed[i]);
  }

  void reserve(PairFacts& facts) const {
    if (asked_.wants_gradients) facts.gradient.reserve(static_cast<std::size_t>(state_.degreesOfFreedom().size()));
  }

  void assessPair(const PairProximity& pair, PairFacts& facts) {
    facts.guaranteed = guaranteedOf(pair);
    facts.level = levelOf(pair, facts.guaranteed, asked_.thresholds).level;
    facts.gradient.clear();
    if (asked_.wants_gradients) gradient(state_, pair, facts.gradient);
  }

  void assessPair(const PairProximity& pair, AssessedPair& assessed) {
    assessed.pair = pair;
    reserve(assessed);
    assessPair(pair, static_cast<PairFacts&>(assessed));
  }

  /// [m] It is tight only near the thresholds.
  double guaranteedOf(const PairProximity& pair) {
    if (!asked_.is_bounded) return kNaN;
    if (!asked_.guaranteed) return pair.result.lower_bound;
    return asked_.guaranteed->of(state_, pair, asked_.thresholds.warn.of(pair.asked) + asked_.hysteresis);
  }

  /// Finds the level. All pairs are known, and `minimum` is the closest one.
  void decide(const PairProximity& minimum) {
    assessPair(minimum, found_.minimum);
    const std::optional<DecidingPair> of_links = decideKind(PairKind::OfLinks, minimum, found_.of_links);
    const std::optional<DecidingPair> with_object = decideKind(PairKind::WithObject, minimum, found_.with_object);
    const DecidingPair& deciding =
        !with_object || (of_links && outranks(*of_links, *with_object)) ? *of_links : *with_object;
    found_.level = deciding.level;
    found_.deciding.pair = deciding.pair;
    found_.deciding.guaranteed = deciding.guaranteed;
    found_.deciding.level = deciding.level.level;
    found_.deciding.gradient.clear();
    if (asked_.wants_gradients || deciding.level.level != ClearanceLevel::Clear)
      gradient(state_, deciding.pair, found_.deciding.gradient);
    found_.reached = isReached(deciding);
  }

  /// Finds the closest pair of a kind, the level of the kind, and the pair that sets it; nullopt if no pair of this
  /// kind is checked.
  std::optional<DecidingPair> decideKind(PairKind kind, const PairProximity& minimum, Assessment::OfKind& found) {
    const LevelBefore before{found.level, asked_.hysteresis};
    const std::optional<PairProximity> closest = closestOf(kind, minimum);
    found.level = ClearanceLevel::Clear;
    if (!closest) return std::nullopt;
    assessPair(*closest, found.closest);
    const ListedPairs listed{found_.listed.data(), found_.listed.data() + found_.listed.size(), unlistedFrom()};
    const DecidingPair deciding = decidingPair(scene_, state_, Pairs(scene_.candidates(), kind), *closest,
                                               {asked_.thresholds, before, unlimited_, asked_.guaranteed, listed});
    found.level = deciding.level.level;
    return deciding;
  }

  std::optional<PairProximity> closestOf(PairKind kind, const PairProximity& minimum) {
    const bool with_object = kind == PairKind::WithObject;
    if (minimum.asked.areLinks() != with_object) return minimum;
    const bool is_empty = with_object ? state_.objects()->pairCount() == 0 : scene_.candidates().empty();
    const PairProximity* found =
        is_empty ? nullptr : scene_.minimum(state_, Pairs(scene_.candidates(), kind), unlimited_);
    if (!found) return std::nullopt;
    return *found;
  }

  /// [m] No pair is closer that is not listed.
  double unlistedFrom() const {
    if (static_cast<std::size_t>(found_.below) == found_.listed.size()) return asked_.question.threshold;
    const narrowphase::SignedDistance& last = found_.listed.back().result;
    return std::min(last.distance, last.lower_bound) - asked_.question.tolerance;
  }

  /// Returns whether the level of all pairs is set by `p`, and not by `q`. Each of the two sets the level of its kind of
  /// pairs.
  static bool outranks(const DecidingPair& p, const DecidingPair& q) {
    const auto excess = [](const DecidingPair& deciding) { return deciding.guaranteed - deciding.level.threshold; };
    return p.level.level != q.level.level ? p.level.level > q.level.level : excess(p) <= excess(q);
  }

  bool isReached(const DecidingPair& deciding) {
    if (deciding.level.level != ClearanceLevel::Warn && deciding.level.level != ClearanceLevel::Stop) return false;
    if (deciding.pair.result.upper_bound <= deciding.level.threshold) return true;
    return asked_.guaranteed && asked_.guaranteed->reached(state_, deciding.pair, deciding.level.threshold);
  }

  Scene& scene_;
  const State& state_;
  const AssessmentQuestion& asked_;
  Assessment& found_;
  Question unlimited_;  ///< of all pairs, however far apart
};

}  // namespace

void assess(Scene& scene, const State& state, const AssessmentQuestion& asked, Assessment& assessment) {
  Assessor(scene, state, asked, assessment).assess();
}

}  // namespace proximity_server::scene
