#include "tools/clearance/state_answers.h"

#include "proximity_server/scene/answers/assessment.h"
#include "proximity_server/scene/answers/deciding_pair.h"
#include "proximity_server/scene/batch/scene_batch.h"
#include "proximity_server/scene/guaranteed/guaranteed_distances.h"
#include "proximity_server/scene/model/kinematics.h"
#include "proximity_server/scene/motion/frames_on_links.h"
#include "proximity_server/scene/points/point_search.h"
#include "proximity_server/scene/query/scene.h"
#include "proximity_server/scene/state/object_carriers.h"
#include "system/numbers.h"

#include <algorithm>
#include <optional>
#include <utility>

namespace proximity_server::tools {
namespace {

using Kind = PairSelection::Kind;

/// [m] The value by which Scene sorts its answers.
double placeOf(const narrowphase::SignedDistance& result) {
  return result.status == narrowphase::Status::Converged ? result.distance : result.lower_bound;
}

/// The closest pair, from an answer that lists it and all that is closer. A pair that is not listed is not closer in the
/// order of Scene, but its lower bound may be below the bound of the closest by the tolerance.
ClosestPair closestOf(const StateAnswer& listed) {
  ClosestPair closest{{}, listed.unknown};
  double place = kInfinity;
  for (const scene::PairProximity* pair = listed.begin; pair != listed.end; ++pair) {
    if (pair->result.status == narrowphase::Status::Unknown || !(placeOf(pair->result) < place)) continue;
    place = placeOf(pair->result);
    closest.pair = *pair;
    closest.pair.result.lower_bound = std::min(pair->result.lower_bound, place - scene::Question{}.tolerance);
  }
  return closest;
}

/// Whether the closest pair of a state whose positions are exact is among those that are listed.
bool listsClosest(const ClearanceQuestion& question) {
  const Kind kind = question.selection.kind;
  return kind == Kind::All || kind == Kind::Closest || (kind == Kind::Minimum && !question.thresholds);
}

class BatchAnswers : public StateAnswers {
 public:
  BatchAnswers(const ClearanceQuestion& question, WantsClosest wants, scene::SceneBatch batch)
      : question_(question), wants_(wants), batch_(std::move(batch)) {}

  /// Asks about the states that have the same objects at a time.
  void answer(const StateBlock& block, const Take& take) override {
    for (int first = 0, end = 0; first < block.size; first = end) {
      const std::shared_ptr<const scene::Objects> objects = block.objectsOf(first);
      end = objects ? first + 1 : block.size;
      while (end < block.size && block.objects[end] == objects) ++end;
      if (objects.get() != batch_.objects()) batch_.use(objects);
      answer(block.positions.middleRows(first, end - first), first, take);
    }
  }

 private:
  void answer(const scene::States& states, int first, const Take& take) {
    std::vector<scene::PairProximity> minima;  // a copy, as the next question overwrites the answer
    if (wants_ == WantsClosest::Yes && !listsClosest(question_)) minima = minimaOf(states);
    std::size_t i = 0;
    const auto tell = [&](StateAnswer answer) {
      std::optional<ClosestPair> closest;
      if (wants_ == WantsClosest::Yes) closest = closestOf(minima.empty() ? answer : ofMinimum(minima[i]));
      if (closest) answer.closest = &*closest;
      take(first + static_cast<int>(i++), answer);
    };
    const auto& [kind, count] = static_cast<const scene::PairSelection&>(question_.selection);
    const double threshold = question_.selection.threshold;
    const scene::Deadline& deadline = question_.budget.deadline;
    if (kind == Kind::Any)
      tellVerdicts(batch_.anyBelow(states, threshold, deadline), tell);
    else if (kind == Kind::Below)
      tellLists(batch_.below(states, threshold, deadline), tell);
    else if (kind == Kind::Closest)
      tellLists(batch_.closest(states, count, deadline), tell);
    else
      for (const scene::PairProximity& pair :
           question_.thresholds ? batch_.deciding(states, *question_.thresholds, deadline) : minimaOf(states))
        tell(ofMinimum(pair));
  }

