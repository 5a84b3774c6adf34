#include "tools/clearance/state_sweep.h"

#include "proximity_server/scene/answers/deciding_pair.h"
#include "proximity_server/scene/batch/scene_batch.h"
#include "proximity_server/scene/guaranteed/guaranteed_distances.h"
#include "proximity_server/scene/levels/clearance_level.h"
#include "proximity_server/scene/model/kinematics.h"
#include "proximity_server/scene/motion/frames_on_links.h"
#include "proximity_server/scene/query/scene.h"
#include "proximity_server/scene/state/object_carriers.h"
#include "system/numbers.h"
#include "system/pipeline.h"
#include "tools/clearance/clearance_rows.h"
#include "tools/robot/robot_text.h"

#include <algorithm>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <stdexcept>
#include <utility>

namespace proximity_server::tools {
namespace {

/// So many that taking turns costs nothing beside the answers, and so few that a block stays in the cache of a core.
constexpr int kBlockOfBatch = 2048;

/// So many that the cold start is a small part of the work.
constexpr int kBlockOfScene = 256;

/// States that lie side by side, what is answered about them, and their rows.
struct StateBlock {
  std::uint64_t first = 0;
  int size = 0;
  Eigen::MatrixXd positions;
  std::vector<std::shared_ptr<const scene::Objects>> objects;  ///< in each state; empty: there are none
  std::vector<double> times;                                   ///< [s] of each state; NaN if it has none
  WrittenRows rows, plot_rows;
  std::vector<StateClearance> answers;  ///< for the assertion, the second opinion and the report
};

scene::Positions positionsOf(const StateBlock& block, int i) {
  scene::Positions positions(static_cast<std::size_t>(block.positions.cols()));
  for (std::size_t j = 0; j < positions.size(); ++j) positions[j] = block.positions(i, static_cast<Eigen::Index>(j));
  return positions;
}

/// The pairs that are listed of a state.
struct Listed {
  const scene::PairProximity* begin;
  const scene::PairProximity* end;
  int unknown = 0;                     ///< pairs without an answer
  const double* guaranteed = nullptr;  ///< [m] of each pair, if there is an uncertainty
};

bool isKnown(const scene::PairProximity& pair) {
  return isNamed(pair.asked) && pair.result.status != narrowphase::Status::Unknown;
}

/// The closest of the pairs that have an answer, as `all` lists them in another order; nullptr: none has.
const scene::PairProximity* closestKnown(const Listed& listed) {
  const scene::PairProximity* closest = nullptr;
  for (const scene::PairProximity* pair = listed.begin; pair != listed.end; ++pair)
    if (isKnown(*pair) && (!closest || pair->result.distance < closest->result.distance)) closest = pair;
  return closest;
}

/// [m] The value by which Scene sorts its answers.
double placeOf(const narrowphase::SignedDistance& result) {
  return result.status == narrowphase::Status::Converged ? result.distance : result.lower_bound;
}

/// The smallest distance, from an answer that lists the smallest and all that is closer. A pair that is not listed is
/// not closer in the order of Scene, but its lower bound may be below that of the smallest by the tolerance.
SmallestDistance smallestOf(const Listed& listed) {
  SmallestDistance smallest;
  smallest.unknown_pairs = listed.unknown;
  double place = std::numeric_limits<double>::infinity();
  for (const scene::PairProximity* pair = listed.begin; pair != listed.end; ++pair) {
    if (pair->result.status == narrowphase::Status::Unknown || !(placeOf(pair->result) < place)) continue;
    place = placeOf(pair->result);
    smallest.pair = *pair;
    smallest.lower_bound = std::min(pair->result.lower_bound, place - scene::Question{}.tolerance);
  }
  return smallest;
}

Listed listOf(const std::vector<scene::PairProximity>& pairs, int unknown) {
  return {pairs.data(), pairs.data() + pairs.size(), unknown};
}

class StateSweep {
 public:
  StateSweep(const ClearanceQuestion& question, StateSource& states, const StateRange& range, AnswerOutput& output)
      : question_(question),
        kind_(question.selection.kind),
        states_(states),
        range_(range),
        output_(output),
        rows_(question, output.format),
        plot_rows_(question, RowFormat::Csv) {
    // SceneBatch knows the candidates of the filter, which then are the first pairs of the question, in their order.
    const bool is_for_batch = question.filter == PairFilter::On && question.skipping == scene::Skipping::On &&
                              kind_ != PairSelection::Kind::All && !question.uncertainty;
    std::optional<scene::SceneBatch> batch;
    if (is_for_batch) {
      batch.emplace(question.model);
    } else {
      fresh_.emplace(question.model, question.skipping);
    }
    if (output.report) for_report_.emplace(question.model, question.skipping);
    if (fresh_ || for_report_) fresh_state_.emplace(question.model);
    for (int i = 0; i < question.threads; ++i)
      workers_.push_back(
          {batch ? std::optional(batch->forAnotherThread()) : std::nullopt, SummaryCounter(summaryKind()), {}, {}});
    next_ = is_for_batch ? range.begin : range.begin / kBlockOfScene * kBlockOfScene;
    if (question.objects) next_ = 0;  // they change on the way there
  }

