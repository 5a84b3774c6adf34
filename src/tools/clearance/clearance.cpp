// How close a robot is to itself and to objects in recorded or planned states, without a ROS master.
#include <unistd.h>
#include <CLI/CLI.hpp>

#include <fstream>
#include <iostream>
#include <optional>
#include <stdexcept>
#include <string>

#include "proximity_server/scene/mesh/mesh_resolver.h"
#include "proximity_server/scene/object_files/object_file.h"
#include "proximity_server/scene/pieces/convex_pieces.h"
#include "tools/clearance/clearance_assertion.h"
#include "tools/clearance/clearance_rows.h"
#include "tools/clearance/clearance_run.h"
#include "tools/clearance/object_schedule.h"
#include "tools/clearance/trajectory_run.h"
#include "tools/command_line/csv.h"
#include "tools/command_line/number_options.h"
#include "tools/command_line/plot_script.h"
#include "tools/command_line/robot_files.h"
#include "tools/command_line/tool_main.h"

namespace proximity_server::tools {
namespace {

struct Arguments {
  RobotFiles robot;
  std::string objects, states = "-", pairs = "minimum", out, plot;
  RowFormat format = RowFormat::Csv;
  RowKind rows = RowKind::State;
  scene::MotionQuestion motion;
  std::optional<double> assert_above;  // [m]
  scene::Skipping skipping = scene::Skipping::On;
  int threads = 1;
  enum class Filter : unsigned char { On, Off } filter = Filter::On;
};

/// [m] The smallest legal tolerance of a motion: the narrowphase answers within 1e-9 m only.
constexpr double kSmallestTolerance = 1e-8;

std::string whyNoSelection(const std::string& text) {
  try {
    readPairSelection(text);
    return "";
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
}

void declareTrajectory(CLI::App& app, Arguments& arguments) {
  CLI::Option* trajectory = app.add_flag_callback(
      "--trajectory", [&] { arguments.rows = RowKind::Segment; },
      "the states are way points, joints linear in between, at the times of a column \"time\" [s] or 1 s apart: a row "
      "for each segment, with its closest pair and first contact");
  trajectory->excludes("--pairs")->excludes("--no-skip");
  addLength(app, "--contact-distance", arguments.motion.contact_distance, 0.0, "what counts as contact (default: 0)")
      ->needs(trajectory);
  addLength(app, "--tolerance", arguments.motion.tolerance, kSmallestTolerance,
            "of the minimum and of contact (default: 1e-6)")
      ->needs(trajectory);
}

void declareOutput(CLI::App& app, Arguments& arguments) {
  const auto readFormat = [&](const std::string& name) {
    if (name != "csv" && name != "json") {
      throw CLI::ValidationError("--format", "'" + name + "' is neither csv nor json");
    }
    arguments.format = name == "csv" ? RowFormat::Csv : RowFormat::Json;
  };
  app.add_option_function<std::string>("--format", readFormat, "csv or json (default: csv)")->type_name("NAME");
  app.add_option("--out", arguments.out, "where to write (default: standard output)")->type_name("FILE");
  app.add_option(
         "--plot", arguments.plot,
         "a picture (.png, .pdf or .svg) of the clearance over the states or the time, and of the closest pairs")
      ->type_name("FILE");
  addLength(app, "--assert-above", arguments.assert_above, 0.0,
            "end with exit code 2 unless every state, or all that lies between way points, is proven to be above this "
            "distance, and name the first and the worst on standard error");
  app.footer(
      "Exit codes: 0: done, and what --assert-above asks for is proven; 1: bad input, or memory, threads or disk did "
      "not suffice; 2: --assert-above does not hold, or is not proven.");
}

void declare(CLI::App& app, Arguments& arguments) {
  app.add_option("robot", arguments.robot.urdf, "the URDF")->required()->type_name("FILE");
  app.add_option("--srdf", arguments.robot.srdf, "which pairs not to check")->type_name("FILE");
  app.add_option("--objects", arguments.objects,
                 "what the robot holds and what stands around it: YAML, or a .scene of MoveIt")
      ->type_name("FILE");
  app.add_option("--states", arguments.states, "CSV: a header of joint names, a row for each state; -: standard input")
      ->type_name("FILE");
  app.add_option("--pairs", arguments.pairs, "all, minimum, below:METRES or k:COUNT (default: minimum)")
      ->check(whyNoSelection);
  addMeshTolerance(app, arguments.robot.mesh_tolerance);
  app.add_flag_callback(
      "--no-filter", [&] { arguments.filter = Arguments::Filter::Off; },
      "every pair of links with geometry that are not one body, neighbours too");
  app.add_flag_callback(
      "--no-skip", [&] { arguments.skipping = scene::Skipping::Off; }, "compute every pair anew");
  addThreads(app, arguments.threads);
  declareTrajectory(app, arguments);
  declareOutput(app, arguments);
}

/// Writes rows, and the text before, between and after them.
class RowWriter {
 public:
  RowWriter(std::ostream& stream, const scene::RobotModel& robot, RowKind kind, RowFormat format)
      : stream_(stream), robot_(robot), format_(format) {
    stream_ << rowsBegin(kind, format_);
  }

  void write(const StateClearance& answer) {
    for (const scene::PairProximity& pair : answer.pairs)
      writeRow(rowText(answer.state, pair, robot_, answer.objects.get(), format_));
  }
  void write(const SegmentClearance& answer) { writeRow(rowText(answer, robot_, format_)); }

  void end(const std::string& name) {
    stream_ << rowsEnd(format_) << std::flush;
    if (!stream_) throw std::invalid_argument(name + ": writing failed");
  }

 private:
  void writeRow(const std::string& row) {
    stream_ << (has_row_ || format_ == RowFormat::Csv ? rowsSeparator(format_) : "\n") << row;
    has_row_ = true;
  }

  std::ostream& stream_;
  const scene::RobotModel& robot_;
  RowFormat format_;
  bool has_row_ = false;
};

/// Shows the number of answers on standard error if that is a terminal.
class AnswerCounter {
 public:
  explicit AnswerCounter(RowKind kind) : what_(kind == RowKind::State ? " states" : " segments") {}
  void count() {
    if (is_terminal_ && ++count_ % 1000 == 0) std::cerr << '\r' << count_ << what_ << std::flush;
  }
  /// Erases the line.
  void clear() const {
    if (is_terminal_) std::cerr << "\r\033[K" << std::flush;
  }

 private:
  const char* what_;
  long count_ = 0;
  bool is_terminal_ = isatty(STDERR_FILENO) != 0;
};

/// Opens the named file; returns the standard stream if the path is `no_name`.
template <typename FileStream, typename Stream>
Stream& openStream(const std::string& path, const std::string& no_name, std::optional<FileStream>& file,
                   Stream& standard) {
  if (path == no_name) return standard;
  file.emplace(path, FileStream::binary);
  if (!*file) throw std::invalid_argument(path + ": cannot be opened");
  return *file;
}

std::shared_ptr<ObjectSchedule> scheduleOf(const Arguments& arguments,
                                           const std::shared_ptr<const scene::SceneModel>& model) {
  if (arguments.objects.empty()) return nullptr;
  scene::ObjectOptions options;
  options.resolve = scene::packageResolver(scene::rosPackagePath());
  if (arguments.robot.mesh_tolerance) options.meshes.tolerance = *arguments.robot.mesh_tolerance;
  options.meshes.cache = scene::userMeshCache();
  auto schedule = std::make_shared<ObjectSchedule>(model, scene::readObjectFile(arguments.objects), options);
  for (const std::string& warning : schedule->warnings()) std::cerr << "warning: " << warning << '\n';
  return schedule;
}

ClearanceQuestion questionOf(const Arguments& arguments) {
  ClearanceQuestion question;
  question.model = loadSceneModel(arguments.robot);
  printWarnings(*question.model);
  const bool is_filtered = arguments.filter == Arguments::Filter::On;
  question.pairs = is_filtered ? filteredPairs(*question.model) : unfilteredPairs(*question.model);
  question.objects = scheduleOf(arguments, question.model);
  if (question.objects && is_filtered) question.candidates.emplace(question.model->pairs);
  if (question.pairs.empty() && !question.objects)
    throw std::invalid_argument(arguments.robot.urdf + ": no pair of links is checked");
  question.threads = arguments.threads;
  return question;
}

/// Passes the answers about all states or segments to `handle`, in their order.
template <typename Handle>
void answerAll(const Arguments& arguments, const ClearanceQuestion& question, JointStates& states,
               const Handle& handle) {
  if (arguments.rows == RowKind::Segment) {
    answerSegments(question, arguments.motion, states, handle);
  } else {
    const Smallest smallest = arguments.assert_above ? Smallest::Always : Smallest::IfListed;
    answerStates(question, {readPairSelection(arguments.pairs), arguments.skipping, smallest}, states, handle);
  }
}

/// Prints the warnings that are known before the first state.
void warn(const JointStates& states, RowKind rows, const ObjectSchedule* objects) {
  for (const std::string& warning : states.warnings()) std::cerr << "warning: " << warning << '\n';
  const bool objects_have_times = objects && objects->hasTimes();
  if (rows == RowKind::State && objects_have_times && !states.hasTimes()) {
    throw std::invalid_argument(states.source() + ": there is no column \"time\", and objects change at a time");
  }
  if (rows == RowKind::State && states.hasTimes() && !objects_have_times) {
    std::cerr << "warning: " << states.source() << ": column \"time\" is not used without --trajectory.\n";
  }
}

/// Prints the warnings that are known after the last state.
void warnAtTheEnd(const JointStates& states, const ObjectSchedule* objects) {
  for (const std::string& warning : {states.limitWarning(), objects ? objects->leftOver() : ""})
    if (!warning.empty()) std::cerr << "warning: " << warning << '\n';
}

std::string checkedPairs(const ClearanceQuestion& question) {
  if (question.objects) return "all pairs, of links and with objects,";
  return "all " + std::to_string(question.pairs.size()) + " pairs";
}

/// Writes the answers to the output and the plot, and adds them to the assertion.
class Answers {
 public:
  Answers(const Arguments& arguments, const ClearanceQuestion& question, std::ostream& out, PlotScript* plot)
      : writer_(out, question.model->robot, arguments.rows, arguments.format), counter_(arguments.rows) {
    const scene::RobotModel& robot = question.model->robot;
    if (plot) plot_writer_.emplace(plot->data(), robot, arguments.rows, RowFormat::Csv);
    if (!arguments.assert_above) return;
    assertion_.emplace(*arguments.assert_above, arguments.rows, robot, checkedPairs(question));
  }

  template <typename Answer>
  void add(const Answer& answer) {
    writer_.write(answer);
    if (plot_writer_) plot_writer_->write(answer);
    if (assertion_) assertion_->add(answer);
    counter_.count();
  }

  /// Writes the end of the rows, so that the output is a complete document.
  void end(const std::string& out_name) {
    counter_.clear();
    writer_.end(out_name);
    if (plot_writer_) plot_writer_->end("the data of the plot");
  }

  const std::optional<ClearanceAssertion>& assertion() const { return assertion_; }

 private:
  RowWriter writer_;
  std::optional<RowWriter> plot_writer_;
  std::optional<ClearanceAssertion> assertion_;
  AnswerCounter counter_;
};

void answerInto(Answers& answers, const std::string& out_name, const Arguments& arguments,
                const ClearanceQuestion& question, JointStates& states) {
  const auto end = [&] {
    answers.end(out_name);
    warnAtTheEnd(states, question.objects.get());
  };
  try {
    answerAll(arguments, question, states, [&](const auto& found) { answers.add(found); });
  } catch (const std::exception&) {
    end();
    throw;
  }
  end();
}

ExitCode judge(const ClearanceAssertion& assertion, const JointStates& states) {
  if (!assertion.hasRows()) {
    throw std::invalid_argument(states.source() + ": no state, so --assert-above proves nothing");
  }
  std::cerr << "clearance: " << assertion.report() << '\n';
  return assertion.holds() ? ExitCode::Done : ExitCode::AssertionFails;
}

ExitCode run(const Arguments& arguments) {
  std::optional<PlotScript> plot;
  if (!arguments.plot.empty()) plot.emplace("clearance_plot.py", arguments.plot);
  std::optional<std::ifstream> in_file;
  std::optional<std::ofstream> out_file;
  std::istream& in = openStream(arguments.states, "-", in_file, std::cin);
  const ClearanceQuestion question = questionOf(arguments);
  JointStates states(in, in_file ? arguments.states : "standard input", question.model->robot);
  warn(states, arguments.rows, question.objects.get());
  std::ostream& out = openStream(arguments.out, "", out_file, std::cout);

  Answers answers(arguments, question, out, plot ? &*plot : nullptr);
  answerInto(answers, out_file ? arguments.out : "standard output", arguments, question, states);
  if (plot) plot->draw({numberText(arguments.motion.contact_distance)});
  return answers.assertion() ? judge(*answers.assertion(), states) : ExitCode::Done;
}

}  // namespace
}  // namespace proximity_server::tools

int main(int argc, char** argv) {
  CLI::App app(
      "How close a robot is to itself, and to objects, in recorded or planned states, and between them; lengths in "
      "metres, in "
      "the root link's frame",
      "clearance");
  proximity_server::tools::Arguments arguments;
  proximity_server::tools::declare(app, arguments);
  return proximity_server::tools::runTool(app, argc, argv, [&] { return proximity_server::tools::run(arguments); });
}
