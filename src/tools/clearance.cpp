// How close a robot is to itself in recorded or planned states, without a ROS master.
#include <unistd.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iostream>
#include <map>
#include <optional>
#include <stdexcept>
#include <string>
#include <thread>

#include "clearance_plot.h"
#include "clearance_rows.h"
#include "clearance_run.h"
#include "csv.h"
#include "robot_files.h"
#include "trajectory_run.h"

namespace proximity_server {
namespace {

struct Arguments {
  RobotFiles robot;
  std::string states = "-", pairs = "minimum", out, plot;
  RowFormat format = RowFormat::Csv;
  RowKind rows = RowKind::State;
  MotionQuestion motion;
  Skipping skipping = Skipping::On;
  int threads = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  enum class Filter : unsigned char { On, Off } filter = Filter::On;
};

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
  app.add_option("--clearance", arguments.motion.clearance, "[m] what counts as contact (default: 0)")
      ->needs(trajectory);
  app.add_option("--tolerance", arguments.motion.tolerance, "[m] of the minimum and of contact (default: 1e-6)")
      ->needs(trajectory);
}

void declare(CLI::App& app, Arguments& arguments) {
  app.add_option("robot", arguments.robot.urdf, "the URDF")->required();
  app.add_option("--srdf", arguments.robot.srdf, "which pairs not to check");
  app.add_option("--states", arguments.states, "CSV: a header of joint names, a row for each state; -: standard input");
  app.add_option("--pairs", arguments.pairs, "all, minimum, below:METRES or k:COUNT (default: minimum)")
      ->check(whyNoSelection);
  app.add_option("--mesh-tolerance", arguments.robot.mesh_tolerance, "[m] how far pieces may lie from their mesh")
      ->check(CLI::NonNegativeNumber);
  app.add_flag_callback(
      "--no-filter", [&] { arguments.filter = Arguments::Filter::Off; },
      "every pair of links with geometry that are not one body, neighbours too");
  app.add_flag_callback(
      "--no-skip", [&] { arguments.skipping = Skipping::Off; }, "compute every pair anew");
  app.add_option("--format", arguments.format, "csv or json (default: csv)")
      ->transform(CLI::CheckedTransformer(
          std::map<std::string, RowFormat>{{"csv", RowFormat::Csv}, {"json", RowFormat::Json}}));
  app.add_option("--out", arguments.out, "where to write (default: standard output)");
  app.add_option("--plot", arguments.plot,
                 "a PNG of the clearance over the states or the time, and of the closest pairs");
  app.add_option("--threads", arguments.threads, "default: all cores; the output is the same for any number")
      ->check(CLI::Range(1, 1024));
  declareTrajectory(app, arguments);
}

/// Writes rows as they come, and what stands before, between and behind them.
class RowWriter {
 public:
  RowWriter(std::ostream& stream, const RobotModel& robot, RowKind kind, RowFormat format)
      : stream_(stream), robot_(robot), format_(format) {
    stream_ << rowsBegin(kind, format_);
  }

  void write(const StateClearance& answer) {
    for (const PairProximity& pair : answer.pairs) writeRow(rowText(answer.state, pair, robot_, format_));
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
  const RobotModel& robot_;
  RowFormat format_;
  bool has_row_ = false;
};

/// How much is done, on a terminal only.
class AnswerCounter {
 public:
  explicit AnswerCounter(RowKind kind) : what_(kind == RowKind::State ? " states" : " segments") {}
  void count() {
    if (is_terminal_ && ++count_ % 1000 == 0) std::cerr << '\r' << count_ << what_ << std::flush;
  }
  ~AnswerCounter() {
    if (is_terminal_) std::cerr << "\r\033[K";
  }

