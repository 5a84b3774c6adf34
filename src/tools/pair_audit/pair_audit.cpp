// Which pairs of a robot's links can collide at all, and what its SRDF gets wrong about them.
#include <CLI/CLI.hpp>

#include <algorithm>
#include <fstream>
#include <iostream>
#include <limits>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "proximity_server/scene/query/always_near.h"
#include "tools/command_line/number_options.h"
#include "tools/command_line/output_file.h"
#include "tools/command_line/progress_bar.h"
#include "tools/command_line/robot_files.h"
#include "tools/command_line/tool_main.h"
#include "tools/pair_audit/audit_report.h"
#include "tools/pair_audit/level_shares.h"
#include "tools/pair_audit/pair_study.h"
#include "tools/pair_audit/srdf_writer.h"

namespace proximity_server::tools {
namespace {

constexpr scene::StopAndWarn kUsual{0.02, 0.05};  // [m] the defaults of the node

struct Arguments {
  RobotFiles robot;
  StudyOptions study;
  std::string write, write_thresholds;
};

void declare(CLI::App& app, Arguments& arguments) {
  StudyOptions& study = arguments.study;
  study.distance = kUsual.stop;
  study.warn_distance = kUsual.warn;
  const auto addFile = [&](const std::string& name, std::string& path, const std::string& description) {
    return app.add_option(name, path, description)->type_name("FILE");
  };
  addFile("robot", arguments.robot.urdf, "the URDF")->required();
  addFile("--srdf", arguments.robot.srdf, "what to compare with, and what --write keeps the rest of");
  addMeshTolerance(app, arguments.robot.mesh_tolerance);
  addLength(app, "--distance", study.distance, 0.0,
            "up to which two links count as near (default: 0.02, the stop distance of the node; 0: contact)");
  addLength(app, "--warn-distance", study.warn_distance, 0.0,
            "pairs that are always within it get thresholds of their own (default: 0.05, that of the node)");
  addCount(app, "--samples", study.most_samples, 1, 1000000000,
           "most random states (default: 100000); fewer where the classes of the pairs settle before");
  addCount(app, "--seed", study.seed, 0, std::numeric_limits<long>::max(), "of the random states (default: 1)");
  addFile("--write", arguments.write, "an SRDF that disables what is adjacent, always in contact or never near");
  addFile("--write-thresholds", arguments.write_thresholds,
          "parameters of the node (YAML): stop and warn distances for the pairs that are always near");
  addThreads(app, study.threads);
}

PairStudy studyWithProgress(const std::shared_ptr<const scene::SceneModel>& model, const StudyOptions& options) {
  ProgressBar bar;
  return studyPairs(model, options, [&](StudyStage stage, double done) {
    bar.show(stage == StudyStage::Sampling ? "random states" : "searches and proofs", done);
  });
}

/// Throws std::invalid_argument naming the file if it cannot be written.
void writeFile(const std::string& path, const std::string& text) {
  std::ofstream stream(path, std::ios::binary);
  writeTo(stream, path, text);
  flushTo(stream, path);
}

std::string srdfOf(const Arguments& arguments) {
  return arguments.robot.srdf.empty() ? "" : readTextFile(arguments.robot.srdf);
}

/// The thresholds of pairs that get none of their own.
scene::StopAndWarn usualOf(const StudyOptions& options) {
  return {options.distance, std::max(options.distance, options.warn_distance)};
}

/// What the tool proposes for a robot.
struct Proposal {
  std::string srdf;
  std::vector<scene::AlwaysNear> near;
};

/// The table of levels with the given SRDF and the usual thresholds, and with the proposal.
std::string sharesText(const std::shared_ptr<const scene::SceneModel>& model, const Proposal& proposal,
                       const StudyOptions& options) {
  const scene::StopAndWarn usual = usualOf(options);
  const auto proposed = std::make_shared<const scene::SceneModel>(
      scene::SceneModel{model->robot, scene::filterPairs(model->robot, proposal.srdf)});
  return levelTable(countLevels(model, usual, {}, options.seed),
                    countLevels(proposed, usual, proposal.near, options.seed));
}

std::string thresholdsText(const scene::SceneModel& model, const Proposal& proposal, const StudyOptions& options) {
  return "# Stop and warn distances of the pairs of \"" + model.robot.name +
         "\" that are always near, with the distances that were seen.\n" +
         scene::thresholdsYaml(model.robot, proposal.near, usualOf(options));
}

/// Writes the files that the options ask for.
void writeProposal(const Arguments& arguments, const std::shared_ptr<const scene::SceneModel>& model,
                   const PairStudy& study) {
  const std::string given = srdfOf(arguments);
  Proposal proposal{arguments.write.empty() ? given : writeSrdf(given, model->robot, study), {}};
  if (!arguments.write.empty()) writeFile(arguments.write, proposal.srdf);
  if (!arguments.write_thresholds.empty()) {
    proposal.near = alwaysNear(study, scene::filterPairs(model->robot, proposal.srdf));
    writeFile(arguments.write_thresholds, thresholdsText(*model, proposal, arguments.study));
  }
  writeTo(std::cout, "standard output", sharesText(model, proposal, arguments.study));
}

ExitCode run(const Arguments& arguments) {
  for (const std::string& file : {arguments.write, arguments.write_thresholds}) {
    if (!file.empty()) requireWritable(file);
  }
  const std::shared_ptr<const scene::SceneModel> model = loadSceneModel(arguments.robot);
  printWarnings(*model);
  const PairStudy study = studyWithProgress(model, arguments.study);
  const SrdfGiven srdf = arguments.robot.srdf.empty() ? SrdfGiven::No : SrdfGiven::Yes;
  writeTo(std::cout, "standard output", auditReport(*model, study, srdf));
  if (!arguments.write.empty() || !arguments.write_thresholds.empty()) writeProposal(arguments, model, study);
  flushTo(std::cout, "standard output");
  return ExitCode::Done;
}

}  // namespace
}  // namespace proximity_server::tools

int main(int argc, char** argv) {
  CLI::App app("Which pairs of a robot's links can collide at all, and what its SRDF gets wrong about them",
               "pair_audit");
  proximity_server::tools::Arguments arguments;
  proximity_server::tools::declare(app, arguments);
  return proximity_server::tools::runTool(app, argc, argv, [&] { return proximity_server::tools::run(arguments); });
}