  SweepSummary run() {
    if (next_ > 0) states_.skipTo(next_);
    constexpr int kLists = 1, kStates = 4;  // blocks for each thread: lists of all pairs are large
    system::runPipeline<StateBlock>(
        {[&](StateBlock& block) { return read(block); },
         [&](StateBlock& block, int thread) { answer(block, workers_[thread]); },
         [&](StateBlock& block) { write(block); }},
        {question_.threads, system::PipelineThreads::TooFew::Refused, fresh_ || for_report_ ? kLists : kStates});
    SweepSummary summary;
    summary.kind = summaryKind();
    for (const Worker& worker : workers_)
      summary.add(worker.counter.summary(question_.model->robot, [&](int pair) { return namesOf(pair, worker); }));
    return summary;
  }

 private:
  /// The state of one thread.
  struct Worker {
    std::optional<scene::SceneBatch> batch;
    SummaryCounter counter;
    std::map<SweepSummary::Names, int> object_pairs;  ///< numbered as they come, because objects come and go
    std::vector<SweepSummary::Names> object_names;    ///< the names of these
  };

  SummaryKind summaryKind() const {
    return kind_ == PairSelection::Kind::Any ? SummaryKind::Verdicts : SummaryKind::Distances;
  }
  const scene::LevelThresholds* thresholds() const { return question_.thresholds ? &*question_.thresholds : nullptr; }

  /// Whether the closest pair of a state is among those that are listed.
  bool listsSmallest() const {
    if (question_.uncertainty) return kind_ == PairSelection::Kind::Minimum;
    return kind_ == PairSelection::Kind::All || kind_ == PairSelection::Kind::Closest ||
           (kind_ == PairSelection::Kind::Minimum && !question_.thresholds);
  }

  /// Whether the assertion needs the closest pair besides those that are listed.
  bool needsSmallest() const { return output_.assertion && !listsSmallest(); }

  /// Reads the next block; an error of reading ends it, and is thrown by the next call.
  bool read(StateBlock& block) {
    question_.budget.require();
    const Eigen::Index size = fresh_ || for_report_ ? kBlockOfScene : kBlockOfBatch;
    if (block.positions.rows() == 0)
      block.positions.resize(size, static_cast<Eigen::Index>(question_.model->robot.joints.size()));
    const auto wanted = static_cast<Eigen::Index>(std::min(range_.end - next_, static_cast<std::uint64_t>(size)));
    if (wanted == 0) return false;
    block.first = next_;
    block.objects.clear();
    block.times.clear();
    block.size = states_.read(block.positions.topRows(wanted), [&](const scene::Positions& positions) {
      block.times.push_back(states_.time().value_or(kNaN));
      if (!question_.objects) return;
      const std::size_t state = block.first + block.objects.size();
      question_.objects->advance(static_cast<long>(state), states_.time(), positions);
      block.objects.push_back(question_.objects->now());
    });
    next_ += static_cast<std::uint64_t>(block.size);
    if (block.size == 0 && range_.end != kToTheEnd)
      throw std::invalid_argument(states_.source() + ": ends after " + std::to_string(next_) +
                                  " states, before those of " + textOf(range_));
    return block.size > 0;
  }

