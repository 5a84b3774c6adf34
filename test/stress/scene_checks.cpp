#include "stress/scene_checks.h"

#include "laws/question_laws.h"
#include "laws/scene_questions.h"
#include "oracle/shape_pairs.h"
#include "scene/posed_scene.h"
#include "stress/random_geometry.h"
#include "stress/scene_truth.h"
#include "stress/third_opinion.h"

#include <algorithm>
#include <cmath>

namespace proximity_server::scene {

using namespace narrowphase;
namespace {

using Eigen::Vector3d;

/// Asks one scene about one state.
class Examiner {
 public:
  Examiner(SceneCell& cell, StateTruth& truth, PosedScene& scene, SceneObservation& seen)
      : cell_(cell), truth_(truth), scene_(scene), seen_(seen), chance_(cell.chance()) {}

  /// Questions of any kind, in any order.
  void run() {
    for (int i = 0; i < 5; ++i) {
      kind_ = static_cast<PairKind>(chance_.below(5) % 3);
      question_ = someQuestion();
      thresholds_ = cell_.someThresholds();
      if (thresholds_ && question_.depth == Question::Depth::Wanted) question_.thresholds = &*thresholds_;
      switch (chance_.below(7)) {
        case 0:
          askForAll();
          break;
        case 1:
          askForPairsBelow();
          break;
        case 2:
          askForSomePairsBelow();
          break;
        case 3:
          askForTheFirst();
          break;
        case 4:
          askForOnePair();
          break;
        case 5:
          askForTheClosest(2 + chance_.below(4));
          break;
        default:
          askForTheClosest(1);
      }
      seen_.tally.add("questions");
    }
    kind_ = PairKind::Any;
    question_ = {};
    askForTheMinimum();
  }

 private:
  Pairs pairs() const { return {scene_.candidates(), kind_}; }

  Question someQuestion() {
    Question question;
    const double tolerances[] = {1e-9, 1e-9, 1e-12, 1e-6, 1e-3};
    question.tolerance = tolerances[chance_.below(5)];
    if (chance_.below(4) == 0) question.depth = Question::Depth::NotWanted;
    return question;
  }

  /// Returns a threshold near a distance of some pair, or anywhere.
  double someThreshold() {
    const double anywhere = chance_.eitherSign(chance_.decades(-6, 0)) * cell_.size();
    if (truth_.pairs().empty() || chance_.below(3) == 0) return anywhere;
    const PairTruth& pair = chance_.oneOf(truth_.pairs());
    if (!pair.is_known) return anywhere;
    return static_cast<double>(pair.distance.low) + chance_.eitherSign(chance_.decades(-17, -2)) * cell_.size();
  }

  /// [m] What the pair adds to the threshold of the question.
  double ownOf(const ShapeRefPair& pair) const { return question_.thresholds ? question_.thresholds->of(pair) : 0.0; }
  double excessOf(const PairProximity& pair) const { return pair.result.lower_bound - ownOf(pair.asked); }

  /// [m] Where a pair adds something to the threshold, sum and difference are rounded.
  double roundingOf(const ShapeRefPair& pair) const {
    return 4.0 * std::numeric_limits<double>::epsilon() * std::abs(ownOf(pair));
  }

  /// Returns whether the pair is at or below its threshold for certain.
  bool isWithin(const PairTruth& pair) const {
    const double own = ownOf(pair.pair);
    return pair.distance.high <= static_cast<long double>(question_.threshold) + own - roundingOf(pair.pair);
  }

  bool isAsked(const PairTruth& pair) const { return pair.is_known && isOfKind(pair.pair, kind_); }

  /// The upper bounds of the distances asked for, less what their pairs add to the threshold, sorted.
  std::vector<long double> sortedHighs() const {
    std::vector<long double> highs;
    for (const PairTruth& pair : truth_.pairs())
      if (isAsked(pair)) highs.push_back(pair.distance.high - ownOf(pair.pair));
    std::sort(highs.begin(), highs.end());
    return highs;
  }

  void askForAll() {
    if (chance_.below(2)) question_.threshold = someThreshold();
    const std::vector<PairProximity> found = scene_.all(pairs(), question_);
    std::size_t asked = 0;
    for (const PairTruth& pair : truth_.pairs()) asked += isOfKind(pair.pair, kind_) ? 1 : 0;
    if (found.size() != asked)
      fail("all() has " + std::to_string(found.size()) + " pairs instead of " + std::to_string(asked));
    for (const PairProximity& pair : found) checkPair("all()", pair);
    checkDistinct("all()", found);
    checkCounts();
  }