 private:
  const char* what_;
  long count_ = 0;
  bool is_terminal_ = isatty(STDERR_FILENO) != 0;
};

/// The named file, or the standard stream where there is no name.
template <typename FileStream, typename Stream>
Stream& openStream(const std::string& path, const std::string& no_name, std::optional<FileStream>& file,
                   Stream& standard) {
  if (path == no_name) return standard;
  file.emplace(path, FileStream::binary);
  if (!*file) throw std::invalid_argument(path + ": cannot be opened");
  return *file;
}

ClearanceQuestion questionOf(const Arguments& arguments) {
  ClearanceQuestion question;
  question.model = loadSceneModel(arguments.robot);
  question.pairs =
      arguments.filter == Arguments::Filter::On ? filteredPairs(*question.model) : unfilteredPairs(*question.model);
  if (question.pairs.empty()) throw std::invalid_argument(arguments.robot.urdf + ": no pair of links is checked");
  question.threads = arguments.threads;
  return question;
}

/// Narrowphase answers are within 1e-9 m, so no closer bounds of a motion can be asked for.
constexpr double kSmallestTolerance = 1e-8;

/// Throws std::invalid_argument naming the argument.
void check(const MotionQuestion& question) {
  if (!std::isfinite(question.clearance)) throw std::invalid_argument("--clearance: not a finite length");
  if (!std::isfinite(question.tolerance) || question.tolerance < kSmallestTolerance) {
    throw std::invalid_argument("--tolerance: not a finite length of at least " + numberText(kSmallestTolerance) +
                                " m");
  }
}

/// Every answer in their order, to `take`.
template <typename Take>
void answerAll(const Arguments& arguments, const ClearanceQuestion& question, JointStates& states, const Take& take) {
  if (arguments.rows == RowKind::Segment) {
    answerSegments(question, arguments.motion, states, take);
  } else {
    answerStates(question, {readPairSelection(arguments.pairs), arguments.skipping}, states, take);
  }
}

void warn(const JointStates& states, RowKind rows) {
  for (const std::string& warning : states.warnings()) std::cerr << "warning: " << warning << '\n';
  if (rows == RowKind::State && states.hasTimes()) {
    std::cerr << "warning: " << states.source() << ": column \"time\" is not used without --trajectory.\n";
  }
}

void run(const Arguments& arguments) {
  check(arguments.motion);
  const ClearanceQuestion question = questionOf(arguments);
  const RobotModel& robot = question.model->robot;
  std::optional<std::ifstream> in_file;
  std::optional<std::ofstream> out_file;
  std::optional<ClearancePlot> plot;
  std::istream& in = openStream(arguments.states, "-", in_file, std::cin);
  JointStates states(in, in_file ? arguments.states : "standard input", robot);
  warn(states, arguments.rows);
  std::ostream& out = openStream(arguments.out, "", out_file, std::cout);
  const std::string out_name = out_file ? arguments.out : "standard output";

  if (!arguments.plot.empty()) plot.emplace(arguments.plot);
  RowWriter writer(out, robot, arguments.rows, arguments.format);
  std::optional<RowWriter> plot_writer;
  if (plot) plot_writer.emplace(plot->data(), robot, arguments.rows, RowFormat::Csv);
  try {
    AnswerCounter counter(arguments.rows);
    answerAll(arguments, question, states, [&](const auto& found) {
      writer.write(found);
      if (plot_writer) plot_writer->write(found);
      counter.count();
    });
  } catch (const std::invalid_argument&) {
    writer.end(out_name);  // what was answered before the error is a whole document
    throw;
  }
  writer.end(out_name);
  if (plot_writer) plot_writer->end("the data of the plot");
  if (plot) plot->draw(arguments.motion.clearance);
}

}  // namespace
}  // namespace proximity_server

int main(int argc, char** argv) {
  std::ios::sync_with_stdio(false);
  CLI::App app(
      "How close a robot is to itself in recorded or planned states, and between them; lengths in metres, in the root "
      "link's frame");
  proximity_server::Arguments arguments;
  proximity_server::declare(app, arguments);
  CLI11_PARSE(app, argc, argv);
  try {
    proximity_server::run(arguments);
  } catch (const std::invalid_argument& error) {
    std::cout << std::flush;
    std::cerr << "clearance: " << error.what() << '\n';
    return 1;
  }
  return 0;
}
