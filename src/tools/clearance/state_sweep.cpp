#include "tools/clearance/state_sweep.h"

#include <algorithm>
#include <map>
#include <memory>
#include <optional>
#include <utility>

#include "proximity_server/scene/batch/scene_batch.h"
#include "proximity_server/scene/levels/clearance_level.h"
#include "system/pipeline.h"

namespace proximity_server::tools {
namespace {

SummaryKind summaryKindOf(const PairSelection& selection) {
  return selection.kind == PairSelection::Kind::Any ? SummaryKind::Verdicts : SummaryKind::Distances;
}

bool isKnown(const scene::PairProximity& pair) {
  return isNamed(pair.asked) && pair.result.status != narrowphase::Status::Unknown;
}

SummaryCounter::Closest closestOf(std::uint64_t state, int number, const scene::PairProximity& pair) {
  return {state, number, pair.result.distance, pair.result.lower_bound, pair.result.upper_bound};
}

/// The closest of the pairs that have an answer, as `all` lists them in another order; nullptr: none has.
const scene::PairProximity* closestKnown(const scene::PairProximity* begin, const scene::PairProximity* end) {
  const scene::PairProximity* closest = nullptr;
  for (const scene::PairProximity* pair = begin; pair != end; ++pair)
    if (isKnown(*pair) && (!closest || pair->result.distance < closest->result.distance)) closest = pair;
  return closest;
}

/// Counts the level of a state, where the pairs that are listed tell it: all, or the one that sets it.
void addLevel(const scene::PairProximity* begin, const scene::PairProximity* end, const PairSelection& selection,
              const std::optional<scene::LevelThresholds>& thresholds, SummaryCounter& counter) {
  if (!thresholds || (selection.kind != PairSelection::Kind::Minimum && selection.kind != PairSelection::Kind::All))
    return;
  scene::ClearanceLevel worst = scene::ClearanceLevel::Clear;
  for (; begin != end; ++begin) worst = std::max(worst, levelOf(*begin, *thresholds).level);
  counter.addLevel(worst);
}

/// Answers by Scene, state by state in the calling thread: for all that SceneBatch does not know.
class SceneSweep {
 public:
  SceneSweep(const ClearanceQuestion& question, const StateQuestion& state_question, const SweepOutput& output)
      : question_(question),
        state_question_(state_question),
        output_(output),
        counter_(summaryKindOf(state_question.selection)) {}

  SweepSummary run(StateSource& states, const StateRange& range) {
    answerStates(question_, state_question_, states, range, [&](const StateClearance& answer) { add(answer); });
    return counter_.summary(question_.model->robot, [&](int pair) { return names_[static_cast<std::size_t>(pair)]; });
  }

 private:
  void add(const StateClearance& answer) {
    if (state_question_.selection.kind == PairSelection::Kind::Any) {
      addVerdict(answer);
    } else {
      addPairs(answer);
    }
    output_.write(rows_);
    rows_.clear();
    if (output_.judge) output_.judge(answer);
    if (output_.listed) output_.listed(answer);
    output_.count(1);
  }

  void addVerdict(const StateClearance& answer) {
    const bool is_below = !answer.pairs.empty() && isKnown(answer.pairs.front());
    const Verdict verdict = is_below                            ? Verdict::Below
                            : answer.smallest.unknown_pairs > 0 ? Verdict::Unknown
                                                                : Verdict::Above;
    const scene::ShapeRefPair pair = is_below ? answer.pairs.front().asked : scene::ShapeRefPair{};
    const auto state = static_cast<std::uint64_t>(answer.state);
    output_.rows.addVerdict(state, verdict, pair, answer.objects.get(), rows_);
    if (verdict == Verdict::Above) return counter_.addUnlisted();
    if (verdict == Verdict::Unknown) return counter_.addUnknown();
    counter_.add({state, numberOf(pair, answer)}, [&] { return answer.positions; });
  }

