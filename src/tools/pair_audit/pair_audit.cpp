// Which pairs of a robot's links can collide at all, and what its SRDF gets wrong about them.
#include "proximity_server/scene/levels/always_near.h"
#include "system/whole_file.h"
#include "tools/pair_audit/audit_report.h"
#include "tools/pair_audit/level_report.h"
#include "tools/pair_audit/level_shares.h"
#include "tools/pair_audit/pair_study.h"
#include "tools/pair_audit/range_search.h"
#include "tools/pair_audit/robot_setup.h"
#include "tools/pair_audit/safe_limits.h"
#include "tools/pair_audit/srdf_writer.h"
#include "tools/program/options.h"
#include "tools/program/progress.h"
#include "tools/program/time_budget.h"
#include "tools/program/tool_main.h"
#include "tools/robot/robot_files.h"
#include "tools/states/csv_states.h"
#include "tools/text/csv.h"
#include "tools/text/output_file.h"

#include <algorithm>
#include <iostream>
#include <limits>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

namespace proximity_server::tools {
namespace {

constexpr scene::StopAndWarn kUsual{0.02, 0.05};  // [m] the defaults of the node

/// How --setup treats suspects, see PairLevels: it asks a person, or disables them.
enum class Overlaps : unsigned char { Asked, Accepted };

struct AuditArguments {
  RobotFiles robot;
  StudyOptions study;
  std::string write, write_thresholds, write_limits, setup;
  std::string rest_text;
  std::optional<scene::Positions> rest;  ///< of rest_text
  Overlaps overlaps = Overlaps::Asked;
  std::optional<double> ranges;  ///< [m] how far apart pairs are in the ranges to print
  double safe_distance = 0.0;    ///< [m]
  long boxes = 2000;
};

void declare(ProgramOptions& program, AuditArguments& arguments) {
  StudyOptions& study = arguments.study;
  study.distance = kUsual.stop;
  study.warn_distance = kUsual.warn;
  program.addText("robot", "FILE", arguments.robot.urdf, "the URDF").is_required = true;
  program.addText("--srdf", "FILE", arguments.robot.srdf, "what to compare with, and what --write keeps the rest of");
  addRobotOptions(program, arguments.robot);
  addJointInequalities(program, arguments.robot);
  addQuiet(program, arguments.robot.warnings);
  addLength(program, "--distance", study.distance, 0.0,
            "up to which two links count as near (default: 0.02, the stop distance of the node; 0: contact)");
  addLength(program, "--warn-distance", study.warn_distance, 0.0,
            "pairs that are always within it get thresholds of their own (default: 0.05, that of the node)");
  addCount(program, "--samples", study.most_samples, 1, 1000000000,
           "most random states (default: 100000); fewer where the classes of the pairs settle before");
  addCount(program, "--proof-boxes", study.most_boxes, 1, 1000000000,
           "parts into which the proof that a pair is never near divides its joint ranges (default: 10000)");
  addCount(program, "--seed", study.seed, 0, std::numeric_limits<long>::max(), "of the random states (default: 1)");
  program.addOutput("--write", "FILE", arguments.write,
                    "an SRDF that disables what is adjacent, always in contact or never near");
  program.addOutput("--write-thresholds", "FILE", arguments.write_thresholds,
                    "parameters of the node (YAML): stop and warn distances for the pairs that are always near");
  addLength(program, "--ranges", arguments.ranges, 0.0,
            "print ranges of joint positions in which pairs are proven this far apart");
  program.addOutput("--write-safe-limits", "FILE", arguments.write_limits,
                    "limits for prove --box, within which the robot is proven not to collide with itself");
  addLength(program, "--safe-distance", arguments.safe_distance, 0.0,
            "how far pairs but neighbours are proven apart there, as 0.025 for a finger (default: not in contact)")
      .needs = "--write-safe-limits";
  addCount(program, "--boxes", arguments.boxes, 1, 1000000000,
           "parts into which a proof of these two divides a box (default: 2000)");
  program.addOutput(
      "--setup", "DIR", arguments.setup,
      "a new folder with all that the node needs for the robot: URDF, SRDF, thresholds, launch file, rostest");
  program
      .addFlag("--accept-overlaps", arguments.overlaps, Overlaps::Accepted,
               "disable the pairs that are in contact at rest or in more than half of the states")
      .needs = "--setup";
  program
      .addText("--rest", "\"JOINT=POSITION ...\"", arguments.rest_text,
               "a state in which the robot rests, the other joints at 0 (default: all)")
      .needs = "--setup";
  addTimeBudget(
      program, study.budget,
      "look at pairs no longer, and say what is left out; ranges and limits end with an error (default: none)");
  addThreads(program, study.threads);
  program.atMostOneOf({"--joint-inequalities", "--setup"});
  program.atMostOneOf({"--config", "--setup"});
}

PairStudy studyWithProgress(const std::shared_ptr<const scene::SceneModel>& model, const StudyOptions& options) {
  ProgressBar bar;
  return studyPairs(model, options, [&](StudyStage stage, double done) {
    bar.show(stage == StudyStage::Sampling    ? "random states"
             : stage == StudyStage::Searching ? "searches"
                                              : "proofs",
             done);
  });
}

/// The thresholds of pairs that get none of their own.
scene::StopAndWarn usualOf(const StudyOptions& options) {
  return {options.distance, std::max(options.distance, options.warn_distance)};
}

/// The proposal of the tool for a robot, as far as the options ask for it.
struct Proposal {
  std::string srdf;
  std::shared_ptr<const scene::SceneModel> model;  ///< with that SRDF
  scene::StopAndWarn usual;
  std::vector<scene::AlwaysNear> near;  ///< pairs with thresholds of their own

