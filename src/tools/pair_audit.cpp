// Which pairs of a robot's links can collide at all, and what its SRDF gets wrong about them.
#include <CLI/CLI.hpp>

#include <algorithm>
#include <fstream>
#include <iostream>
#include <stdexcept>
#include <string>
#include <thread>

#include "audit_report.h"
#include "pair_study.h"
#include "progress_bar.h"
#include "robot_files.h"
#include "srdf_writer.h"

namespace proximity_server {
namespace {

struct Arguments {
  RobotFiles robot;
  StudyOptions study;
  std::string write;
};

void declare(CLI::App& app, Arguments& arguments) {
  StudyOptions& study = arguments.study;
  study.threads = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  app.add_option("robot", arguments.robot.urdf, "the URDF")->required();
  app.add_option("--srdf", arguments.robot.srdf, "what to compare with, and what --write keeps the rest of");
  app.add_option("--mesh-tolerance", arguments.robot.mesh_tolerance, "[m] how far pieces may lie from their mesh")
      ->check(CLI::NonNegativeNumber);
  app.add_option("--samples", study.most_samples,
                 "most random states (default: 100000); fewer where the classes of the pairs settle before")
      ->check(CLI::Range(1L, 1000000000L));
  app.add_option("--seed", study.seed, "of the random states (default: 1)")->check(CLI::NonNegativeNumber);
  app.add_option("--write", arguments.write, "an SRDF that disables what is adjacent, always or never in contact");
  app.add_option("--threads", study.threads, "default: all cores; the output is the same for any number")
      ->check(CLI::Range(1, 1024));
}

PairStudy studyWithProgress(const std::shared_ptr<const SceneModel>& model, const StudyOptions& options) {
  ProgressBar bar;
  return studyPairs(model, options, [&](StudyStage stage, double done) {
    bar.show(stage == StudyStage::Sampling ? "random states" : "searches and proofs", done);
  });
}

/// Throws std::invalid_argument naming the file where it cannot be written.
void writeFile(const std::string& path, const std::string& text) {
  std::ofstream stream(path, std::ios::binary);
  stream << text << std::flush;
  if (!stream) throw std::invalid_argument(path + ": cannot be written");
}

void run(const Arguments& arguments) {
  const std::shared_ptr<const SceneModel> model = loadSceneModel(arguments.robot);
  for (const std::string& warning : model->robot.warnings) std::cerr << "warning: " << warning << '\n';
  const PairStudy study = studyWithProgress(model, arguments.study);
  const bool has_srdf = !arguments.robot.srdf.empty();
  std::cout << auditReport(*model, study, has_srdf ? SrdfGiven::Yes : SrdfGiven::No) << std::flush;
  if (!std::cout) throw std::invalid_argument("standard output: writing failed");
  if (arguments.write.empty()) return;
  const std::string srdf = has_srdf ? readTextFile(arguments.robot.srdf) : "";
  writeFile(arguments.write, writeSrdf(srdf, model->robot, study));
}

}  // namespace
}  // namespace proximity_server

int main(int argc, char** argv) {
  CLI::App app("Which pairs of a robot's links can collide at all, and what its SRDF gets wrong about them");
  proximity_server::Arguments arguments;
  proximity_server::declare(app, arguments);
  CLI11_PARSE(app, argc, argv);
  try {
    proximity_server::run(arguments);
  } catch (const std::invalid_argument& error) {
    std::cerr << "pair_audit: " << error.what() << '\n';
    return 1;
  }
  return 0;
}