  void addPairs(const StateClearance& answer) {
    const auto state = static_cast<std::uint64_t>(answer.state);
    for (const scene::PairProximity& pair : answer.pairs) {
      output_.rows.addPair(state, pair, answer.objects.get(), rows_);
      if (output_.plot_rows) output_.plot_rows->addPair(state, pair, answer.objects.get(), plot_rows_);
    }
    if (output_.plot_rows) output_.plot(std::exchange(plot_rows_, {}));
    const scene::PairProximity* closest = closestKnown(answer.pairs.data(), answer.pairs.data() + answer.pairs.size());
    const bool is_known = answer.smallest.unknown_pairs == 0;
    if (is_known && closest) {
      counter_.add(closestOf(state, numberOf(closest->asked, answer), *closest), [&] { return answer.positions; });
      addLevel(answer.pairs.data(), answer.pairs.data() + answer.pairs.size(), state_question_.selection,
               question_.thresholds, counter_);
    } else if (is_known && answer.pairs.empty()) {
      counter_.addUnlisted();
    } else {
      counter_.addUnknown();
    }
  }

  /// Pairs are numbered as they come, because objects come and go.
  int numberOf(const scene::ShapeRefPair& pair, const StateClearance& answer) {
    const scene::RobotModel& robot = question_.model->robot;
    const SweepSummary::Names names{nameOf(pair.a, robot, answer.objects.get()),
                                    nameOf(pair.b, robot, answer.objects.get())};
    const auto [place, is_new] = numbers_.emplace(names, static_cast<int>(names_.size()));
    if (is_new) names_.push_back(names);
    return place->second;
  }

  const ClearanceQuestion& question_;
  const StateQuestion& state_question_;
  const SweepOutput& output_;
  SummaryCounter counter_;
  WrittenRows rows_, plot_rows_;
  std::map<SweepSummary::Names, int> numbers_;
  std::vector<SweepSummary::Names> names_;
};

/// States that lie side by side, and their rows.
struct StateBlock {
  std::uint64_t first = 0;
  int size = 0;
  Eigen::MatrixXd positions;
  WrittenRows rows, plot_rows;
  std::vector<StateClearance> judged, listed;
};

/// So many that taking turns costs nothing beside the answers, and so few that a block stays in the cache of a core.
constexpr int kBlockOfBatch = 2048;

/// Answers by SceneBatch, in blocks that threads take.
class BatchSweep {
 public:
  BatchSweep(const ClearanceQuestion& question, const StateQuestion& state_question, const SweepOutput& output)
      : question_(question), state_question_(state_question), output_(output), batch_(question.model) {
    for (int i = 0; i < question.threads; ++i)
      workers_.push_back({batch_.twin(), SummaryCounter(summaryKindOf(state_question.selection)), {}});
  }

  SweepSummary run(StateSource& states, const StateRange& range) {
    if (range.begin > 0) states.skipTo(range.begin);
    std::uint64_t next = range.begin;
    system::runPipeline<StateBlock>(
        {[&](StateBlock& block) { return read(states, range, next, block); },
         [&](StateBlock& block, int thread) { answer(block, workers_[static_cast<std::size_t>(thread)]); },
         [&](StateBlock& block) { write(block); }},
        {question_.threads});
    SweepSummary summary;
    summary.kind = summaryKindOf(state_question_.selection);
    for (const Worker& worker : workers_)
      summary.add(worker.counter.summary(question_.model->robot, [&](int pair) { return namesOf(pair); }));
    return summary;
  }

 private:
  struct Worker {
    scene::SceneBatch batch;
    SummaryCounter counter;
    scene::Positions positions;  ///< scratch
  };
  struct Listed {
    const scene::PairProximity* begin;
    const scene::PairProximity* end;
    bool is_known;
  };

