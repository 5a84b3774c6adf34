// How close a robot is to itself and to objects in recorded or planned states, without a ROS master.
#include <unistd.h>
#include <CLI/CLI.hpp>

#include <cerrno>
#include <cstdint>
#include <fstream>
#include <iostream>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>

#include "proximity_server/scene/levels/level_thresholds.h"
#include "proximity_server/scene/mesh/mesh_resolver.h"
#include "proximity_server/scene/object_files/object_file.h"
#include "proximity_server/scene/pieces/convex_pieces.h"
#include "tools/clearance/clearance_assertion.h"
#include "tools/clearance/clearance_options.h"
#include "tools/clearance/clearance_rows.h"
#include "tools/clearance/clearance_run.h"
#include "tools/clearance/joint_list.h"
#include "tools/clearance/object_schedule.h"
#include "tools/clearance/state_rows.h"
#include "tools/clearance/state_sweep.h"
#include "tools/clearance/sweep_files.h"
#include "tools/clearance/trajectory_run.h"
#include "tools/command_line/answer_counter.h"
#include "tools/command_line/csv.h"
#include "tools/command_line/output_file.h"
#include "tools/command_line/plot_script.h"
#include "tools/command_line/robot_files.h"
#include "tools/command_line/tool_main.h"
#include "tools/second_opinion/second_opinion.h"
#include "tools/states/state_options.h"
#include "tools/sweep/sweep_options.h"

namespace proximity_server::tools {
namespace {

/// Writes rows to a stream, and the text before, between and after them.
class RowWriter {
 public:
  /// `name` is that of the file, for messages. This and the functions throw std::invalid_argument if writing fails.
  RowWriter(std::ostream& stream, std::string name, OutputFormat format)
      : stream_(stream), name_(std::move(name)), format_(std::move(format)) {
    put(format_.begin);
  }

  void write(const WrittenRows& rows) {
    if (rows.rows == 0) return;
    put(has_row_ ? format_.between : format_.before_first);
    put(rows.bytes);
    has_row_ = true;
  }

  void end() {
    put(format_.end);
    flushTo(stream_, name_);
  }

  std::uint64_t bytes() const { return bytes_; }

 private:
  void put(const std::string& text) {
    writeTo(stream_, name_, text);
    bytes_ += text.size();
  }

