// Reads all meshes of a robot into the cache, so that the first start of a node is as quick as the others.

#include "tools/program/options.h"
#include "tools/program/tool_main.h"
#include "tools/robot/robot_files.h"
#include "tools/text/output_file.h"

#include <chrono>
#include <iostream>
#include <sstream>

namespace proximity_server::tools {
namespace {

ExitCode run(const RobotFiles& files) {
  const std::string folder = configOf(files).robot.model.mesh_cache;
  if (folder.empty())
    throw std::invalid_argument("there is no folder for a cache: set HOME, XDG_CACHE_HOME or mesh_cache");
  const auto start = std::chrono::steady_clock::now();
  const std::shared_ptr<const scene::SceneModel> model = loadSceneModel(files);
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  printWarningsOf(*model, files.warnings);
  std::ostringstream text;
  text.precision(2);
  text << "robot \"" << model->robot.name << "\": " << model->robot.collisions.size() << " <collision> elements, "
       << model->robot.pieces.size() << " convex pieces, read in " << std::fixed << seconds << " s\ncache: " << folder
       << '\n';
  writeTo(std::cout, "standard output", text.str());
  flushTo(std::cout, "standard output");
  return ExitCode::Done;
}

}  // namespace
}  // namespace proximity_server::tools

int main(int argc, char** argv) {
  using namespace proximity_server::tools;
  ProgramOptions program("warm_cache", "Read all meshes of a robot now, so that a node starts quickly");
  RobotFiles files;
  program.addText("robot", "FILE", files.urdf, "the URDF").is_required = true;
  program.addText("--srdf", "FILE", files.srdf, "which pairs not to check");
  addRobotOptions(program, files);
  addQuiet(program, files.warnings);
  program.setFooter("Exit codes: 0: done; 1: bad input, or a mesh cannot be read.");
  return runTool(program, argc, argv, [&] { return run(files); });
}
