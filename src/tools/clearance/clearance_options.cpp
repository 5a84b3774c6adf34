#include "tools/clearance/clearance_options.h"

#include "tools/program/options.h"
#include "tools/program/time_budget.h"

#include <stdexcept>

namespace proximity_server::tools {
namespace {

/// [m] The smallest legal tolerance of a motion and accuracy: the narrowphase answers within 1e-9 m only.
constexpr double kSmallestTolerance = 1e-8;

void declareTrajectory(ProgramOptions& program, ClearanceOptions& options) {
  program.addFlag("--trajectory", options.rows, RowKind::Segment,
                  "the states are way points, at the times of a column \"time\" [s] or 1 s apart: a row "
                  "for each segment, with its closest pair and first contact");
  for (const char* other : {"--pairs", "--accuracy", "--no-skip", "--sample", "--grid", "--zero", "--shard", "--range",
                            "--summary", "--second-opinion", "--joint-uncertainty"})
    program.atMostOneOf({"--trajectory", other});
  program
      .addRead("--interpolation", "NAME", options.question.interpolation,
               oneOf<Interpolation>({{"linear", Interpolation::Linear},
                                     {"cubic", Interpolation::Cubic},
                                     {"quintic", Interpolation::Quintic}}),
               "what joint_trajectory_controller drives between way points: linear, cubic with columns "
               "JOINT.velocity, or quintic with JOINT.acceleration too (default: linear)")
      .needs = "--trajectory";
  program
      .addText(
          "--tracking-error", "NUMBER|FILE", options.question.tracking_error_text,
          "how far each joint may be off, in radians or metres, or in degrees (0.5deg); or YAML with a number for each "
          "joint, or with the constraints of joint_trajectory_controller. What holds then holds for the whole tube "
          "(default: 0)")
      .needs = "--trajectory";
  program
      .addText(
          "--start", "FILE|STATE", options.question.start_text,
          "the state in which the controller is at time 0, from where it drives to the first way point after: a file "
          "with one state, or JOINT=POSITION,... (default: at the first way point)")
      .needs = "--trajectory";
  addLength(program, "--contact-distance", options.question.motion.contact_distance, 0.0,
            "what counts as contact (default: 0)")
      .needs = "--trajectory";
  addLength(program, "--tolerance", options.question.motion.tolerance, kSmallestTolerance,
            "of the minimum and of contact (default: 1e-6)")
      .needs = "--trajectory";
}

void declarePoints(ProgramOptions& program, ClearanceOptions& options) {
  program.addText("--points", "FILE", options.question.points_file,
                  "points in the root link's frame: CSV with a header x,y,z or x,y,z,radius, or a .npy of so many "
                  "columns. Rows are about them, and not about pairs of links: the point that is closest to the robot "
                  "and what it holds, with its number from 0; with --pairs all each point, with below:METRES and "
                  "k:COUNT those");
  for (const char* other :
       {"--trajectory", "--accuracy", "--thresholds", "--joint-uncertainty", "--no-filter", "--plot", "--report",
        "--second-opinion", "--shard", "--range", "--merge", "--summary", "--list"})
    program.atMostOneOf({"--points", other});
}

void declareOutput(ProgramOptions& program, ClearanceOptions& options) {
  const auto readFormat = [](const std::string& name) {
    const std::optional<RowFormat> format = rowFormatNamed(name);
    if (!format) throw std::invalid_argument("'" + name + "' is neither csv, json nor npy");
    return *format;
  };
  program.addRead("--format", "NAME", options.format, readFormat,
                  "csv, json, or npy: numbers for numpy, and FILE.manifest with the names of the pairs (default: csv)");
  program.addOutput("--out", "FILE|DIR", options.out,
                    "where to write (default: standard output); the folder of --shard and --range");
  program.addOutput(
      "--plot", "FILE", options.plot,
      "a picture (.png, .pdf or .svg) of the clearance over the states or the time, and of the closest pairs");
  program.addOutput("--report", "FILE.html", options.report,
                    "a page to print and to archive: the worst states of the closest pairs with pictures, the "
                    "clearance over the states or the time, all pairs, and what was checked. All pairs of all states "
                    "are computed for it, whatever --pairs lists");
  addLength(program, "--assert-above", options.assert_above, 0.0,
            "end with exit code 2 unless every state, or all that lies between way points, is proven to be above this "
            "distance, and name the first and the worst on standard error");
  program.setFooter(
      "Exit codes: 0: done, and what --assert-above asks for is proven; 1: bad input, or memory, threads,\n"
      "disk or time did not suffice; 2: --assert-above does not hold, or is not proven; 3: --second-opinion\n"
      "refutes an answer.");
}

}  // namespace

void declareClearance(ProgramOptions& program, ClearanceOptions& options) {
  program.addText("robot", "FILE", options.robot.urdf, "the URDF");
  program.addText("--srdf", "FILE", options.robot.srdf, "which pairs not to check");
  program.addText(
      "--objects", "FILE", options.question.objects_file,
      "what the robot holds and what stands around it: YAML, a .scene of MoveIt, or a cloud: .pcd, .ply, .bt, .ot");
  program.addText(
      "--thresholds", "FILE", options.question.thresholds_file,
      "stop and warn distances, also of single pairs, links and groups: YAML. Each row has the level of its "
      "pair by its own thresholds: CLEAR, WARN, STOP, COLLISION or INVALID. With --trajectory it is the worst "
      "level of the segment, with the time and the pair that reach it");
  program.addText(
      "--joint-uncertainty", "NUMBER|FILE", options.question.uncertainty_text,
      "how far each joint may be off, in radians or metres, or in degrees (0.1deg); or YAML with the uncertainty of "
      "joints, frames, bases, objects and links. Each row has `guaranteed`: a lower bound of the distance for all "
      "states within it; --pairs minimum is then the pair for which that is the smallest");
  program.addFlag("--list", options.list, true,
                  "only list the joints of the robot, a line each: name, type, limits, unit");
  declareStateOptions(program, options.states);
  program.addRead(
      "--pairs", "TEXT", options.question.selection, readPairSelection,
      "all, minimum, below:METRES, k:COUNT, or any:METRES: only whether a pair is as close, and one that is "
      "(default: minimum). With --thresholds, minimum is the pair that sets the level: of the worst level the one "
      "with the smallest distance less its threshold");
  addLength(
      program, "--accuracy", options.accuracy, kSmallestTolerance,
      "of --pairs minimum: only bounds of the distance, at most so far apart and proven, and no points. 1e-4 takes "
      "a fraction of the time");
  addRobotOptions(program, options.robot);
  addJointInequalities(program, options.robot);
  addQuiet(program, options.robot.warnings);
  program.addFlag("--no-filter", options.question.filter, PairFilter::Off,
                  "every pair of links with geometry that are not one body, neighbours too");
  program.addFlag("--no-skip", options.question.skipping, scene::Skipping::Off, "compute every pair anew");
  addThreads(program, options.question.threads);
  addTimeBudget(
      program, options.question.budget,
      "end with an error after this time; the rows on standard output are complete up to then, and --out is not "
      "written (default: none)");
  declareSecondOpinion(program, options.second_opinion);
  declareOutput(program, options);
  declareSweepOptions(program, options.sweep);
  declareTrajectory(program, options);
  declarePoints(program, options);
}

void requireConsistent(const ClearanceOptions& options) {
  const auto require = [](bool is_right, const std::string& what) {
    if (!is_right) throw std::invalid_argument(what);
  };
  const bool is_merge = !options.sweep.merge.empty(), is_npy = options.format == RowFormat::Npy;
  const bool is_part = options.sweep.isPart(), is_whole = !is_part && !is_merge;
  require(is_merge || !options.robot.urdf.empty(), "robot is required: the URDF");
  require(!is_merge || options.robot.urdf.empty(), "--merge needs no robot: the manifests know it");
  require(!is_merge || !options.list, "--list does not go with --merge");
  require(!options.list || options.out.empty(), "--list prints to standard output, without --out");
  require(!is_merge || !options.out.empty(), "--merge needs --out FILE");
  require(!is_part || !options.out.empty(), "--shard and --range need --out DIR");
  require(!is_npy || !options.out.empty(), "--format npy needs --out FILE");
  require(!is_npy || options.rows == RowKind::State, "--format npy does not go with --trajectory");
  require(!is_npy || options.question.objects_file.empty(),
          "--format npy does not go with --objects: it numbers the pairs of links");
  const bool is_judged = options.assert_above || !options.plot.empty() || !options.report.empty();
  require(!is_judged || (is_whole && !is_npy),
          "--assert-above, --plot and --report do not go with --shard, --range, --merge and --format npy");
  require(!options.list || options.report.empty(), "--list has no states for --report");
  const bool has_second = options.second_opinion.is_wanted;
  require(!has_second || (is_whole && !is_npy),
          "--second-opinion does not go with --shard, --range, --merge and --format npy");
  const PairSelection::Kind pairs = options.question.selection.kind;
  const bool is_any = pairs == PairSelection::Kind::Any, has_thresholds = !options.question.thresholds_file.empty();
  const bool has_accuracy = options.accuracy || options.question.selection.accuracy > 0.0;
  require(!has_accuracy || pairs == PairSelection::Kind::Minimum, "--accuracy goes with --pairs minimum only");
  require(!has_accuracy || (!has_thresholds && !has_second),
          "--accuracy does not go with --thresholds and --second-opinion, which need the distance");
  const bool has_points = !options.question.points_file.empty();
  require(!has_points || !is_any, "--points does not go with --pairs any");
  require(!has_points || !has_accuracy, "--points does not go with --pairs minimum:METRES");
  require(!has_points || !is_npy, "--points does not go with --format npy, which numbers the pairs of links");
  const bool is_uncertain = !options.question.uncertainty_text.empty();
  require(!is_uncertain || (!is_any && !has_accuracy),
          "--joint-uncertainty does not go with --pairs any and --accuracy");
  require(!is_uncertain || options.question.filter == PairFilter::On,
          "--joint-uncertainty does not go with --no-filter");
  require(!is_uncertain || (is_whole && !is_npy),
          "--joint-uncertainty does not go with --shard, --range, --merge and --format npy");
  require(!is_merge || !has_thresholds, "--merge needs no --thresholds: the parts have their levels");
  require(!has_thresholds || !is_npy, "--thresholds does not go with --format npy, whose rows have no level");
  require(!has_thresholds || !is_any, "--thresholds does not go with --pairs any, which has no levels");
  const bool shows_closest = options.rows == RowKind::Segment || pairs != PairSelection::Kind::Minimum;
  require(!has_thresholds || options.plot.empty() || shows_closest,
          "--plot shows the closest pairs, and with --thresholds --pairs minimum is another one: add --pairs k:1");
  require(options.plot.empty() || !is_any, "--plot does not go with --pairs any, which has no distances");
  require(!has_second || !is_any, "--second-opinion does not go with --pairs any, which has no distances");
}

}  // namespace proximity_server::tools