  void answer(StateBlock& block, Worker& worker) const {
    block.rows.clear();
    block.plot_rows.clear();
    block.answers.clear();
    if (block.first + static_cast<std::uint64_t>(block.size) <= range_.begin) return;
    if (worker.batch)
      answerByBatch(block, worker);
    else
      answerByScene(block, worker);
    if (for_report_) answerAllPairs(block);
    question_.budget.require();
  }

  void answerByBatch(StateBlock& block, Worker& worker) const {
    for (int first = 0, end = 0; first < block.size; first = end) {
      end = endOfSameObjects(block, first);
      if (!block.objects.empty() && block.objects[first].get() != worker.batch->objects())
        worker.batch->use(block.objects[first]);
      answerByBatch(first, block.positions.middleRows(first, end - first), block, worker);
    }
  }

  /// The first state after `first` that has other objects.
  static int endOfSameObjects(const StateBlock& block, int first) {
    if (block.objects.empty()) return block.size;
    const auto begin = block.objects.begin() + first;
    const auto end = std::find_if(begin, block.objects.end(), [&](const auto& objects) { return objects != *begin; });
    return static_cast<int>(end - block.objects.begin());
  }

  /// Answers the states of a block from `first` on. All have the objects that the batch has.
  void answerByBatch(int first, const scene::States& states, StateBlock& block, Worker& worker) const {
    const PairSelection& selection = question_.selection;
    const scene::Deadline& deadline = question_.budget.deadline;
    const std::size_t answered = block.answers.size();
    switch (kind_) {
      case PairSelection::Kind::Any:
        addVerdicts(worker.batch->anyBelow(states, selection.threshold, deadline), first, block, worker);
        break;
      case PairSelection::Kind::Below:
        addLists(worker.batch->below(states, selection.threshold, deadline), first, block, worker);
        break;
      case PairSelection::Kind::Closest:
        addLists(worker.batch->closest(states, selection.count, deadline), first, block, worker);
        break;
      case PairSelection::Kind::Minimum:
      case PairSelection::Kind::All:  // is not answered here
        addMinima(thresholds() ? worker.batch->deciding(states, *thresholds(), deadline) : minimaOf(states, worker),
                  first, block, worker);
        break;
    }
    if (!needsSmallest()) return;
    const std::vector<scene::PairProximity>& minima = minimaOf(states, worker);
    for (std::size_t i = answered; i < block.answers.size(); ++i) {
      const auto state = static_cast<std::uint64_t>(block.answers[i].state) - block.first;
      block.answers[i].smallest = smallestOf(ofMinimum(minima[state - static_cast<std::uint64_t>(first)], worker));
    }
  }

  const std::vector<scene::PairProximity>& minimaOf(const scene::States& states, Worker& worker) const {
    const double accuracy = question_.selection.accuracy;
    const scene::Deadline& deadline = question_.budget.deadline;
    return accuracy > 0.0 ? worker.batch->minimumWithin(states, accuracy, deadline)
                          : worker.batch->minimum(states, deadline);
  }

  // These add the answers about the states of a block from `first` on.
  void addVerdicts(const std::vector<scene::StateVerdict>& verdicts, int first, StateBlock& block,
                   Worker& worker) const {
    const std::vector<scene::ShapeRefPair>& pairs = worker.batch->pairs();
    scene::PairProximity below;
    below.result.status = narrowphase::Status::Converged;
    for (const scene::StateVerdict& found : verdicts) {
      const bool is_below = found.kind == Verdict::Below;
      if (is_below) below.asked = pairs[found.pair];
      const int unknown = found.kind == Verdict::Unknown ? unknownPairs(worker) : 0;
      add(first++, {&below, &below + (is_below ? 1 : 0), unknown}, block, worker);
    }
  }