  const std::vector<scene::PairProximity>& minimaOf(const scene::States& states) {
    const double accuracy = question_.selection.accuracy;
    const scene::Deadline& deadline = question_.budget.deadline;
    return accuracy > 0.0 ? batch_.minimumWithin(states, accuracy, deadline) : batch_.minimum(states, deadline);
  }

  template <typename Tell>
  void tellVerdicts(const std::vector<scene::StateVerdict>& verdicts, const Tell& tell) const {
    scene::PairProximity below;
    below.result.status = narrowphase::Status::Converged;
    for (const scene::StateVerdict& found : verdicts) {
      const bool is_below = found.kind == scene::StateVerdict::Kind::Below;
      if (is_below) below.asked = batch_.pairs()[found.pair];
      tell({&below, &below + (is_below ? 1 : 0), found.kind == scene::StateVerdict::Kind::Unknown ? allPairs() : 0});
    }
  }

  template <typename Tell>
  void tellLists(const scene::StatePairs& lists, const Tell& tell) const {
    const scene::PairProximity* const pairs = lists.pairs.data();
    for (std::size_t i = 0; i < lists.unknown.size(); ++i)
      tell({pairs + lists.begins[i], pairs + lists.begins[i + 1], lists.unknown[i] != 0 ? allPairs() : 0});
  }

  StateAnswer ofMinimum(const scene::PairProximity& pair) const {
    return {&pair, &pair + 1, isNamed(pair.asked) ? 0 : allPairs()};
  }

  /// SceneBatch has no answer about a state if one of its pairs has none.
  int allPairs() const { return static_cast<int>(batch_.pairs().size()); }

  const ClearanceQuestion& question_;
  const WantsClosest wants_;
  scene::SceneBatch batch_;
};

/// The scene and the state that each block begins with a copy of.
struct FreshScene {
  scene::Scene scene;
  scene::State state;
};

class SceneAnswers : public StateAnswers {
 public:
  SceneAnswers(const ClearanceQuestion& question, WantsClosest wants, std::shared_ptr<const FreshScene> fresh)
      : question_(question), wants_(wants), fresh_(std::move(fresh)) {}

  void answer(const StateBlock& block, const Take& take) override {
    scene::Scene scene = fresh_->scene.forAnotherThread();
    scene::State state = fresh_->state.forAnotherThread();
    QuestionPairs pairs(question_);
    std::optional<scene::GuaranteedDistances> guaranteed = guaranteedDistances();
    for (int i = 0; i < block.size; ++i) {
      question_.budget.require();
      const std::shared_ptr<const scene::Objects> objects = block.objectsOf(i);
      if (pairs.use(objects)) state.set(objects, scene::carriersOnLinks(*objects));
      setPositions(state, block.positionsOf(i));
      answer(pairs.get(), scene, state, guaranteed ? &*guaranteed : nullptr,
             [&](const StateAnswer& answer) { take(i, answer); });
    }
  }

 private:
  std::optional<scene::GuaranteedDistances> guaranteedDistances() const {
    if (!question_.uncertainty) return std::nullopt;
    std::optional<scene::GuaranteedDistances> guaranteed(question_.model);
    guaranteed->assume(*question_.uncertainty);
    scene::GuaranteeLimits limits;
    limits.deadline = question_.budget.deadline;
    guaranteed->limit(limits);
    return guaranteed;
  }

