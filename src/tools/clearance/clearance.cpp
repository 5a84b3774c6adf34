// How close a robot is to itself and to objects in recorded or planned states, without a ROS master.
#include "proximity_server/scene/configuration/robot_config.h"
#include "proximity_server/scene/loading/model_options.h"
#include "proximity_server/scene/query/question.h"
#include "tools/clearance/clearance_assertion.h"
#include "tools/clearance/clearance_options.h"
#include "tools/clearance/clearance_question.h"
#include "tools/clearance/clearance_rows.h"
#include "tools/clearance/driven_motion.h"
#include "tools/clearance/point_file.h"
#include "tools/clearance/state_sweep.h"
#include "tools/clearance/sweep_files.h"
#include "tools/clearance/trajectory_run.h"
#include "tools/program/options.h"
#include "tools/program/plot_script.h"
#include "tools/program/progress.h"
#include "tools/program/tool_main.h"
#include "tools/robot/object_schedule.h"
#include "tools/robot/robot_files.h"
#include "tools/robot/robot_text.h"
#include "tools/second_opinion/second_opinion.h"
#include "tools/states/state_options.h"
#include "tools/sweep/state_range.h"
#include "tools/sweep/sweep_manifest.h"
#include "tools/text/content_hash.h"
#include "tools/text/csv.h"
#include "tools/text/naming.h"
#include "tools/text/output_file.h"