  bool read(StateSource& states, const StateRange& range, std::uint64_t& next, StateBlock& block) const {
    const auto joints = static_cast<Eigen::Index>(question_.model->robot.joints.size());
    if (block.positions.rows() == 0) block.positions.resize(kBlockOfBatch, joints);
    const auto wanted = static_cast<Eigen::Index>(std::min<std::uint64_t>(range.end - next, kBlockOfBatch));
    if (wanted == 0) return false;
    block.size = states.read(block.positions.topRows(wanted));
    block.first = next;
    next += static_cast<std::uint64_t>(block.size);
    if (block.size == 0 && range.end != kToTheEnd) refuseEnd(states, next, range);
    return block.size > 0;
  }

  void answer(StateBlock& block, Worker& worker) const {
    block.rows.clear();
    block.plot_rows.clear();
    block.judged.clear();
    block.listed.clear();
    const scene::States states = block.positions.topRows(block.size);
    switch (state_question_.selection.kind) {
      case PairSelection::Kind::Any:
        addVerdicts(worker.batch.anyBelow(states, state_question_.selection.threshold), block, worker);
        break;
      case PairSelection::Kind::Below:
        addLists(worker.batch.below(states, state_question_.selection.threshold), block, worker);
        break;
      case PairSelection::Kind::Closest:
        addLists(worker.batch.closest(states, state_question_.selection.count), block, worker);
        break;
      case PairSelection::Kind::Minimum:
      case PairSelection::Kind::All:  // is not answered here
        addMinima(
            question_.thresholds ? worker.batch.deciding(states, *question_.thresholds) : worker.batch.minimum(states),
            block, worker);
        break;
    }
    if (output_.judge && !listsSmallest(state_question_.selection, question_))
      judge(worker.batch.minimum(states), block);
  }

  void addVerdicts(const std::vector<scene::StateVerdict>& verdicts, StateBlock& block, Worker& worker) const {
    for (int i = 0; i < block.size; ++i) {
      const scene::StateVerdict& found = verdicts[static_cast<std::size_t>(i)];
      const std::uint64_t state = block.first + static_cast<std::uint64_t>(i);
      const Verdict verdict = verdictOf(found);
      output_.rows.addVerdict(state, verdict, found.pair, block.rows);
      if (verdict == Verdict::Above) {
        worker.counter.addUnlisted();
      } else if (verdict == Verdict::Unknown) {
        worker.counter.addUnknown();
      } else {
        worker.counter.add({state, found.pair}, [&] { return positionsOf(block, i, worker); });
      }
    }
  }

  static Verdict verdictOf(const scene::StateVerdict& found) {
    switch (found.kind) {
      case scene::StateVerdict::Kind::Above:
        return Verdict::Above;
      case scene::StateVerdict::Kind::Below:
        return Verdict::Below;
      case scene::StateVerdict::Kind::Unknown:
        break;
    }
    return Verdict::Unknown;
  }

  void addMinima(const std::vector<scene::PairProximity>& minima, StateBlock& block, Worker& worker) const {
    for (int i = 0; i < block.size; ++i) {
      const scene::PairProximity* pair = &minima[static_cast<std::size_t>(i)];
      addState(i, {pair, pair + 1, isNamed(pair->asked)}, block, worker);
    }
  }

  void addLists(const scene::StatePairs& lists, StateBlock& block, Worker& worker) const {
    const scene::PairProximity no_answer;  // has a row too, as no row says that no pair is listed
    for (int i = 0; i < block.size; ++i) {
      const auto state = static_cast<std::size_t>(i);
      const scene::PairProximity* pairs = lists.pairs.data();
      if (lists.unknown[state] != 0)
        addState(i, {&no_answer, &no_answer + 1, false}, block, worker);
      else
        addState(i, {pairs + lists.begins[state], pairs + lists.begins[state + 1], true}, block, worker);
    }
  }