  void addMinima(const std::vector<scene::PairProximity>& minima, int first, StateBlock& block, Worker& worker) const {
    for (const scene::PairProximity& minimum : minima) add(first++, ofMinimum(minimum, worker), block, worker);
  }

  void addLists(const scene::StatePairs& lists, int first, StateBlock& block, Worker& worker) const {
    const scene::PairProximity* const pairs = lists.pairs.data();
    for (std::size_t i = 0; i < lists.unknown.size(); ++i) {
      const int unknown = lists.unknown[i] != 0 ? unknownPairs(worker) : 0;
      add(first++, {pairs + lists.begins[i], pairs + lists.begins[i + 1], unknown}, block, worker);
    }
  }

  /// SceneBatch has no answer about a state if one of its pairs has none.
  static int unknownPairs(const Worker& worker) { return static_cast<int>(worker.batch->pairs().size()); }
  static Listed ofMinimum(const scene::PairProximity& pair, const Worker& worker) {
    return {&pair, &pair + 1, isNamed(pair.asked) ? 0 : unknownPairs(worker)};
  }

  /// The number of the pairs of links.
  int linkPairs() const { return static_cast<int>(question_.pairs.size()); }

  void answerByScene(StateBlock& block, Worker& worker) const {
    scene::Scene scene = fresh_->forAnotherThread();
    scene::State state = fresh_state_->forAnotherThread();
    QuestionPairs pairs(question_);
    std::optional<scene::GuaranteedDistances> guaranteed = guaranteedDistances();
    for (int i = 0; i < block.size; ++i) {
      question_.budget.require();
      place(positionsOf(block, i), block.objects.empty() ? nullptr : block.objects[i], pairs, state);
      if (guaranteed) {
        answerGuaranteed(i, pairs.get(), scene, state, *guaranteed, block, worker);
        continue;
      }
      const std::vector<scene::PairProximity> listed = askScene(pairs.get(), scene, state);
      const std::size_t answers = block.answers.size();
      add(i, listOf(listed, scene.counts().unknown), block, worker);
      if (!needsSmallest() || block.answers.size() == answers) continue;
      const std::vector<scene::PairProximity> minimum = selectPairs(scene, state, pairs.get(), {});
      block.answers.back().smallest = smallestOf(listOf(minimum, scene.counts().unknown));
    }
  }

  std::optional<scene::GuaranteedDistances> guaranteedDistances() const {
    if (!question_.uncertainty) return std::nullopt;
    std::optional<scene::GuaranteedDistances> guaranteed(question_.model);
    guaranteed->assume(*question_.uncertainty);
    scene::GuaranteeLimits limits;
    limits.deadline = question_.budget.deadline;
    guaranteed->limit(limits);
    return guaranteed;
  }

  static void place(const scene::Positions& positions, const std::shared_ptr<const scene::Objects>& objects,
                    QuestionPairs& pairs, scene::State& state) {
    if (pairs.use(objects)) state.set(objects, scene::carriersOnLinks(*objects));
    setPositions(state, positions);
  }

  /// Asks for all pairs of the states for the report, by a scene of its own, so that the rows keep their bytes.
  void answerAllPairs(StateBlock& block) const {
    scene::Scene scene = for_report_->forAnotherThread();
    scene::State state = fresh_state_->forAnotherThread();
    QuestionPairs pairs(question_);
    std::optional<scene::GuaranteedDistances> guaranteed = guaranteedDistances();
    for (StateClearance& answer : block.answers) {
      question_.budget.require();
      place(answer.positions, answer.objects, pairs, state);
      answer.all_pairs = scene.all(state, pairs.get());
      if (!guaranteed) continue;
      for (scene::PairProximity& pair : answer.all_pairs) pair.result.lower_bound = guaranteed->of(state, pair);
    }
  }