  /// `guaranteed` is nullptr if the state is exact.
  template <typename Tell>
  void answer(const scene::Pairs& pairs, scene::Scene& scene, const scene::State& state,
              scene::GuaranteedDistances* guaranteed, const Tell& tell) const {
    const bool is_minimum = question_.selection.kind == Kind::Minimum;
    const bool is_guaranteed_minimum = guaranteed && is_minimum && !question_.thresholds;
    const bool wants_closest = wants_ == WantsClosest::Yes;
    scene::GuaranteedMinimum smallest;
    if (is_guaranteed_minimum || (guaranteed && wants_closest))
      smallest = guaranteed->find(scene, state, scene::PairDistances());
    std::vector<scene::PairProximity> listed{smallest.pair}, minimum;
    std::vector<double> of_listed{smallest.guaranteed};
    int unknown = smallest.unknown;
    if (guaranteed && is_minimum && question_.thresholds) {
      const scene::Assessment assessed = assess(scene, state, *guaranteed);
      listed = {assessed.deciding.pair};
      of_listed = {assessed.deciding.guaranteed};
      unknown = assessed.counts.unknown;
    } else if (!is_guaranteed_minimum) {
      listed = ask(pairs, scene, state);
      unknown = scene.counts().unknown;
      of_listed.clear();
      for (const scene::PairProximity& pair : listed)
        if (guaranteed) of_listed.push_back(guaranteed->of(state, pair));
    }
    StateAnswer answer{listed.data(), listed.data() + listed.size(), unknown, guaranteed ? of_listed.data() : nullptr};
    ClosestPair closest{smallest.pair, smallest.unknown};
    if (wants_closest && !guaranteed) {
      const bool is_listed = listsClosest(question_);
      if (!is_listed) minimum = selectPairs(scene, state, pairs, {});
      const StateAnswer of_minimum{minimum.data(), minimum.data() + minimum.size(), scene.counts().unknown};
      closest = closestOf(is_listed ? answer : of_minimum);
    } else if (isNamed(closest.pair.asked)) {
      closest.pair.result.lower_bound = smallest.guaranteed;
    }
    if (wants_closest) answer.closest = &closest;
    tell(answer);
  }

  /// The level in all states that may be the true one, as the node finds it.
  scene::Assessment assess(scene::Scene& scene, const scene::State& state,
                           scene::GuaranteedDistances& guaranteed) const {
    const std::vector<std::optional<double>> none_stated(question_.model->robot.joints.size());
    scene::AssessmentQuestion asked{*question_.thresholds, none_stated};
    asked.guaranteed = &guaranteed;
    scene::Assessment assessed;
    scene::assess(scene, state, asked, assessed);
    return assessed;
  }

  std::vector<scene::PairProximity> ask(const scene::Pairs& pairs, scene::Scene& scene,
                                        const scene::State& state) const {
    const auto& thresholds = question_.thresholds;
    scene::Question question;
    question.threshold = question_.selection.threshold;
    std::vector<scene::PairProximity> listed = selectPairs(scene, state, pairs, question_.selection, question);
    if (question_.selection.kind == Kind::Minimum && thresholds && !listed.empty())
      listed = {scene::decidingPair(scene, state, pairs, listed.front(), {*thresholds}).pair};
    return listed;
  }

  const ClearanceQuestion& question_;
  const WantsClosest wants_;
  std::shared_ptr<const FreshScene> fresh_;
};

/// Answers about the points of the question: that about a state depends on it alone, and on the objects that are there.
class PointAnswers : public StateAnswers {
 public:
  PointAnswers(const ClearanceQuestion& question, WantsClosest wants)
      : question_(question), wants_(wants), state_(question.model), search_(question.model, question.skipping) {
    const auto& [centres, radii, shapes] = *question.points;
    for (std::size_t begin = 0; begin < centres.size(); begin += kPart) {
      const std::size_t end = std::min(begin + kPart, centres.size());
      scene::Points& part = parts_.emplace_back();
      part.centres.assign(centres.data() + begin, centres.data() + end);
      if (!radii.empty()) part.radii.assign(radii.data() + begin, radii.data() + end);
    }
  }