  void askForTheMinimum() {
    const PairProximity* found = scene_.minimum(pairs(), question_);
    if (!found) {
      checkNothingMissing("minimum()", {});
      return;
    }
    const PairProximity minimum = *found;
    checkClosest("minimum()", {minimum});
    checkNothingMissing("minimum()", {minimum});
    checkWitnesses(minimum);
    seen_.tally.add("minima");
    seen_.tally.add("overlaps", minimum.result.distance < 0.0);
    seen_.tally.add("with_object", hasObject(minimum.asked));
  }

  void askForTheClosest(int k) {
    if (chance_.below(4) == 0) question_.threshold = someThreshold();
    std::vector<PairProximity> found;
    if (k > 1)
      found = scene_.closest(pairs(), k, question_);
    else if (const PairProximity* minimum = scene_.minimum(pairs(), question_))
      found = {*minimum};
    const char* const who = k > 1 ? "closest()" : "minimum()";
    checkClosest(who, found);
    if (static_cast<int>(found.size()) < k) checkNothingMissing(who, found);
    checkCounts();
  }

  void askForPairsBelow() {
    question_.threshold = someThreshold();
    const std::vector<PairProximity> found = scene_.below(pairs(), question_);
    checkClosest("below()", found);
    checkNothingMissing("below()", found);
    checkCounts();
  }

  void askForSomePairsBelow() {
    question_.threshold = someThreshold();
    const int most = 1 + chance_.below(4);
    const PairsBelow found = scene_.closestBelow(pairs(), most, question_);
    const std::vector<PairProximity> closest = found.closest;
    const int count = found.count;
    checkClosest("closestBelow()", closest);
    int least = 0, at_most = 0;
    for (const PairTruth& pair : truth_.pairs()) {
      if (!isAsked(pair)) continue;
      least += isWithin(pair) ? 1 : 0;
      at_most += pair.distance.low <= question_.threshold + ownOf(pair.pair) + slack() ? 1 : 0;
    }
    if (count < least || count > at_most)
      fail("closestBelow() counts " + std::to_string(count) + ", not " + std::to_string(least) + " to " +
           std::to_string(at_most));
    if (static_cast<int>(closest.size()) != std::min(count, most))
      fail("closestBelow() lists another number than it counts");
    checkCounts();
  }

  void askForTheFirst() {
    question_.threshold = someThreshold();
    const PairProximity* found = scene_.first(pairs(), question_);
    if (!found) return checkNothingMissing("first()", {});
    const PairProximity first = *found;
    checkPair("first()", first);
    if (excessOf(first) > question_.threshold + roundingOf(first.asked)) fail("first() is above its threshold");
  }

  /// Asks about any pair, checked or not.
  void askForOnePair() {
    const auto some = [&]() -> ShapeRef {
      if (cell_.objects()->empty() || chance_.below(3) == 0)
        return {chance_.below(static_cast<int>(cell_.model()->robot.links.size()))};
      return ShapeRef::ofObject(chance_.oneOf(cell_.objects()->numbers()));
    };
    const ShapeRefPair pair{some(), some()};
    if (pair.a == pair.b) return;
    const PairTruth truth = truth_.of(pair);
    const auto planes = [&](const ShapeRef& ref) {
      return truth_.solidOf(ref) && !truth_.solidOf(ref)->planes.empty();
    };
    if (planes(pair.a) && planes(pair.b)) return;
    if (chance_.below(3) == 0) question_.threshold = someThreshold();
    checkAgainst("proximity()", scene_.proximity(pair, question_), truth);
  }

  // The promises of every answer.

  void checkPair(const std::string& who, const PairProximity& pair) {
    const PairTruth* truth = truth_.find(pair.asked);
    if (!truth) return fail(who + " has a pair that is not checked: " + named(pair));
    if (!isOfKind(pair.asked, kind_)) return fail(who + " has a pair of another kind: " + named(pair));
    checkAgainst(who, pair, *truth);
  }

  void checkAgainst(const std::string& who, const PairProximity& pair, const PairTruth& truth) {
    seen_.tally.add("answers");
    const std::string problem = problemOf(pair.result, truth, question_.tolerance);
    if (!problem.empty()) fail(who + ": " + named(pair) + " " + problem);
  }