  std::ostream& stream_;
  const std::string name_;
  OutputFormat format_;
  bool has_row_ = false;
  std::uint64_t bytes_ = 0;
};

/// Opens the named file; returns standard output if there is no name.
std::ostream& openOutput(const std::string& path, std::optional<std::ofstream>& file) {
  if (path.empty()) return std::cout;
  errno = 0;
  file.emplace(path, std::ofstream::binary);
  const int cause = errno;
  if (!*file) throw std::invalid_argument(path + ": cannot be opened" + because(cause));
  return *file;
}

std::shared_ptr<ObjectSchedule> scheduleOf(const ClearanceOptions& options,
                                           const std::shared_ptr<const scene::SceneModel>& model) {
  if (options.objects.empty()) return nullptr;
  scene::ObjectOptions how;
  how.resolve = scene::packageResolver(scene::rosPackagePath());
  if (options.robot.mesh_tolerance) how.meshes.tolerance = *options.robot.mesh_tolerance;
  how.meshes.cache = scene::userMeshCache();
  auto schedule = std::make_shared<ObjectSchedule>(model, scene::readObjectFile(options.objects), how);
  printWarnings(schedule->warnings(), options.robot.warnings);
  return schedule;
}

std::optional<scene::LevelThresholds> thresholdsOf(const ClearanceOptions& options, const scene::RobotModel& robot) {
  if (options.thresholds.empty()) return std::nullopt;
  const scene::ThresholdFile file = scene::thresholdsFrom(readTextFile(options.thresholds), options.thresholds);
  const std::string srdf = options.robot.srdf.empty() ? "" : readTextFile(options.robot.srdf);
  try {
    return scene::levelThresholds(robot, {srdf}, file.rules, file.defaults);
  } catch (const std::invalid_argument& error) {
    throw std::invalid_argument(options.thresholds + ": " + error.what());
  }
}

ClearanceQuestion questionOf(const ClearanceOptions& options) {
  ClearanceQuestion question;
  question.model = loadSceneModel(options.robot);
  printWarningsOf(*question.model, options.robot.warnings);
  question.thresholds = thresholdsOf(options, question.model->robot);
  question.filter = options.filter;
  const bool is_filtered = options.filter == PairFilter::On;
  question.pairs = is_filtered ? filteredPairs(*question.model) : unfilteredPairs(*question.model);
  question.objects = scheduleOf(options, question.model);
  if (question.objects && is_filtered) question.candidates.emplace(question.model->pairs);
  if (question.pairs.empty() && !question.objects)
    throw std::invalid_argument(options.robot.urdf + ": no pair of links is checked");
  question.threads = options.threads;
  return question;
}

Sweep sweepOf(const ClearanceOptions& options, const ClearanceQuestion& question) {
  const Smallest smallest = options.assert_above ? Smallest::Always : Smallest::IfListed;
  return {question,
          {readPairSelection(options.pairs), options.skipping, smallest},
          options.format,
          options.objects,
          options.thresholds};
}

/// Prints the warnings that are known before the first state.
void warn(const StateSource& states, const ClearanceOptions& options, const ObjectSchedule* objects) {
  printWarnings(states.warnings(), options.robot.warnings);
  if (options.rows == RowKind::Segment) return;
  const bool objects_have_times = objects && objects->hasTimes();
  if (objects_have_times && !states.hasTimes()) {
    throw std::invalid_argument(states.source() + ": there is no column \"time\", and objects change at a time");
  }
  const bool has_column = states.hasTimes() && options.states.bag.file.empty();  // a bag has times in any case
  if (has_column && !objects_have_times) {
    printWarnings({states.source() + ": column \"time\" is not used without --trajectory."}, options.robot.warnings);
  }
}

/// Prints the warnings that are known after the last state.
void warnAtTheEnd(const StateSource& states, const ClearanceOptions& options, const ObjectSchedule* objects) {
  printWarnings({states.limitWarning(), objects ? objects->leftOver() : ""}, options.robot.warnings);
}

std::string checkedPairs(const ClearanceQuestion& question) {
  if (question.objects) return "all pairs, of links and with objects,";
  return "all " + std::to_string(question.pairs.size()) + " pairs";
}

OutputFormat formatOf(const ClearanceOptions& options, RowFormat format) {
  const LevelColumn levels = options.thresholds.empty() ? LevelColumn::Without : LevelColumn::With;
  if (options.rows == RowKind::State) return StateRows::format(readPairSelection(options.pairs), format, 0, levels);
  return {format == RowFormat::Csv ? "csv" : "json",
          rowsBegin(RowKind::Segment, format),
          "\n",
          rowsSeparator(format),
          rowsEnd(format),
          ""};
}

/// Writes the answers to the output and the plot, and adds them to the assertion.
class Answers {
 public:
  Answers(const ClearanceOptions& options, const ClearanceQuestion& question, std::ostream& out,
          const std::string& out_name, PlotScript* plot)
      : options_(options), question_(question), writer_(out, out_name, formatOf(options, options.format)) {
    const scene::RobotModel& robot = question.model->robot;
    if (plot) plot_writer_.emplace(plot->data(), "the data of the plot", formatOf(options, RowFormat::Csv));
    if (options.second_opinion.is_wanted) second_opinion_.emplace(options.second_opinion, question.model);
    if (!options.assert_above) return;
    assertion_.emplace(*options.assert_above, options.rows, robot, checkedPairs(question));
  }

  /// Answers about all states or segments, in their order.
  void addAll(StateSource& states, AnswerCounter& counter) {
    if (options_.rows == RowKind::State) {
      addStates(states, counter);
    } else {
      answerSegments(question_, options_.motion, states, [&](const SegmentClearance& answer) {
        add(answer);
        counter.count(1);
      });
    }
  }

  /// Writes the end of the rows, so that the output is a complete document.
  void end() {
    writer_.end();
    if (plot_writer_) plot_writer_->end();
    if (second_opinion_) second_opinion_->end();
  }

  const std::optional<ClearanceAssertion>& assertion() const { return assertion_; }
  const std::optional<SecondOpinion>& secondOpinion() const { return second_opinion_; }
  const SweepSummary& summary() const { return summary_; }
  std::uint64_t bytes() const { return writer_.bytes(); }

 private:
  void addStates(StateSource& states, AnswerCounter& counter) {
    const Sweep sweep = sweepOf(options_, question_);
    const PairSelection& selection = sweep.state_question.selection;
    const StateRows rows(selection, options_.format, question_);
    const StateRows plot_rows(selection, RowFormat::Csv, question_);
    SweepOutput output{rows, [&](const WrittenRows& written) { writer_.write(written); },
                       [&](std::uint64_t count) { counter.count(count); }};
    if (plot_writer_) {
      output.plot_rows = &plot_rows;
      output.plot = [&](const WrittenRows& written) { plot_writer_->write(written); };
    }
    if (assertion_) output.judge = [&](const StateClearance& answer) { assertion_->add(answer); };
    if (second_opinion_)
      output.listed = [&](const StateClearance& answer) {
        second_opinion_->add(answer.state, answer.pairs, answer.positions, answer.objects);
      };
    summary_ = sweepStates(question_, sweep.state_question, states, {0, kToTheEnd}, output);
  }

  void add(const SegmentClearance& answer) {
    const scene::RobotModel& robot = question_.model->robot;
    writer_.write({rowText(answer, robot, options_.format), 1});
    if (plot_writer_) plot_writer_->write({rowText(answer, robot, RowFormat::Csv), 1});
    if (assertion_) assertion_->add(answer);
  }