  void answer(const StateBlock& block, const Take& take) override {
    for (int i = 0; i < block.size; ++i) {
      const std::shared_ptr<const scene::Objects> objects = block.objectsOf(i);
      if (objects && objects != state_.objects()) state_.set(objects, scene::carriersOnLinks(*objects));
      setPositions(state_, block.positionsOf(i));
      const std::vector<scene::PairProximity> listed = ask(question_.selection);
      StateAnswer answer{listed.data(), listed.data() + listed.size(), unknown_};
      ClosestPair closest;
      if (wants_ == WantsClosest::Yes) {
        const std::vector<scene::PairProximity> minimum = ask({{Kind::Minimum}});
        closest = closestOf({minimum.data(), minimum.data() + minimum.size(), unknown_});
        answer.closest = &closest;
      }
      take(i, answer);
    }
  }

 private:
  static constexpr int kPart = 1024;

  /// The answers about the points of a selection. For the minimum a bound is enough for what is farther than the closest
  /// point of the parts before.
  std::vector<scene::PairProximity> ask(const PairSelection& selection) {
    std::vector<scene::PairProximity> listed;
    scene::Question question;
    question.threshold = selection.threshold;
    question.deadline = question_.budget.deadline;
    unknown_ = 0;
    int number = 0;
    for (const scene::Points& part : parts_) {
      question_.budget.require();
      for (const scene::PairProximity& of_point : search_.closest(state_, part, question)) {
        scene::PairProximity found = search_.unplaced().empty() ? of_point : scene::PairProximity();
        found.asked.b = scene::ShapeRef::ofPoint(number++);
        if (found.result.status == narrowphase::Status::Unknown) ++unknown_;
        if (selection.kind == Kind::All || isNamed(found.asked)) listed.push_back(found);
      }
      if (selection.kind == Kind::Minimum && !listed.empty()) {
        listed = {*std::min_element(listed.begin(), listed.end(), isCloser)};
        question.threshold = listed.front().result.upper_bound;
      }
    }
    if (selection.kind != Kind::All) std::stable_sort(listed.begin(), listed.end(), isCloser);
    if (selection.kind == Kind::Closest)
      listed.resize(std::min(listed.size(), static_cast<std::size_t>(selection.count)));
    return listed;
  }

  static bool isCloser(const scene::PairProximity& a, const scene::PairProximity& b) {
    return placeOf(a.result) < placeOf(b.result);
  }

  const ClearanceQuestion& question_;
  const WantsClosest wants_;
  scene::State state_;
  scene::PointSearch search_;
  std::vector<scene::Points> parts_;
  int unknown_ = 0;  ///< points without an answer in the last question
};

}  // namespace

scene::Positions StateBlock::positionsOf(int i) const {
  scene::Positions of_state(static_cast<std::size_t>(positions.cols()));
  for (std::size_t j = 0; j < of_state.size(); ++j) of_state[j] = positions(i, static_cast<Eigen::Index>(j));
  return of_state;
}

bool isForBatch(const ClearanceQuestion& question) {
  // SceneBatch knows the candidates of the filter, which then are the first pairs of the question, in their order.
  return question.filter == PairFilter::On && question.skipping == scene::Skipping::On &&
         question.selection.kind != Kind::All && !question.uncertainty;
}

std::vector<std::unique_ptr<StateAnswers>> answersOfThreads(const ClearanceQuestion& question, WantsClosest wants) {
  std::vector<std::unique_ptr<StateAnswers>> answers;
  if (question.points) {
    for (int i = 0; i < question.threads; ++i) answers.push_back(std::make_unique<PointAnswers>(question, wants));
  } else if (isForBatch(question)) {
    const scene::SceneBatch batch(question.model);
    for (int i = 0; i < question.threads; ++i)
      answers.push_back(std::make_unique<BatchAnswers>(question, wants, batch.forAnotherThread()));
  } else {
    const auto fresh = std::make_shared<const FreshScene>(
        FreshScene{scene::Scene(question.model, question.skipping), scene::State(question.model)});
    for (int i = 0; i < question.threads; ++i)
      answers.push_back(std::make_unique<SceneAnswers>(question, wants, fresh));
  }
  return answers;
}

}  // namespace proximity_server::tools