  /// Answers about one state, which the scene has, within the uncertainty.
  void answerGuaranteed(int i, const scene::Pairs& pairs, scene::Scene& scene, const scene::State& state,
                        scene::GuaranteedDistances& guaranteed, StateBlock& block, Worker& worker) const {
    const bool is_minimum = kind_ == PairSelection::Kind::Minimum;
    scene::GuaranteedMinimum smallest;
    if (is_minimum || needsSmallest()) smallest = guaranteed.find(scene, state, scene::PairDistances());
    std::vector<scene::PairProximity> listed{smallest.pair};
    std::vector<double> of_listed{smallest.guaranteed};
    int unknown = smallest.unknown;
    if (!is_minimum) {
      listed = askScene(pairs, scene, state);
      unknown = scene.counts().unknown;
      of_listed.clear();
      for (const scene::PairProximity& pair : listed) of_listed.push_back(guaranteed.of(state, pair));
    }
    Listed list = listOf(listed, unknown);
    list.guaranteed = of_listed.data();
    const std::size_t answers = block.answers.size();
    add(i, list, block, worker);
    if (output_.assertion && block.answers.size() > answers)
      block.answers.back().smallest = {smallest.pair, smallest.guaranteed, smallest.unknown};
  }

  std::vector<scene::PairProximity> askScene(const scene::Pairs& pairs, scene::Scene& scene,
                                             const scene::State& state) const {
    scene::Question question;
    question.threshold = question_.selection.threshold;
    std::vector<scene::PairProximity> listed = selectPairs(scene, state, pairs, question_.selection, question);
    if (kind_ == PairSelection::Kind::Minimum && thresholds() && !listed.empty())
      listed = {scene::decidingPair(scene, state, pairs, listed.front(), {*thresholds()}).pair};
    return listed;
  }

  /// Adds the answer about a state to the rows, the summary, and what is asked further.
  void add(int i, const Listed& listed, StateBlock& block, Worker& worker) const {
    const std::uint64_t state = block.first + static_cast<std::uint64_t>(i);
    if (state < range_.begin) return;
    const scene::Objects* const objects = block.objects.empty() ? nullptr : block.objects[i].get();
    addRows(state, listed, objects, block);
    count(i, state, listed, objects, block, worker);
    if (!output_.assertion && !output_.second_opinion && !output_.report) return;
    StateClearance& answer = block.answers.emplace_back();
    answer.state = static_cast<long>(state);
    if (output_.second_opinion && !isOpen(listed)) answer.pairs.assign(listed.begin, listed.end);
    if (output_.assertion && listsSmallest()) answer.smallest = smallestOf(listed);
    answer.positions = positionsOf(block, i);
    answer.time = block.times[i];
    if (objects) answer.objects = block.objects[i];
  }

  /// Whether unknown pairs leave open what is to be listed.
  bool isOpen(const Listed& listed) const {
    return listed.unknown > 0 && kind_ != PairSelection::Kind::All && kind_ != PairSelection::Kind::Any;
  }

  void addRows(std::uint64_t state, const Listed& listed, const scene::Objects* objects, StateBlock& block) const {
    if (kind_ == PairSelection::Kind::Any) {
      const scene::PairProximity* const below = closestKnown(listed);
      const Verdict verdict = below ? Verdict::Below : listed.unknown > 0 ? Verdict::Unknown : Verdict::Above;
      return rows_.addVerdict(state, verdict, below ? below->asked : scene::ShapeRefPair{}, objects, block.rows);
    }
    const scene::PairProximity no_answer;  // has a row too, as no row says that no pair is listed
    const Listed written = isOpen(listed) ? Listed{&no_answer, &no_answer + 1} : listed;
    for (const scene::PairProximity* pair = written.begin; pair != written.end; ++pair) {
      const double guaranteed = written.guaranteed ? written.guaranteed[pair - written.begin] : kNaN;
      rows_.addPair(state, *pair, guaranteed, objects, block.rows);
      if (output_.plot) plot_rows_.addPair(state, *pair, guaranteed, objects, block.plot_rows);
    }
  }