  /// The i-th pair is no farther than the i-th smallest distance.
  void checkClosest(const std::string& who, const std::vector<PairProximity>& found) {
    const std::vector<long double> highs = sortedHighs();
    for (std::size_t i = 0; i < found.size(); ++i) {
      checkPair(who, found[i]);
      // Overlaps without a depth are equally near.
      if (question_.depth == Question::Depth::NotWanted && highs[i] < 0) continue;
      const long double above = excessOf(found[i]) - highs[i] - question_.tolerance - roundingOf(found[i].asked);
      if (above > 0)
        fail(who + ": number " + std::to_string(i) + " is farther than another pair" + by(above) + ": " +
             named(found[i]));
      if (excessOf(found[i]) > question_.threshold + roundingOf(found[i].asked))
        fail(who + " has a pair above the threshold");
    }
    if (question_.depth == Question::Depth::NotWanted && !found.empty() && !highs.empty() && highs[0] < -slack()) {
      const PairTruth* first = truth_.find(found[0].asked);
      if (first && first->distance.low > 0) fail(who + " misses an overlap");
    }
    checkDistinct(who, found);
  }

  void checkDistinct(const std::string& who, const std::vector<PairProximity>& found) {
    std::vector<const PairTruth*> pairs;
    for (const PairProximity& pair : found) pairs.push_back(truth_.find(pair.asked));
    std::sort(pairs.begin(), pairs.end());
    if (std::adjacent_find(pairs.begin(), pairs.end()) != pairs.end()) fail(who + " has a pair twice");
  }

  /// No pair at or below the threshold is left out.
  void checkNothingMissing(const std::string& who, const std::vector<PairProximity>& found) {
    std::size_t least = 0;
    for (const PairTruth& pair : truth_.pairs()) least += isAsked(pair) && isWithin(pair) ? 1 : 0;
    if (std::isinf(question_.threshold) && !found.empty()) least = 1;
    if (found.size() < least)
      fail(who + " has " + std::to_string(found.size()) + " pairs, not " + std::to_string(least));
  }

  void checkCounts() {
    const PairCounts& counts = scene_.counts();
    int total = 0, unknown = 0;
    for (const PairTruth& pair : truth_.pairs()) {
      total += isOfKind(pair.pair, kind_) ? 1 : 0;
      unknown += isOfKind(pair.pair, kind_) && !pair.is_known ? 1 : 0;
    }
    if (counts.total != total) fail("counts " + std::to_string(counts.total) + " pairs, not " + std::to_string(total));
    if (counts.unknown != unknown)
      fail("counts " + std::to_string(counts.unknown) + " unknown pairs, not " + std::to_string(unknown));
    if (counts.total != counts.unknown + counts.at_rest + counts.by_motion + counts.by_bounds + counts.computed)
      fail("the counts do not add up");
    seen_.tally.add("counted", counts.total);
    seen_.tally.add("at_rest", counts.at_rest);
    seen_.tally.add("by_motion", counts.by_motion);
    seen_.tally.add("computed", counts.computed);
  }

  /// The points lie on the parts that are named, or no farther out than half of the padding between them.
  void checkWitnesses(const PairProximity& pair) {
    if (!pair.result.has_points) return;
    checkOnItsPart(pair, pair.asked.a, pair.collision_a, pair.result.point_a);
    checkOnItsPart(pair, pair.asked.b, pair.collision_b, pair.result.point_b);
  }

  void checkOnItsPart(const PairProximity& pair, const ShapeRef& ref, int number, const Vector3d& world_point) {
    const Vector3l point = world_point.cast<long double>() - cell_.origin().cast<long double>();
    const std::optional<WorldSolid>& solid = truth_.solidOf(ref);
    long double outside = kFar;
    double size = 0.0;
    for (const WorldPart& part : solid->parts) {
      if (part.number != number) continue;
      const Vector3d in_part = (part.world_T_part.inverse() * point).cast<double>();
      outside = std::min({outside, outsideByAtMost(part.shape, in_part), outsideBy(part.shape, in_part)});
      // The point of a shape that lies wholly inside of a closed mesh is inside of it, too.
      if (part.interior) outside = std::min<long double>(outside, part.interior->placeOf(in_part).lower_bound);
      size = std::max(size, radiusOf(part.shape));
    }
    for (const WorldPlane& plane : solid->planes)
      if (plane.number == number) outside = std::min(outside, plane.normal.dot(point) - plane.offset);
    outside -= 0.5 * std::max(0.0, cell_.paddingOf(pair.asked));  // inside is nowhere less than 0
    const double allowed = pair.result.upper_bound - pair.result.lower_bound +
                           64.0 * std::numeric_limits<double>::epsilon() * (world_point.norm() + size);
    if (outside > allowed) fail("a point is not on its part," + by(outside) + " off, of " + named(pair));
  }

