#include "tools/clearance/state_sweep.h"

#include "proximity_server/scene/levels/clearance_level.h"
#include "system/numbers.h"
#include "system/pipeline.h"
#include "tools/clearance/clearance_rows.h"
#include "tools/clearance/state_answers.h"
#include "tools/robot/robot_text.h"

#include <algorithm>
#include <exception>
#include <memory>
#include <stdexcept>

namespace proximity_server::tools {
namespace {

/// So many that taking turns costs nothing beside the answers, and so few that a block stays in the cache of a core.
constexpr int kBlockOfBatch = 2048;

/// So many that the cold start is a small part of the work.
constexpr int kBlockOfScene = 256;

/// As many states as have so many points together.
int blockOfPoints(const scene::Points& points) {
  return static_cast<int>(std::max<std::size_t>(1, kBlockOfBatch / points.centres.size()));
}

/// A block with its rows.
struct AnsweredBlock : StateBlock {
  WrittenRows rows, plot_rows;
  std::vector<ClearanceAnswer> answers;  ///< for the assertion, the second opinion and the report
};

bool isKnown(const scene::PairProximity& pair) {
  return isNamed(pair.asked) && pair.result.status != narrowphase::Status::Unknown;
}

/// The closest of the pairs that have an answer, as `all` lists them in another order; nullptr: none has.
const scene::PairProximity* closestKnown(const StateAnswer& listed) {
  const scene::PairProximity* closest = nullptr;
  for (const scene::PairProximity* pair = listed.begin; pair != listed.end; ++pair)
    if (isKnown(*pair) && (!closest || pair->result.distance < closest->result.distance)) closest = pair;
  return closest;
}

class StateSweep {
 public:
  StateSweep(const ClearanceQuestion& question, StateSource& states, const StateRange& range, AnswerOutput& output)
      : question_(question),
        kind_(question.selection.kind),
        all_pairs_(question),
        states_(states),
        range_(range),
        output_(output),
        rows_(question, output.format),
        plot_rows_(question, RowFormat::Csv),
        block_size_(question.points                          ? blockOfPoints(*question.points)
                    : isForBatch(question) && !output.report ? kBlockOfBatch
                                                             : kBlockOfScene) {
    all_pairs_.selection = {};
    all_pairs_.selection.kind = PairSelection::Kind::All;
    answers_ = answersOfThreads(question, output.assertion ? WantsClosest::Yes : WantsClosest::No);
    if (output.report) for_report_ = answersOfThreads(all_pairs_, WantsClosest::No);
    counters_.assign(answers_.size(), SummaryCounter(summaryKind()));
    next_ = isForBatch(question) ? range.begin : range.begin / kBlockOfScene * kBlockOfScene;
    if (question.objects) next_ = 0;  // they change on the way there
  }

  SweepSummary run() {
    if (next_ > 0) states_.skipTo(next_);
    constexpr int kLists = 1, kStates = 4;  // blocks for each thread: lists of all pairs are large
    system::runPipeline<AnsweredBlock>(
        {[&](AnsweredBlock& block) { return read(block); },
         [&](AnsweredBlock& block, int thread) { answer(block, thread); }, [&](AnsweredBlock& block) { write(block); }},
        {question_.threads, system::PipelineThreads::TooFew::Refused, block_size_ == kBlockOfBatch ? kStates : kLists});
    SweepSummary summary;
    summary.kind = summaryKind();
    for (const SummaryCounter& counter : counters_)
      summary.add(
          counter.summary(question_.model->robot, [&](int pair) { return namesOf(question_.pairs[pair], nullptr); }));
    return summary;
  }

 private:
  SummaryKind summaryKind() const {
    return kind_ == PairSelection::Kind::Any ? SummaryKind::Verdicts : SummaryKind::Distances;
  }

