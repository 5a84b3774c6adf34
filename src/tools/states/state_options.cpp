#include "tools/states/state_options.h"

#include "proximity_server/scene/mesh/readable_file.h"
#include "system/whole_file.h"
#include "tools/program/options.h"
#include "tools/states/csv_states.h"
#include "tools/states/numpy_states.h"
#include "tools/states/recorded_states.h"
#include "tools/states/sampled_states.h"
#include "tools/text/csv.h"
#include "tools/text/naming.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <limits>
#include <stdexcept>

namespace proximity_server::tools {
namespace {

double readRate(const std::string& text) {
  const std::optional<double> rate = finiteNumber(text);
  if (rate && *rate >= kLowestRate && *rate <= kHighestRate) return *rate;
  throw std::invalid_argument("'" + text + "' is not a rate from " + shortest(kLowestRate) + " to " +
                              shortest(kHighestRate) + " Hz");
}

std::vector<std::string> readNames(const std::string& text) {
  return naming("'" + text + "'", [&] { return csvFields(text); });
}

void declareFile(ProgramOptions& program, StateOptions& options) {
  program.addText(
      "--states", "FILE", options.file,
      "CSV: a header of joint names, a row for each state; -: standard input; or a table of NumPy (.npy, .npz)");
  program
      .addRead("--joints", "NAME,...", options.joints, readNames,
               "the joints of the columns of a .npy or .npz (default: those in the .npz, or in the file with the "
               "suffix .joints)")
      .needs = "--states";
}

void declareBag(ProgramOptions& program, BagOptions& options) {
  program.addText("--bag", "FILE", options.file, "a rosbag with messages sensor_msgs/JointState");
  program.addText("--topic", "NAME", options.topic, "of the bag (default: /joint_states)").needs = "--bag";
  program
      .addRead("--rate", "HZ", options.rate, readRate,
               "that many states a second of the bag (default: one for every message)")
      .needs = "--bag";
}

void declareSample(ProgramOptions& program, StateOptions& options) {
  constexpr long kMost = std::numeric_limits<long>::max();
  addCount(program, "--sample", options.sample, 1, kMost,
           "so many random states, uniform within the limits of the joints");
  addCount(program, "--seed", options.seed, 0, kMost,
           "of --sample (default: 0); state i is the same for any number of states")
      .needs = "--sample";
}

void declareGrid(ProgramOptions& program, StateOptions& options) {
  program
      .add("--grid", "AXIS",
           "JOINT=LOWER:UPPER:COUNT or JOINT=POSITION (also like 90deg), for each joint of a regular grid; or COUNT, "
           "positions of every joint within its limits; the last joint runs fastest",
           [&](const std::string& text) { options.grid.push_back(readGridAxis(text)); })
      .is_repeatable = true;
}

/// Joints without an axis are at 0.
std::vector<GridAxis> zeroAxes(const scene::RobotModel& robot) {
  std::vector<GridAxis> axes;
  for (const scene::Joint& joint : robot.joints) {
    const double position = std::clamp(0.0, joint.lower, joint.upper);
    if (position != 0.0 && !joint.mimic) axes.push_back({joint.name, position, position, 1});
  }
  return axes;
}

}  // namespace

bool isNumpy(const std::string& file) {
  const std::filesystem::path suffix = std::filesystem::path(file).extension();
  if (suffix == ".npy" || suffix == ".npz") return true;
  if (!std::filesystem::is_regular_file(file)) return false;
  std::array<char, 6> begin{};
  std::ifstream(file, std::ios::binary).read(begin.data(), begin.size());
  const std::string text(begin.data(), begin.size());
  return text == "\x93NUMPY" || text.compare(0, 4, "PK\3\4") == 0;
}

void declareStateOptions(ProgramOptions& program, StateOptions& options) {
  program.setHeading(
      "States (one of --states, --bag, --sample, --grid and --zero; without any: CSV from standard input)");
  declareFile(program, options);
  declareBag(program, options.bag);
  declareSample(program, options);
  declareGrid(program, options);
  program.addFlag("--zero", options.is_zero, true,
                  "one state: every joint is at 0, or at the limit that is nearest to 0 if that is beyond its limits");
  program.atMostOneOf({"--states", "--bag", "--sample", "--grid", "--zero"});
  program.setHeading();
}

void requireReadable(const StateOptions& options) {
  if (options.sample || !options.grid.empty() || options.is_zero) return;
  const std::string& file = options.bag.file.empty() ? options.file : options.bag.file;
  file == "-" ? system::FileRoles::ofProcess().addInput("standard input", "/dev/stdin") : scene::requireReadable(file);
}

std::unique_ptr<StateSource> openStates(const StateOptions& options, const scene::RobotModel& robot) {
  if (!options.bag.file.empty()) return openBag(options.bag, robot);
  if (options.sample) return std::make_unique<SampledStates>(*options.sample, options.seed, robot);
  if (!options.grid.empty()) return std::make_unique<GridStates>(options.grid, robot);
  if (options.is_zero) return std::make_unique<GridStates>(zeroAxes(robot), robot);
  const bool is_stream = options.file == "-";
  if (!is_stream && isNumpy(options.file)) return std::make_unique<NumpyStates>(options.file, options.joints, robot);
  if (!options.joints.empty())
    throw std::invalid_argument("--joints goes with a .npy or .npz: the header of a CSV names its joints");
  if (is_stream) return std::make_unique<CsvStates>(std::cin, "standard input", robot);
  return std::make_unique<CsvStates>(options.file, robot);
}

}  // namespace proximity_server::tools
