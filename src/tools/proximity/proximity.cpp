// One command for all tools, which are programs in the same folder, or in lib/proximity_server beside the folder of the
// command.

#include "proximity_server/scene/model/names.h"
#include "tools/program/tool_main.h"

#include <unistd.h>

#include <filesystem>
#include <iostream>
#include <string>
#include <system_error>
#include <vector>

namespace proximity_server::tools {
namespace {

struct Command {
  const char *name, *program, *about;
};

const Command kCommands[] = {
    {"clearance", "clearance", "how close a robot is to itself and to objects, in states and along trajectories"},
    {"audit", "pair_audit", "which pairs can collide, what an SRDF gets wrong, and a folder of parameters for a robot"},
    {"prove", "prove", "which pairs cannot come into contact"},
    {"check", "model_check", "what is wrong with a URDF and its SRDF"},
    {"explain", "explain", "how the distance of two shapes is found"},
    {"warm-cache", "warm_cache", "reads all meshes of a robot now, so that a node starts quickly"},
};

int help(std::ostream& to, ExitCode code) {
  to << "Usage: proximity COMMAND [ARGUMENTS]; proximity COMMAND --help prints what it takes\n\n";
  for (const Command& command : kCommands)
    to << "  " << command.name << std::string(12 - std::string(command.name).size(), ' ') << command.about << '\n';
  return static_cast<int>(code);
}

int run(const std::string& name, char** arguments) {
  std::vector<std::string> names;
  for (const Command& command : kCommands) {
    names.emplace_back(command.name);
    if (name != command.name) continue;
    const std::filesystem::path folder = std::filesystem::read_symlink("/proc/self/exe").parent_path();
    std::string path;
    for (const std::filesystem::path& place : {folder, folder.parent_path() / "lib" / "proximity_server"}) {
      path = place / command.program;
      execv(path.c_str(), arguments);
    }
    std::cerr << "proximity: cannot start " << path << ": " << std::generic_category().message(errno) << '\n';
    return static_cast<int>(ExitCode::BadInput);
  }
  std::cerr << "proximity: there is no command " << scene::unknownName(name, names) << '\n';
  return static_cast<int>(ExitCode::BadInput);
}

}  // namespace
}  // namespace proximity_server::tools

int main(int argc, char** argv) {
  using namespace proximity_server::tools;
  const std::string name = argc > 1 ? argv[1] : "";
  if (name.empty()) return help(std::cerr, ExitCode::BadInput);
  if (name == "--help" || name == "-h") return help(std::cout, ExitCode::Done);
  if (name == "--version") {
    std::cout << "proximity " PROXIMITY_VERSION "\n";
    return static_cast<int>(ExitCode::Done);
  }
  return run(name, argv + 1);
}