  const ClearanceOptions& options_;
  const ClearanceQuestion& question_;
  RowWriter writer_;
  std::optional<RowWriter> plot_writer_;
  std::optional<ClearanceAssertion> assertion_;
  std::optional<SecondOpinion> second_opinion_;
  SweepSummary summary_;
};

/// The number of answers that are to come, if it is known without reading all states and somebody watches.
std::optional<std::uint64_t> totalOf(const StateSource& states, RowKind rows) {
  if (isatty(STDERR_FILENO) == 0) return std::nullopt;
  const std::optional<std::uint64_t> count = states.count();
  return count && rows == RowKind::Segment && *count > 0 ? *count - 1 : count;
}

void answerInto(Answers& answers, const ClearanceOptions& options, const ClearanceQuestion& question,
                StateSource& states) {
  AnswerCounter counter(options.rows == RowKind::State ? "states" : "segments", totalOf(states, options.rows));
  const auto end = [&] {
    counter.clear();
    answers.end();
    warnAtTheEnd(states, options, question.objects.get());
  };
  try {
    answers.addAll(states, counter);
  } catch (const std::exception&) {
    try {
      end();
    } catch (const std::exception&) {  // the first failure is the one to report
    }
    throw;
  }
  end();
}

/// Writes the summary if it is asked for, and says what the run took.
void summarize(const ClearanceOptions& options, const SweepSummary& summary, const CoreTime& time,
               std::uint64_t bytes) {
  if (!options.sweep.summary.empty()) writeSummary(summary, options.sweep.summary);
  std::cerr << "clearance: " << summary.text() << "\n  " << time.text(summary.states, bytes) << '\n';
}

ExitCode judge(const ClearanceAssertion& assertion, const StateSource& states) {
  if (!assertion.hasRows()) {
    throw std::invalid_argument(states.source() + ": no state, so --assert-above proves nothing");
  }
  std::cerr << "clearance: " << assertion.report() << '\n';
  return assertion.holds() ? ExitCode::Done : ExitCode::AssertionFails;
}

ExitCode runParts(const ClearanceOptions& options, const ClearanceQuestion& question, StateSource& states) {
  computePart(sweepOf(options, question), options.sweep, states, options.out);
  warnAtTheEnd(states, options, question.objects.get());
  return ExitCode::Done;
}

ExitCode runNpy(const ClearanceOptions& options, const ClearanceQuestion& question, StateSource& states) {
  const CoreTime time;
  AnswerCounter counter("states", totalOf(states, RowKind::State));
  std::uint64_t bytes = 0;
  const SweepSummary summary = computeNpy(sweepOf(options, question), states, options.out, counter, bytes);
  warnAtTheEnd(states, options, nullptr);
  summarize(options, summary, time, bytes);
  return ExitCode::Done;
}

ExitCode run(const ClearanceOptions& options) {
  requireConsistent(options);
  if (!options.sweep.merge.empty()) {
    mergeParts(options.sweep, options.out);
    return ExitCode::Done;
  }
  if (options.list) {
    writeTo(std::cout, "standard output", jointList(loadJoints(options.robot)));
    flushTo(std::cout, "standard output");
    return ExitCode::Done;
  }
  std::optional<PlotScript> plot;
  if (!options.plot.empty()) plot.emplace("clearance_plot.py", options.plot);
  if (!options.sweep.summary.empty()) requireWritable(options.sweep.summary);
  requireReadable(options.states);
  const ClearanceQuestion question = questionOf(options);
  const std::unique_ptr<StateSource> states = openStates(options.states, question.model->robot);
  warn(*states, options, question.objects.get());
  if (options.sweep.isPart()) return runParts(options, question, *states);
  if (options.format == RowFormat::Npy) return runNpy(options, question, *states);

  const CoreTime time;
  std::optional<std::ofstream> out_file;
  std::ostream& out = openOutput(options.out, out_file);
  Answers answers(options, question, out, out_file ? options.out : "standard output", plot ? &*plot : nullptr);
  answerInto(answers, options, question, *states);
  if (plot) plot->draw({numberText(options.motion.contact_distance)});
  if (!options.sweep.summary.empty()) summarize(options, answers.summary(), time, answers.bytes());
  if (const auto& second = answers.secondOpinion()) {
    std::cerr << "clearance: " << second->summary() << '\n';
    if (second->refutesOurs()) return ExitCode::Refuted;
  }
  return answers.assertion() ? judge(*answers.assertion(), *states) : ExitCode::Done;
}

}  // namespace
}  // namespace proximity_server::tools

int main(int argc, char** argv) {
  CLI::App app(
      "How close a robot is to itself, and to objects, in recorded or planned states, and between them; lengths in "
      "metres, in "
      "the root link's frame",
      "clearance");
  proximity_server::tools::ClearanceOptions options;
  proximity_server::tools::declareClearance(app, options);
  return proximity_server::tools::runTool(app, argc, argv, [&] { return proximity_server::tools::run(options); });
}
