// Which pairs of a robot's links can collide at all, and what its SRDF gets wrong about them.
#include <CLI/CLI.hpp>

#include <fstream>
#include <iostream>
#include <limits>
#include <stdexcept>
#include <string>

#include "tools/command_line/number_options.h"
#include "tools/command_line/output_file.h"
#include "tools/command_line/progress_bar.h"
#include "tools/command_line/robot_files.h"
#include "tools/command_line/tool_main.h"
#include "tools/pair_audit/audit_report.h"
#include "tools/pair_audit/pair_study.h"
#include "tools/pair_audit/srdf_writer.h"

namespace proximity_server::tools {
namespace {

constexpr double kStopDistance = 0.02;  // [m] the default of the node

struct Arguments {
  RobotFiles robot;
  StudyOptions study;
  std::string write;
};

void declare(CLI::App& app, Arguments& arguments) {
  StudyOptions& study = arguments.study;
  study.distance = kStopDistance;
  const auto addFile = [&](const std::string& name, std::string& path, const std::string& description) {
    return app.add_option(name, path, description)->type_name("FILE");
  };
  addFile("robot", arguments.robot.urdf, "the URDF")->required();
  addFile("--srdf", arguments.robot.srdf, "what to compare with, and what --write keeps the rest of");
  addMeshTolerance(app, arguments.robot.mesh_tolerance);
  addLength(app, "--distance", study.distance, 0.0,
            "up to which two links count as near (default: 0.02, the stop distance of the node; 0: contact)");
  addCount(app, "--samples", study.most_samples, 1, 1000000000,
           "most random states (default: 100000); fewer where the classes of the pairs settle before");
  addCount(app, "--seed", study.seed, 0, std::numeric_limits<long>::max(), "of the random states (default: 1)");
  addFile("--write", arguments.write, "an SRDF that disables what is adjacent, always in contact or never near");
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

ExitCode run(const Arguments& arguments) {
  if (!arguments.write.empty()) requireWritable(arguments.write);
  const std::shared_ptr<const scene::SceneModel> model = loadSceneModel(arguments.robot);
  printWarnings(*model);
  const PairStudy study = studyWithProgress(model, arguments.study);
  const bool has_srdf = !arguments.robot.srdf.empty();
  writeTo(std::cout, "standard output", auditReport(*model, study, has_srdf ? SrdfGiven::Yes : SrdfGiven::No));
  flushTo(std::cout, "standard output");
  if (arguments.write.empty()) return ExitCode::Done;
  const std::string srdf = has_srdf ? readTextFile(arguments.robot.srdf) : "";
  writeFile(arguments.write, writeSrdf(srdf, model->robot, study));
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