  /// Reads the next block; an error of reading ends it, and is thrown by the next call.
  bool read(AnsweredBlock& block) {
    question_.budget.require();
    if (block.positions.rows() == 0)
      block.positions.resize(block_size_, static_cast<Eigen::Index>(question_.model->robot.joints.size()));
    const auto wanted =
        static_cast<Eigen::Index>(std::min(range_.end - next_, static_cast<std::uint64_t>(block_size_)));
    if (wanted == 0) return false;
    block.first = next_;
    block.objects.clear();
    block.times.clear();
    block.size = 0;
    if (error_) std::rethrow_exception(error_);
    try {
      for (; block.size < wanted && states_.next(state_); ++block.size, ++next_) {
        for (Eigen::Index i = 0; i < block.positions.cols(); ++i) block.positions(block.size, i) = state_.positions[i];
        block.times.push_back(state_.time);
        if (!question_.objects) continue;
        question_.objects->advance(static_cast<long>(next_), state_.time, state_.positions);
        block.objects.push_back(question_.objects->now());
      }
    } catch (const std::invalid_argument&) {
      if (block.size == 0) throw;
      error_ = std::current_exception();
    }
    if (block.size == 0 && range_.end != kToTheEnd)
      throw std::invalid_argument(states_.header().source + ": ends after " + std::to_string(next_) +
                                  " states, before those of " + textOf(range_));
    return block.size > 0;
  }

  void answer(AnsweredBlock& block, int thread) {
    block.rows.clear();
    block.plot_rows.clear();
    block.answers.clear();
    if (block.first + static_cast<std::uint64_t>(block.size) <= range_.begin) return;
    answers_[thread]->answer(block,
                             [&](int i, const StateAnswer& answer) { add(i, answer, block, counters_[thread]); });
    if (output_.report)
      for_report_[thread]->answer(block, [&](int i, const StateAnswer& all) { addAll(i, all, block); });
    question_.budget.require();
  }

  /// Adds the answer about a state to the rows, the summary, and what is asked further.
  void add(int i, const StateAnswer& listed, AnsweredBlock& block, SummaryCounter& counter) const {
    const std::uint64_t state = block.first + static_cast<std::uint64_t>(i);
    if (state < range_.begin) return;
    const scene::Objects* const objects = block.objects.empty() ? nullptr : block.objects[i].get();
    addRows(state, listed, objects, block);
    count(i, state, listed, objects, block, counter);
    if (!output_.assertion && !output_.second_opinion && !output_.report) return;
    ClearanceAnswer& answer = block.answers.emplace_back();
    answer.number = static_cast<long>(state);
    answer.objects = block.objectsOf(i);
    if (listed.closest) {
      answer.closest.pair = listed.closest->pair;
      answer.closest.status = listed.closest->pair.result.status;
      answer.unknown_pairs = listed.closest->unknown_pairs;
    }
    answer.closest.time = block.times[i];
    answer.closest.positions = block.positionsOf(i);
    if (output_.second_opinion && !isOpen(listed)) answer.listed.assign(listed.begin, listed.end);
  }

  /// Adds all pairs of a state for the report, which are answered by a scene of its own, so that the rows keep their
  /// bytes. A report goes without a range, so each state of the block has an answer.
  static void addAll(int i, const StateAnswer& all, AnsweredBlock& block) {
    ClearanceAnswer& answer = block.answers[i];
    for (const scene::PairProximity* pair = all.begin; pair != all.end; ++pair) {
      answer.of_pairs.push_back({*pair, pair->result.status, answer.closest.time, answer.closest.positions});
      if (all.guaranteed) answer.of_pairs.back().pair.result.lower_bound = all.guaranteed[pair - all.begin];
    }
  }

  /// Whether unknown pairs leave open what is to be listed.
  bool isOpen(const StateAnswer& listed) const {
    return listed.unknown > 0 && kind_ != PairSelection::Kind::All && kind_ != PairSelection::Kind::Any;
  }