  void addState(int i, const Listed& listed, StateBlock& block, Worker& worker) const {
    const std::uint64_t state = block.first + static_cast<std::uint64_t>(i);
    for (const scene::PairProximity* pair = listed.begin; pair != listed.end; ++pair) {
      output_.rows.addPair(state, *pair, nullptr, block.rows);
      if (output_.plot_rows) output_.plot_rows->addPair(state, *pair, nullptr, block.plot_rows);
    }
    const scene::PairProximity* closest = closestKnown(listed.begin, listed.end);
    if (listed.is_known && closest) {
      worker.counter.add(closestOf(state, output_.rows.numbers().of(closest->asked), *closest),
                         [&] { return positionsOf(block, i, worker); });
      addLevel(listed.begin, listed.end, state_question_.selection, question_.thresholds, worker.counter);
    } else if (listed.is_known && listed.begin == listed.end) {
      worker.counter.addUnlisted();
    } else {
      worker.counter.addUnknown();
    }
    if (output_.judge && listsSmallest(state_question_.selection, question_))
      addJudged(i, {listed.begin, listed.end}, listed.is_known, block);
    if (output_.listed) {
      block.listed.emplace_back();
      block.listed.back().state = static_cast<long>(state);
      block.listed.back().pairs.assign(listed.begin, listed.end);
      block.listed.back().positions = positionsOf(block, i);
    }
  }

  void judge(const std::vector<scene::PairProximity>& minima, StateBlock& block) const {
    for (int i = 0; i < block.size; ++i) {
      const scene::PairProximity& pair = minima[static_cast<std::size_t>(i)];
      addJudged(i, {pair}, isNamed(pair.asked), block);
    }
  }

  void addJudged(int i, const std::vector<scene::PairProximity>& pairs, bool is_known, StateBlock& block) const {
    StateClearance answer;
    answer.state = static_cast<long>(block.first) + i;
    answer.smallest = smallestOf(pairs, is_known ? 0 : static_cast<int>(question_.pairs.size()));
    answer.positions = positionsOf(block, i);
    block.judged.push_back(std::move(answer));
  }

  static scene::Positions positionsOf(const StateBlock& block, int i) {
    scene::Positions positions(static_cast<std::size_t>(block.positions.cols()));
    for (std::size_t j = 0; j < positions.size(); ++j) positions[j] = block.positions(i, static_cast<Eigen::Index>(j));
    return positions;
  }
  static const scene::Positions& positionsOf(const StateBlock& block, int i, Worker& worker) {
    return worker.positions = positionsOf(block, i);
  }

  void write(const StateBlock& block) const {
    output_.write(block.rows);
    if (output_.plot_rows) output_.plot(block.plot_rows);
    for (const StateClearance& answer : block.judged) output_.judge(answer);
    for (const StateClearance& answer : block.listed) output_.listed(answer);
    output_.count(static_cast<std::uint64_t>(block.size));
  }

  SweepSummary::Names namesOf(int pair) const {
    const scene::ShapeRefPair& links = question_.pairs[static_cast<std::size_t>(pair)];
    const scene::RobotModel& robot = question_.model->robot;
    return {nameOf(links.a, robot), nameOf(links.b, robot)};
  }

  const ClearanceQuestion& question_;
  const StateQuestion& state_question_;
  const SweepOutput& output_;
  scene::SceneBatch batch_;
  std::vector<Worker> workers_;
};

/// Whether SceneBatch knows the question. Its candidates are then the pairs of the question, in their order.
bool isForBatch(const ClearanceQuestion& question, const StateQuestion& state_question) {
  return question.filter == PairFilter::On && !question.objects && state_question.skipping == scene::Skipping::On &&
         state_question.selection.kind != PairSelection::Kind::All;
}

}  // namespace

SweepSummary sweepStates(const ClearanceQuestion& question, const StateQuestion& state_question, StateSource& states,
                         const StateRange& range, const SweepOutput& output) {
  if (isForBatch(question, state_question)) return BatchSweep(question, state_question, output).run(states, range);
  return SceneSweep(question, state_question, output).run(states, range);
}

}  // namespace proximity_server::tools