  void count(int i, std::uint64_t state, const Listed& listed, const scene::Objects* objects, const StateBlock& block,
             Worker& worker) const {
    const scene::PairProximity* const closest = closestKnown(listed);
    const bool is_any = kind_ == PairSelection::Kind::Any;
    if (closest && (is_any || listed.unknown == 0)) {
      SummaryCounter::Closest counted{state, numberOf(closest->asked, objects, worker)};
      if (!is_any) {
        counted.distance = closest->result.distance;
        counted.lower = closest->result.lower_bound;
        counted.upper = closest->result.upper_bound;
      }
      worker.counter.add(counted, [&] { return positionsOf(block, i); });
      countLevel(listed, worker);
    } else if (listed.unknown == 0 && listed.begin == listed.end) {
      worker.counter.addUnlisted();
    } else {
      worker.counter.addUnknown();
    }
  }

  /// Counts the level of a state, where the pairs that are listed tell it: all, or the one that sets it.
  void countLevel(const Listed& listed, Worker& worker) const {
    if (!thresholds() || (kind_ != PairSelection::Kind::Minimum && kind_ != PairSelection::Kind::All)) return;
    scene::ClearanceLevel worst = scene::ClearanceLevel::Clear;
    for (const scene::PairProximity* pair = listed.begin; pair != listed.end; ++pair)
      worst = std::max(worst, levelOf(*pair, *thresholds()).level);
    worker.counter.addLevel(worst);
  }

  int numberOf(const scene::ShapeRefPair& pair, const scene::Objects* objects, Worker& worker) const {
    const int number = rows_.numbers().of(pair);
    if (number >= 0) return number;
    const scene::RobotModel& robot = question_.model->robot;
    const SweepSummary::Names names{nameOf(pair.a, robot, objects), nameOf(pair.b, robot, objects)};
    const auto [place, is_new] =
        worker.object_pairs.emplace(names, linkPairs() + static_cast<int>(worker.object_names.size()));
    if (is_new) worker.object_names.push_back(names);
    return place->second;
  }

  SweepSummary::Names namesOf(int number, const Worker& worker) const {
    if (number >= linkPairs()) return worker.object_names[number - linkPairs()];
    const scene::ShapeRefPair& pair = question_.pairs[number];
    const scene::RobotModel& robot = question_.model->robot;
    return {nameOf(pair.a, robot), nameOf(pair.b, robot)};
  }

  void write(const StateBlock& block) const {
    output_.rows.write(block.rows);
    if (output_.plot) output_.plot->write(block.plot_rows);
    for (const StateClearance& answer : block.answers) {
      if (output_.assertion) output_.assertion->add(answer);
      if (output_.second_opinion)
        output_.second_opinion->add(answer.state, answer.pairs, answer.positions, answer.objects);
      if (output_.report) output_.report->add(answer);
    }
    // A block may begin before the range.
    const std::uint64_t end = block.first + static_cast<std::uint64_t>(block.size);
    output_.counter.count(end - std::min(end, std::max(block.first, range_.begin)));
  }

  const ClearanceQuestion& question_;
  const PairSelection::Kind kind_;
  StateSource& states_;
  const StateRange range_;
  AnswerOutput& output_;
  const StateRows rows_, plot_rows_;
  std::optional<scene::Scene> fresh_;  ///< for all that SceneBatch does not know
  std::optional<scene::Scene> for_report_;
  std::optional<scene::State> fresh_state_;  ///< for both
  std::vector<Worker> workers_;              ///< one for each thread
  std::uint64_t next_ = 0;                   ///< the state to be read
};

}  // namespace

void AnswerOutput::end() {
  counter.clear();
  rows.end();
  if (plot) plot->end();
  if (second_opinion) second_opinion->end();
}

void AnswerOutput::complete() {
  rows.complete();
  if (second_opinion) second_opinion->complete();
}

SweepSummary sweepStates(const ClearanceQuestion& question, StateSource& states, const StateRange& range,
                         AnswerOutput& output) {
  return StateSweep(question, states, range, output).run();
}

}  // namespace proximity_server::tools