  void addRows(std::uint64_t state, const StateAnswer& listed, const scene::Objects* objects,
               AnsweredBlock& block) const {
    if (kind_ == PairSelection::Kind::Any) {
      const scene::PairProximity* const below = closestKnown(listed);
      const Verdict verdict = below ? Verdict::Below : listed.unknown > 0 ? Verdict::Unknown : Verdict::Above;
      return rows_.addVerdict(state, verdict, below ? below->asked : scene::ShapeRefPair{}, objects, block.rows);
    }
    scene::PairProximity no_answer;  // has a row too, as no row says that no pair is listed
    if (question_.points) no_answer.asked.b = scene::ShapeRef::ofPoint(-1);
    const StateAnswer written = isOpen(listed) ? StateAnswer{&no_answer, &no_answer + 1} : listed;
    for (const scene::PairProximity* pair = written.begin; pair != written.end; ++pair) {
      const double guaranteed = written.guaranteed ? written.guaranteed[pair - written.begin] : kNaN;
      rows_.addPair(state, *pair, guaranteed, objects, block.rows);
      if (output_.plot) plot_rows_.addPair(state, *pair, guaranteed, objects, block.plot_rows);
    }
  }

  void count(int i, std::uint64_t state, const StateAnswer& listed, const scene::Objects* objects,
             const StateBlock& block, SummaryCounter& counter) const {
    const scene::PairProximity* const closest = closestKnown(listed);
    const bool is_any = kind_ == PairSelection::Kind::Any;
    if (closest && (is_any || listed.unknown == 0)) {
      NumberedPair counted{state, rows_.numberOf(closest->asked)};
      if (!is_any) {
        counted.distance = closest->result.distance;
        counted.lower = closest->result.lower_bound;
        counted.upper = closest->result.upper_bound;
      }
      counter.add(
          counted, [&] { return namesOf(closest->asked, objects); }, [&] { return block.positionsOf(i); });
      countLevel(listed, counter);
    } else if (listed.unknown == 0 && listed.begin == listed.end) {
      counter.addUnlisted();
    } else {
      counter.addUnknown();
    }
  }

  /// Counts the level of a state, where the pairs that are listed tell it: all, or the one that sets it.
  void countLevel(const StateAnswer& listed, SummaryCounter& counter) const {
    const auto& thresholds = question_.thresholds;
    if (!thresholds || (kind_ != PairSelection::Kind::Minimum && kind_ != PairSelection::Kind::All)) return;
    scene::ClearanceLevel worst = scene::ClearanceLevel::Clear;
    for (const scene::PairProximity* pair = listed.begin; pair != listed.end; ++pair) {
      const bool is_exact = listed.guaranteed == nullptr;
      worst = std::max(worst, is_exact ? levelOf(*pair, *thresholds).level
                                       : levelOf(*pair, listed.guaranteed[pair - listed.begin], *thresholds).level);
    }
    counter.addLevel(worst);
  }

  SweepSummary::Names namesOf(const scene::ShapeRefPair& pair, const scene::Objects* objects) const {
    const scene::RobotModel& robot = question_.model->robot;
    return {nameOf(pair.a, robot, objects), nameOf(pair.b, robot, objects)};
  }

  void write(const AnsweredBlock& block) const {
    output_.rows.write(block.rows);
    if (output_.plot) output_.plot->write(block.plot_rows);
    for (const ClearanceAnswer& answer : block.answers) output_.add(answer);
    // A block may begin before the range.
    const std::uint64_t end = block.first + static_cast<std::uint64_t>(block.size);
    output_.counter.count(end - std::min(end, std::max(block.first, range_.begin)));
  }

  const ClearanceQuestion& question_;
  const PairSelection::Kind kind_;
  ClearanceQuestion all_pairs_;  ///< the same question about all pairs, for the report
  StateSource& states_;
  scene::TrajectoryPoint state_;  ///< the one that was read last
  std::exception_ptr error_;      ///< the error of the state that ended the last block
  const StateRange range_;
  AnswerOutput& output_;
  const StateRows rows_, plot_rows_;
  const int block_size_;
  std::vector<std::unique_ptr<StateAnswers>> answers_, for_report_;  ///< one for each thread, as the counters
  std::vector<SummaryCounter> counters_;
  std::uint64_t next_ = 0;  ///< the state to be read
};

}  // namespace

void AnswerOutput::add(const ClearanceAnswer& answer) {
  if (assertion) assertion->add(answer);
  if (second_opinion) second_opinion->add(answer.number, answer.listed, answer.closest.positions, answer.objects);
  if (report) report->add(answer);
}

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
