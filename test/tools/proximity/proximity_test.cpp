// The command that starts all tools, and the tool that fills the cache of meshes.
#include "robots/urdf.h"
#include "scene/files.h"
#include "tools/program/run_command.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <string>

namespace proximity_server::tools::proximity_test {

using scene::TemporaryFiles;

const std::string kBox = robots::urdfOf(robots::link("base", robots::box("1 1 1")));

bool says(const std::string& text, const std::string& what) { return text.find(what) != std::string::npos; }

TEST(ProximityCommand, ListsItsCommands) {
  const CommandResult help = runCommandApart(PROXIMITY " --help");
  EXPECT_EQ(help.exit_code, 0);
  for (const std::string name : {"clearance", "audit", "prove", "check", "explain", "warm-cache"})
    EXPECT_TRUE(says(help.output, "\n  " + name + " ")) << name << help.output;
  EXPECT_EQ(runCommandApart(PROXIMITY).exit_code, 1);
}

TEST(ProximityCommand, StartsEachToolWithItsArgumentsAndGivesItsExitCode) {
  for (const std::string name : {"clearance", "audit", "prove", "check", "explain", "warm-cache"}) {
    const CommandResult help = runCommandApart(PROXIMITY " " + name + " --help");
    EXPECT_EQ(help.exit_code, 0) << name << help.errors;
    EXPECT_TRUE(says(help.output, "--config")) << name;
    EXPECT_EQ(says(help.output, "Exit codes: 0: "), name != "audit" && name != "check") << name;
    EXPECT_TRUE(std::all_of(help.output.begin(), help.output.end(), [](char letter) {
      return letter == '\n' || (letter >= ' ' && letter <= '~');
    })) << name;
  }
  EXPECT_EQ(runCommandApart(PROXIMITY " audit --help").output, runCommandApart(PAIR_AUDIT " --help").output);
  TemporaryFiles files;
  const CommandResult refused = runCommandApart(PROXIMITY " clearance " + files.write("box.urdf", kBox) + " --zero");
  EXPECT_EQ(refused.exit_code, 1);
  EXPECT_TRUE(says(refused.errors, "clearance: " + files.path("box.urdf") + ": no pair of links is checked"))
      << refused.errors;
}

TEST(ProximityCommand, RefusesAnUnknownNameWithTheNearest) {
  const CommandResult unknown = runCommandApart(PROXIMITY " claerance");
  EXPECT_EQ(unknown.exit_code, 1);
  EXPECT_TRUE(says(unknown.errors, "proximity: there is no command \"claerance\" (did you mean \"clearance\"?)"))
      << unknown.errors;
}

// A tetrahedron with a dent, so that it is no hull.
const std::string kDented = R"(v 0 0 0
v 1 0 0
v 0 1 0
v 0 0 1
v 0.2 0.2 0.2
f 1 3 2
f 1 2 4
f 1 4 3
f 2 3 5
f 3 4 5
f 4 2 5
)";

TEST(WarmCache, ReadsAllMeshesAndNamesTheFolder) {
  TemporaryFiles files;
  files.write("dented.obj", kDented);
  const std::string urdf = files.write("dented.urdf",
                                       "<robot name='dented'><link name='base'><collision><geometry><mesh "
                                       "filename='dented.obj'/></geometry></collision></link></robot>");
  const std::string folder = files.path("cache");
  const std::string command = "XDG_CACHE_HOME=" + folder + " " PROXIMITY " warm-cache " + urdf;
  const CommandResult first = runCommandApart(command);
  EXPECT_EQ(first.exit_code, 0) << first.errors;
  EXPECT_TRUE(says(first.output, "robot \"dented\": 1 <collision> elements, ")) << first.output;
  EXPECT_TRUE(says(first.output, "cache: " + folder + "/proximity_server\n")) << first.output;
  EXPECT_FALSE(std::filesystem::is_empty(folder + "/proximity_server"));
  const std::string config = files.write("off.yaml", "mesh_cache: \"\"");
  const CommandResult without = runCommandApart(command + " --config " + config);
  EXPECT_EQ(without.exit_code, 1);
  EXPECT_TRUE(says(without.errors, "there is no folder for a cache")) << without.errors;
}

}  // namespace proximity_server::tools::proximity_test