  scene::LevelThresholds thresholds() const { return scene::thresholdsWith(near, usual); }
};

Proposal propose(const AuditArguments& arguments, const scene::SceneModel& model, const PairStudy& study,
                 const std::vector<PairLevels>& overlaps = {}) {
  const bool has_srdf = !arguments.write.empty() || (!arguments.setup.empty() && arguments.robot.srdf.empty());
  const bool has_thresholds = !arguments.write_thresholds.empty() || !arguments.setup.empty();
  const std::string given = srdfOf(arguments.robot);
  const std::string srdf = withDisabled(has_srdf ? writeSrdf(given, model.robot, study) : given, model.robot, overlaps);
  const auto proposed = std::make_shared<const scene::SceneModel>(
      scene::SceneModel{model.robot, scene::filterPairs(model.robot, srdf, configOf(arguments.robot).robot.filter)});
  return {srdf, proposed, usualOf(arguments.study),
          has_thresholds ? alwaysNear(study, proposed->pairs) : std::vector<scene::AlwaysNear>()};
}

std::string thresholdsText(const Proposal& proposal) {
  return "# Stop and warn distances of the pairs that are always near, with the distances that were seen.\n" +
         scene::thresholdsYaml(proposal.model->robot, proposal.near, proposal.usual);
}

std::string parametersText(const Proposal& proposal, const RobotFiles& files) {
  const scene::StopAndWarn& usual = proposal.usual;
  return "# Parameters of proximity_server_node; config/PARAMETERS.md of the package has all of "
         "them.\nstop_distance: " +
         shortest(usual.stop) + "\nwarn_distance: " + shortest(usual.warn) + "\n" +
         (files.mesh_tolerance ? "mesh_tolerance: " + shortest(*files.mesh_tolerance) + "\n" : "") +
         (files.allow_missing_meshes ? "allow_missing_meshes: true\n" : "") +
         (files.allow_broken_mimics ? "allow_broken_mimics: true\n" : "") + thresholdsText(proposal);
}

std::string acceptedText(const scene::RobotModel& robot, const std::vector<PairLevels>& overlaps) {
  std::string text = "\naccepted as overlaps of the model (" + std::to_string(overlaps.size()) + ")\n";
  for (const PairLevels& pair : overlaps) text += "  " + disablingEntry(robot, pair) + "\n";
  return text;
}

std::string readyText(const std::string& folder) {
  return "\n" + folder + " is ready: roslaunch " + folder + "/proximity.launch simulate:=true\n";
}

/// The text of a folder with suspects, about which a person has to decide first. `disabled` has the levels without them.
std::string notReadyText(const std::string& folder, const std::vector<PairLevels>& suspects, const RestState& rest,
                         const LevelShares& disabled) {
  const bool rests = rest.level < scene::ClearanceLevel::Collision;
  return "\n" + folder + " is not ready: pairs in contact at rest or in more than half of the states (" +
         std::to_string(suspects.size()) + "). Decide:\n" +
         "  Do they overlap in the model only? Paste their lines into " + folder +
         "/robot.srdf, or use --accept-overlaps with a new folder. Then " + levelsText(disabled) + ".\n" +
         "  Does the robot never rest so? Say how it does: --rest \"JOINT=POSITION ...\"" +
         (rests ? " (rest.yaml has a state at " + std::string(toString(rest.level)) + ")" : "") + ".\n" +
         "  Otherwise mend the geometry, or the limits of the joints.\n";
}

/// Writes what the options ask for, and the table of levels before and after.
ExitCode writeProposal(const AuditArguments& arguments, const std::shared_ptr<const scene::SceneModel>& model,
                       const PairStudy& study) {
  const std::vector<scene::Positions> states = levelStates(model->robot, arguments.study.seed, arguments.rest);
  const auto levelsOf = [&](const Proposal& proposal) {
    return levelShares(proposal.model, proposal.thresholds(), states);
  };
  Proposal proposal = propose(arguments, *model, study);
  LevelShares shares = levelsOf(proposal);
  if (arguments.overlaps == Overlaps::Accepted) {
    writeTo(std::cout, "standard output", acceptedText(model->robot, shares.suspects()));
    proposal = propose(arguments, *model, study, shares.suspects());
    shares = levelsOf(proposal);
  }
  if (!arguments.write.empty()) system::replaceFile(arguments.write, proposal.srdf);
  if (!arguments.write_thresholds.empty()) system::replaceFile(arguments.write_thresholds, thresholdsText(proposal));
  const LevelShares before = levelShares(model, scene::thresholdsWith({}, proposal.usual), states);
  writeTo(std::cout, "standard output",
          levelTable(before, shares) + levelReport(model->robot, study, shares, proposal.usual));
  if (arguments.setup.empty()) return ExitCode::Done;
  const RestState at_rest = restState(states, shares, arguments.rest ? Rest::Chosen : Rest::Found);
  writeSetup(arguments.setup, model->robot,
             {arguments.robot.urdf, proposal.srdf, parametersText(proposal, arguments.robot), at_rest});
  const std::vector<PairLevels> suspects = shares.suspects();
  writeTo(std::cout, "standard output",
          suspects.empty() ? readyText(arguments.setup)
                           : notReadyText(arguments.setup, suspects, at_rest,
                                          levelsOf(propose(arguments, *model, study, suspects))));
  return suspects.empty() ? ExitCode::Done : ExitCode::AssertionFails;
}

/// Calls `search(options)` with these options and a progress bar, and returns its result.
template <typename Search>
auto searchRanges(const AuditArguments& arguments, double distance, const std::string& what, const Search& search) {
  ProgressBar bar;
  RangeOptions options{distance,
                       arguments.boxes,
                       arguments.study.seed,
                       arguments.study.budget,
                       arguments.study.threads,
                       [&](double done) { bar.show(what, done); }};
  return search(options);
}

/// Prints and writes what is proven of joint ranges, as far as the options ask for it.
void writeProofs(const AuditArguments& arguments, const std::shared_ptr<const scene::SceneModel>& model,
                 const PairStudy& study) {
  if (arguments.ranges) {
    const std::vector<PairRanges> pairs =
        searchRanges(arguments, *arguments.ranges, "ranges",
                     [&](const RangeOptions& options) { return provenRanges(model, study, options); });
    writeTo(std::cout, "standard output", rangesText(model->robot, pairs));
  }
  if (!arguments.write_limits.empty()) {
    const SafeLimits safe =
        searchRanges(arguments, arguments.safe_distance, "safe limits",
                     [&](const RangeOptions& options) { return safeLimits(model, study, options); });
    writeTo(std::cout, "standard output", safeLimitsText(model->robot, safe));
    system::replaceFile(arguments.write_limits, safeLimitsYaml(model->robot, safe));
  }
}

ExitCode run(AuditArguments& arguments) {
  if (!arguments.setup.empty()) requireEmpty(arguments.setup);
  const std::shared_ptr<const scene::SceneModel> model = loadSceneModel(arguments.robot);
  printWarningsOf(*model, arguments.robot.warnings);
  if (!arguments.rest_text.empty())
    arguments.rest = readState("--rest", arguments.rest_text, model->robot, arguments.robot.warnings);
  arguments.study.budget.begin();
  StudyOptions options = arguments.study;
  options.warn_distance = std::max(options.warn_distance, arguments.safe_distance);
  const PairStudy study = studyWithProgress(model, options);
  const SrdfGiven srdf = arguments.robot.srdf.empty() ? SrdfGiven::No : SrdfGiven::Yes;
  writeTo(std::cout, "standard output", auditReport(*model, study, srdf));
  const bool writes = !arguments.write.empty() || !arguments.write_thresholds.empty() || !arguments.setup.empty();
  const ExitCode code = writes ? writeProposal(arguments, model, study) : ExitCode::Done;
  writeProofs(arguments, model, study);
  flushTo(std::cout, "standard output");
  return code;
}

}  // namespace
}  // namespace proximity_server::tools

int main(int argc, char** argv) {
  proximity_server::tools::ProgramOptions program(
      "pair_audit", "Which pairs of a robot's links can collide at all, and what its SRDF gets wrong about them");
  proximity_server::tools::AuditArguments arguments;
  proximity_server::tools::declare(program, arguments);
  return proximity_server::tools::runTool(program, argc, argv, [&] { return proximity_server::tools::run(arguments); });
}