  double slack() const { return question_.tolerance + 1e-9 * cell_.size(); }
  std::string named(const PairProximity& pair) const { return nameOf(cell_, pair.asked); }
  void fail(const std::string& sentence) {
    if (!seen_.failure) seen_.failure = sentence;
  }

  SceneCell& cell_;
  StateTruth& truth_;
  PosedScene& scene_;
  SceneObservation& seen_;
  Chance& chance_;
  PairKind kind_ = PairKind::Any;
  Question question_;
  std::optional<PairDistances> thresholds_;
};

/// Returns nullptr if there is no pair with a distance.
const PairTruth* nearestOf(const StateTruth& truth) {
  const PairTruth* nearest = nullptr;
  for (const PairTruth& pair : truth.pairs())
    if (pair.is_known && (!nearest || pair.distance.high < nearest->distance.high)) nearest = &pair;
  return nearest;
}

/// Holds the nearest parts against the slow oracle, and against the other libraries, where they lie apart.
void seekOtherOpinions(const PairTruth& nearest, bool with_oracle, SceneObservation& seen) {
  const PartsApart& parts = nearest.nearest;
  if (!parts.a) return;
  bool wants_oracle = with_oracle;
  if (parts.distance.low > 1e-3) {
    for (const double other : distancesByOthers(parts.a->shape, parts.b->shape, parts.a_T_b)) {
      const bool is_off = std::abs(other - static_cast<double>(parts.distance.low)) > 1e-4 * std::max(1.0, other);
      seen.tally.add("others");
      seen.tally.add("others_off", is_off);
      wants_oracle = wants_oracle || is_off;
    }
  }
  if (!wants_oracle) return;
  seen.tally.add("with_oracle");
  const DistanceBounds exact = byOracle(parts);
  const long double apart = std::max(exact.low - parts.distance.high, parts.distance.low - exact.high);
  if (apart > 0 && !seen.failure) {
    seen.failure = "the slow oracle excludes the distance of the nearest parts" + by(apart);
  }
}

/// The laws of questions that need no truth.
void checkLaws(const SceneCell& cell, SceneObservation& seen) {
  const std::vector<double> not_asked_for(cell.model()->robot.joints.size(), 0.0);
  const laws::Cell here{cell.model(), cell.objects(), {{not_asked_for, cell.poses(), cell.frames()}}};
  for (const testing::AssertionResult& law :
       {laws::isTheSameAskedAgain<laws::Closest>(here), laws::isTheSameInOtherThreads<laws::All>(here)})
    if (!law && !seen.failure) seen.failure = law.message();
}

}  // namespace

void observeScenes(const stress::Part& part, int states, stress::Tally& tally) {
  SceneObservation seen{tally};
  SceneCell cell(part.family, part.seed, part.number);
  PosedScene scene(cell.model());
  MotionSearch moving(cell.model());
  for (int state = 0; state < states; ++state) {
    if (state > 0) cell.next();
    scene.use(cell.objects());
    scene.update(cell.poses(), cell.frames());
    StateTruth truth(cell);
    Examiner(cell, truth, scene, seen).run();
    if (state % 4 == 3) {
      PosedScene fresh = scene.forAnotherThread();
      fresh.update(cell.poses(), cell.frames());
      Examiner(cell, truth, fresh, seen).run();
      checkLaws(cell, seen);
    }
    const bool with_oracle = part.number % part.per_reference == 0;
    if (const PairTruth* nearest = nearestOf(truth); nearest) seekOtherOpinions(*nearest, with_oracle, seen);
    if (state % 2 == 1) observeMotion(cell, moving, seen);
    tally.add("scenes");
    for (const PairTruth& pair : truth.pairs()) {
      tally.add("pairs");
      tally.add("unknown", !pair.is_known);
    }
    if (!seen.failure) continue;
    tally.fail({part.number, "state " + std::to_string(state) + ": " + *seen.failure, {}});
    return;
  }
}

}  // namespace proximity_server::scene