#include <unistd.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <iostream>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace proximity_server::tools {
namespace {

scene::LevelThresholds thresholdsOf(const scene::ConfigFile& file, const std::string& path, const RobotFiles& files,
                                    const scene::RobotModel& robot) {
  const std::string srdf = srdfOf(files);
  return naming(path, [&] { return file.robot.thresholdsOf(robot, {srdf}, file.levels); });
}

/// The option because of which a question takes no levels of --config; "" if it takes them.
std::string withoutLevels(const ClearanceOptions& options) {
  const PairSelection& selection = options.question.selection;
  if (options.rows == RowKind::Segment) return "";
  if (!options.question.points_file.empty()) return "--points";
  if (options.format == RowFormat::Npy) return "--format npy";
  if (options.accuracy || selection.accuracy > 0.0) return "--accuracy";
  if (selection.kind == PairSelection::Kind::Any) return "--pairs any";
  const bool is_plot = !options.plot.empty() && selection.kind == PairSelection::Kind::Minimum;
  return is_plot ? "--plot, which shows the closest pairs, and --pairs minimum" : "";
}

/// The option because of which a question takes no uncertainty of --config; "" if it takes it.
std::string withoutUncertainty(const ClearanceOptions& options) {
  if (options.question.filter == PairFilter::Off) return "--no-filter";
  if (options.sweep.isPart()) return "--shard and --range";
  if (options.rows == RowKind::Segment) return "--trajectory";
  return withoutLevels(options);
}

/// Sets the thresholds: from --thresholds, or of --config where levels go.
void setThresholds(const ClearanceOptions& options, const scene::ConfigFile& config, ClearanceQuestion& question) {
  const RobotFiles& files = options.robot;
  const scene::RobotModel& robot = question.model->robot;
  const std::string& path = options.question.thresholds_file;
  if (!path.empty()) {
    question.thresholds = thresholdsOf(scene::thresholdsFrom(readTextFile(path), path), path, files, robot);
  } else if (!files.config.empty()) {
    const std::string without = withoutLevels(options);
    if (!without.empty())
      return printWarnings({files.config + ": there are no levels with " + without + "."}, files.warnings);
    question.thresholds = thresholdsOf(config, files.config, files, robot);
    question.thresholds_file = files.config;
  }
}

/// Sets the uncertainty: from --joint-uncertainty, or of --config where it goes.
void setUncertainty(const ClearanceOptions& options, const scene::ConfigFile& config, ClearanceQuestion& question) {
  const RobotFiles& files = options.robot;
  if (!question.uncertainty_text.empty()) {
    JointUncertainty uncertainty = uncertaintyFrom(question.uncertainty_text, question.model->robot);
    printWarnings(uncertainty.warnings, files.warnings);
    question.uncertainty = std::move(uncertainty.of_robot);
    return;
  }
  scene::Uncertainty uncertainty = config.robot.uncertaintyOf(question.model->robot, files.config);
  if (uncertainty.isZero()) return;
  const std::string without = withoutUncertainty(options);
  if (!without.empty())
    return printWarnings({files.config + ": its uncertainty is not used with " + without + "."}, files.warnings);
  question.uncertainty = std::move(uncertainty);
}

ClearanceQuestion questionOf(const ClearanceOptions& options) {
  ClearanceQuestion question = options.question;
  if (options.accuracy) question.selection.accuracy = *options.accuracy;
  if (!question.points_file.empty()) question.points = readPoints(question.points_file);
  question.model = loadSceneModel(options.robot);
  printWarningsOf(*question.model, options.robot.warnings);
  const scene::ConfigFile config = configOf(options.robot);
  setThresholds(options, config, question);
  setUncertainty(options, config, question);
  if (!question.tracking_error_text.empty()) {
    TrackingError error = trackingErrorFrom(question.tracking_error_text, question.model->robot);
    printWarnings(error.warnings, options.robot.warnings);
    question.tracking_error = std::move(error.of_joints);
  }
  if (!question.start_text.empty()) question.start = startFrom(question.start_text, question.model->robot);
  question.pairs = checkedPairs(*question.model, question.filter);
  question.objects = loadObjects(options.question.objects_file, options.robot, question.model);
  if (question.objects && question.objects_file.empty()) question.objects_file = options.robot.config;
  if (question.objects && options.format == RowFormat::Npy)
    throw std::invalid_argument(question.objects_file +
                                ": --format npy does not go with objects: it numbers the pairs "
                                "of links");
  if (question.objects && question.filter == PairFilter::On) question.candidates.emplace(question.model->pairs);
  if (question.pairs.empty() && !question.objects && !question.points)
    throw std::invalid_argument(options.robot.urdf + ": no pair of links is checked");
  question.budget.begin();
  question.motion.deadline = question.budget.deadline;
  return question;
}

/// Prints the warnings that are known before the first state.
void warn(const StateHeader& header, const ClearanceOptions& options, const ObjectSchedule* objects) {
  using Quantity = JointColumn::Quantity;
  printWarnings(header.warnings, options.robot.warnings);
  const bool has_rates = header.has(Quantity::Velocity) || header.has(Quantity::Acceleration);
  if (has_rates && options.question.interpolation == Interpolation::Linear)
    printWarnings({header.source + ": velocities and accelerations are not used without --interpolation."},
                  options.robot.warnings);
  if (options.rows == RowKind::Segment) return;
  const bool objects_have_times = objects && objects->hasTimes();
  if (objects_have_times && !header.has(Quantity::Time)) {
    throw std::invalid_argument(header.source + ": there is no column \"time\", and objects change at a time");
  }
  const bool has_column = header.has(Quantity::Time) && options.states.bag.file.empty();  // a bag has times in any case
  if (has_column && !objects_have_times) {
    printWarnings({header.source + ": column \"time\" is not used without --trajectory."}, options.robot.warnings);
  }
}

/// Prints the warnings that are known after the last state.
void warnAtTheEnd(const StateSource& states, const ClearanceOptions& options, const ObjectSchedule* objects) {
  printWarnings({states.limitWarning(), objects ? objects->leftOver() : ""}, options.robot.warnings);
}

std::string textOfPairs(const ClearanceQuestion& question) {
  const std::string within = question.uncertainty ? " within the uncertainty" : "";
  if (question.points) return "all " + std::to_string(question.points->centres.size()) + " points";
  if (question.objects) return "all pairs, of links and with objects," + within;
  return "all " + std::to_string(question.pairs.size()) + " pairs" + within;
}

OutputFormat formatOf(const ClearanceOptions& options, const ClearanceQuestion& question, RowFormat format) {
  return options.rows == RowKind::State ? StateRows(question, format).format() : segmentFormat(question, format);
}

/// Answers about all states or segments, in their order. Returns the summary of states.
SweepSummary answerAll(const ClearanceOptions& options, const ClearanceQuestion& question, StateSource& states,
                       AnswerOutput& output) {
  const auto end = [&] {
    output.end();
    warnAtTheEnd(states, options, question.objects.get());
  };
  SweepSummary summary;
  std::vector<std::string> spline_warnings;
  try {
    if (options.rows == RowKind::State) {
      summary = sweepStates(question, states, {0, kToTheEnd}, output);
    } else {
      spline_warnings = answerSegments(question, states, output);
    }
  } catch (const std::exception&) {
    try {
      end();
    } catch (const std::exception&) {  // the first failure is the one to report
    }
    throw;
  }
  end();
  printWarnings(spline_warnings, options.robot.warnings);
  if (output.report) {
    output.report->addExcess(states.limitWarning());
    for (const std::string& warning : spline_warnings) output.report->addExcess(warning);
  }
  return summary;
}

/// Writes the summary if it is asked for, and says what the run took.
void summarize(const ClearanceOptions& options, const SweepSummary& summary, std::clock_t begin, std::uint64_t bytes) {
  if (!options.sweep.summary.empty()) writeSummary(summary, options.sweep.summary);
  std::cerr << "clearance: " << summary.text() << "\n  " << costOf(summary.states, bytes, begin) << '\n';
}

ExitCode reportAssertion(const ClearanceAssertion& assertion, const StateSource& states) {
  if (!assertion.hasRows()) {
    throw std::invalid_argument(states.header().source + ": no state, so --assert-above proves nothing");
  }
  std::cerr << "clearance: " << assertion.report() << '\n';
  return assertion.holds() ? ExitCode::Done : ExitCode::AssertionFails;
}

ExitCode runNpy(const ClearanceOptions& options, const ClearanceQuestion& question, StateSource& states) {
  const std::clock_t begin = std::clock();
  const SweepManifest manifest = computeNpy(question, states, options.out);
  warnAtTheEnd(states, options, nullptr);
  summarize(options, manifest.summary, begin, manifest.bytes);
  return ExitCode::Done;
}

/// The pictures that are asked for.
struct Scripts {
  std::optional<PlotScript> plot, report;
};

/// Describes the question for a report: the robot, its files with their hashes, and the options. It reads the files, so
/// it is called before the states are answered: later the files may have changed.
nlohmann::ordered_json askedBy(const ClearanceOptions& options, const ClearanceQuestion& question,
                               const StateSource& states) {
  nlohmann::ordered_json asked = describe(question, options.format, states, 0);
  asked.erase("pairs");
  asked["command"] = options.command;
  asked["mesh_tolerance"] = configOf(options.robot).robot.model.mesh_tolerance;
  asked["tolerance"] = options.rows == RowKind::State ? scene::Question().tolerance : question.motion.tolerance;
  asked["files"] = nlohmann::ordered_json::array();
  for (const auto& [name, text] : {std::pair{"URDF", options.robot.urdf},
                                   {"SRDF", options.robot.srdf},
                                   {"configuration", options.robot.config},
                                   {"objects", question.objects_file},
                                   {"thresholds", question.thresholds_file},
                                   {"joint uncertainty", question.uncertainty_text},
                                   {"tracking error", question.tracking_error_text},
                                   {"start", question.start_text}}) {
    std::error_code none;  // a text that is no file may be too long for a name
    const bool is_file = std::filesystem::is_regular_file(text, none);
    if (!text.empty()) asked["files"].push_back({name, text, is_file ? contentHash(text) : ""});
  }
  return asked;
}

void writeReport(const AnswerOutput& output, nlohmann::ordered_json asked, PlotScript& page) {
  nlohmann::ordered_json facts = output.report->toJson();
  facts["asked"] = std::move(asked);
  if (output.assertion && output.assertion->hasRows()) facts["assertion"] = output.assertion->report();
  page.data() << facts.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
  page.draw();
}

ExitCode runText(const ClearanceOptions& options, const ClearanceQuestion& question, StateSource& states,
                 Scripts& scripts) {
  const std::clock_t begin = std::clock();
  const OutputFormat format = formatOf(options, question, options.format);
  RowOutput rows =
      options.out.empty() ? RowOutput(std::cout, "standard output", format) : RowOutput(options.out, format);
  AnswerCounter counter(options.rows == RowKind::State ? "states" : "segments", totalOf(states, options.rows));
  AnswerOutput output{options.format, rows, counter};
  if (scripts.plot)
    output.plot.emplace(scripts.plot->data(), "the data of the plot", formatOf(options, question, RowFormat::Csv));
  nlohmann::ordered_json asked;
  if (scripts.report) {
    output.report.emplace(question, options.rows);
    asked = askedBy(options, question, states);
  }
  if (options.second_opinion.is_wanted) output.second_opinion.emplace(options.second_opinion, question.model);
  if (options.assert_above)
    output.assertion.emplace(*options.assert_above, options.rows, question.model->robot, textOfPairs(question),
                             question.uncertainty ? LowerBounds::Guaranteed : LowerBounds::OfTheState);
  const SweepSummary summary = answerAll(options, question, states, output);
  output.complete();
  if (scripts.plot) scripts.plot->draw({shortest(question.motion.contact_distance)});
  if (scripts.report) writeReport(output, std::move(asked), *scripts.report);
  if (!options.sweep.summary.empty()) summarize(options, summary, begin, rows.bytes());
  if (output.second_opinion) {
    std::cerr << "clearance: " << output.second_opinion->summary() << '\n';
    if (output.second_opinion->refutesOurs()) return ExitCode::Refuted;
  }
  return output.assertion ? reportAssertion(*output.assertion, states) : ExitCode::Done;
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
  Scripts scripts;
  if (!options.plot.empty()) scripts.plot.emplace(PlotKind{"--plot", "clearance_plot.py"}, options.plot);
  if (!options.report.empty())
    scripts.report.emplace(PlotKind{"--report", "clearance_report.py", {".html"}}, options.report);
  requireReadable(options.states);
  const ClearanceQuestion question = questionOf(options);
  const std::unique_ptr<StateSource> states = openStates(options.states, question.model->robot);
  warn(states->header(), options, question.objects.get());
  if (options.sweep.isPart()) {
    computePart(question, options.format, options.sweep, *states, options.out);
    warnAtTheEnd(*states, options, question.objects.get());
    return ExitCode::Done;
  }
  if (options.format == RowFormat::Npy) return runNpy(options, question, *states);
  return runText(options, question, *states, scripts);
}

/// A record of the node is answered by the node's monitor, which is in a program beside this one.
void replayIfAsked(int argc, char** argv) {
  const bool is_asked =
      std::any_of(argv, argv + argc, [](const char* text) { return text == std::string("--replay"); });
  if (!is_asked) return;
  const std::string program = std::filesystem::read_symlink("/proc/self/exe").parent_path() / "replay";
  execv(program.c_str(), argv);
  std::cerr << "clearance: --replay needs the ROS package: there is no " << program << '\n';
  std::exit(static_cast<int>(ExitCode::BadInput));
}

}  // namespace
}  // namespace proximity_server::tools

int main(int argc, char** argv) {
  proximity_server::tools::replayIfAsked(argc, argv);
  proximity_server::tools::ProgramOptions program(
      "clearance",
      "How close a robot is to itself, and to objects, in recorded or planned states, and between them;\n"
      "lengths in metres, in the root link's frame");
  proximity_server::tools::ClearanceOptions options;
  options.command.assign(argv + 1, argv + argc);
  proximity_server::tools::declareClearance(program, options);
  return proximity_server::tools::runTool(program, argc, argv, [&] { return proximity_server::tools::run(options); });
}
