// Checks a robot's URDF and SRDF, and lists the findings.
#include "proximity_server/scene/loading/load_robot_model.h"
#include "system/whole_file.h"
#include "tools/model_check/model_checks.h"
#include "tools/program/options.h"
#include "tools/program/progress.h"
#include "tools/program/tool_main.h"
#include "tools/robot/robot_files.h"
#include "tools/text/naming.h"
#include "tools/text/output_file.h"

#include <algorithm>
#include <filesystem>
#include <iostream>
#include <iterator>
#include <limits>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace proximity_server::tools {
namespace {

enum class FindingFormat : unsigned char { Text, Json };

struct CheckArguments {
  RobotFiles robot;
  StudyOptions study;
  double visual_tolerance = 0.02, inflation = 0.01;  ///< [m]
  std::optional<double> pinch;                       ///< [m]
  Accepted accepted;
  std::optional<Severity> fail_on = Severity::Error;
  std::string junit;
  FindingFormat format = FindingFormat::Text;
};

void declare(ProgramOptions& program, CheckArguments& arguments) {
  program.addText("robot", "FILE", arguments.robot.urdf, "the URDF").is_required = true;
  program.addText("--srdf", "FILE", arguments.robot.srdf, "its entries are checked, too");
  addRobotOptions(program, arguments.robot);
  addQuiet(program, arguments.robot.warnings);
  addLength(program, "--visual-tolerance", arguments.visual_tolerance, 0.0,
            "how far visual geometry may reach out of collision geometry (default: 0.02)");
  addLength(program, "--inflation", arguments.inflation, 0.0,
            "how far convex pieces may reach out of their mesh (default: 0.01)");
  addLength(program, "--pinch", arguments.pinch, 1e-4,
            "names pairs whose gap closes below this: a finger needs 0.025, a hand 0.1, a head 0.3 (ISO 13854)");
  addCount(program, "--samples", arguments.study.most_samples, 1, 1000000000,
           "most random states, for what is said of pairs (default: 100000)");
  addCount(program, "--seed", arguments.study.seed, 0, std::numeric_limits<long>::max(), "of these (default: 1)");
  program
      .add("--accept", "CHECK[:PLACE]", "findings that are known and right: of a check, or of one at a place",
           [&arguments](const std::string& text) { arguments.accepted.add(text); })
      .is_repeatable = true;
  program.addRead("--fail-on", "SEVERITY", arguments.fail_on,
                  oneOf<std::optional<Severity>>({{"note", Severity::Note},
                                                  {"warning", Severity::Warning},
                                                  {"error", Severity::Error},
                                                  {"never", std::nullopt}}),
                  "note, warning, error (default) or never: from which on the exit code is 2");
  program.addOutput("--junit", "FILE", arguments.junit, "the findings as tests of JUnit, for CI");
  program.addRead("--format", "FORMAT", arguments.format,
                  oneOf<FindingFormat>({{"text", FindingFormat::Text}, {"json", FindingFormat::Json}}),
                  "text (default) or json");
  addThreads(program, arguments.study.threads);
}

void append(std::vector<Finding>& all, std::vector<Finding> some) {
  all.insert(all.end(), std::make_move_iterator(some.begin()), std::make_move_iterator(some.end()));
}

/// The robot with its visual geometry, as far as its meshes can be read, each part as its convex hull.
scene::RobotModel loadVisual(const CheckArguments& arguments, const std::string& urdf) {
  scene::ModelOptions options;
  options.mesh_tolerance = 1e3;  // [m] one hull for each connected part
  options.allow_missing_meshes = true;
  options.allow_broken_mimics = arguments.robot.allow_broken_mimics;
  const std::string folder = std::filesystem::absolute(arguments.robot.urdf).parent_path();
  return scene::loadRobotModel(visualAsCollision(urdf), meshResolver(configOf(arguments.robot).robot, folder), options);
}

std::vector<Finding> findAll(const CheckArguments& arguments, const std::shared_ptr<const scene::SceneModel>& model,
                             const std::string& urdf) {
  std::vector<Finding> findings = findXacro(arguments.robot.urdf, urdf);
  append(findings, findWarnings(*model));
  append(findings, findLimits(model->robot));
  append(findings, findInflation(model->robot, arguments.inflation));
  append(findings, findVisuals(model, naming(arguments.robot.urdf, [&] { return loadVisual(arguments, urdf); }),
                               arguments.visual_tolerance));
  ProgressBar bar;
  const auto study = [&](double distance) {
    StudyOptions options = arguments.study;
    options.distance = distance;
    return studyPairs(model, options, [&](StudyStage, double done) { bar.show("pairs of links", done); });
  };
  const LevelShares shares = levelShares(model, {}, levelStates(model->robot, arguments.study.seed));
  append(findings, findPairs(*model, study(0.0), shares));
  if (arguments.pinch) append(findings, findPinchPoints(*model, study(*arguments.pinch), *arguments.pinch));
  return findings;
}

std::string subjectOf(const scene::SceneModel& model) {
  return "robot \"" + model.robot.name + "\": " + std::to_string(model.robot.links.size()) + " links, " +
         std::to_string(model.robot.joints.size()) + " joints, " + std::to_string(model.pairs.checked.size()) +
         " checked pairs";
}

/// If the robot cannot be loaded, leftovers of xacro are the likely reason, and come first.
std::shared_ptr<const scene::SceneModel> load(const CheckArguments& arguments, const std::string& urdf) {
  try {
    return loadSceneModel(arguments.robot);
  } catch (const std::invalid_argument& error) {
    const std::vector<Finding> leftovers = findXacro(arguments.robot.urdf, urdf);
    if (leftovers.empty()) throw;
    throw std::invalid_argument(leftovers.front().where + ": " + leftovers.front().what + " " +
                                leftovers.front().advice + " (" + error.what() + ")");
  }
}

ExitCode run(const CheckArguments& arguments) {
  const std::string urdf = readTextFile(arguments.robot.urdf);
  const std::shared_ptr<const scene::SceneModel> model = load(arguments, urdf);
  std::vector<Finding> findings = findAll(arguments, model, urdf);
  for (const std::string& entry : arguments.accepted.unused(findings))
    printWarnings({"--accept " + entry + ": there is no such finding"}, arguments.robot.warnings);
  findings.erase(std::remove_if(findings.begin(), findings.end(),
                                [&](const Finding& finding) { return arguments.accepted.contains(finding); }),
                 findings.end());
  const bool is_text = arguments.format == FindingFormat::Text;
  writeTo(std::cout, "standard output",
          is_text ? findingsText(subjectOf(*model), findings) : findingsJson(subjectOf(*model), findings));
  flushTo(std::cout, "standard output");
  if (!arguments.junit.empty()) system::replaceFile(arguments.junit, findingsJUnit(findings, arguments.fail_on));
  const bool fails = arguments.fail_on && std::any_of(findings.begin(), findings.end(), [&](const Finding& finding) {
                       return finding.severity >= *arguments.fail_on;
                     });
  return fails ? ExitCode::AssertionFails : ExitCode::Done;
}

}  // namespace
}  // namespace proximity_server::tools

int main(int argc, char** argv) {
  proximity_server::tools::ProgramOptions program("model_check",
                                                  "What is wrong with a robot's URDF and SRDF, before the robot moves");
  proximity_server::tools::CheckArguments arguments;
  proximity_server::tools::declare(program, arguments);
  return proximity_server::tools::runTool(program, argc, argv, [&] { return proximity_server::tools::run(arguments); });
}
