// No tool replaces a file that it reads, and what it writes appears as a whole.
#include "system/whole_file.h"
#include "tools/program/run_command.h"
#include "tools/robot/two_sliders.h"
#include "tools/states/numpy_bytes.h"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <string>
#include <vector>

namespace proximity_server::tools::outputs_test {

namespace fs = std::filesystem;

const std::string kObject = "objects:\n- {id: part, pose: {position: [2, 9, 1]}, mesh_files: [{uri: part.stl}]}\n";

/// A triangle.
const std::string kMesh =
    "solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid\n";

/// The sliders with a mesh on the mast.
std::string robotWithMesh() {
  std::string text = kTwoSliders;
  const std::string sphere = "<sphere radius=\"0.5\"/>";
  return text.replace(text.find(sphere), sphere.size(), "<mesh filename=\"mast.stl\"/>");
}

class Outputs : public ::testing::Test {
 protected:
  CommandResult run(const std::string& command) const {
    return runCommandApart("cd " + files_.path("") + " && " + command);
  }

  /// The command is refused with these two names, and the file stays as it is.
  void expectRefused(const std::string& command, const std::string& output, const std::string& input,
                     const std::string& file) const {
    const std::string before = readFile(files_.path(file));
    ASSERT_NE(before, "") << file;
    const CommandResult result = run(command);
    EXPECT_EQ(result.exit_code, 1) << command;
    EXPECT_EQ(result.output, "") << command;
    const std::string tool = fs::path(command.substr(0, command.find(' '))).filename();
    const std::string expected = tool + ": " + output + ": is the same file as " + input;
    EXPECT_EQ(result.errors, expected + ", which is read and would be lost\n") << command;
    EXPECT_EQ(readFile(files_.path(file)), before) << command;
  }

  const TemporaryFiles files_;
  const std::string states_ = files_.write("s.csv", "slide\n0\n-1\n");
  const std::string mesh_ = files_.write("mast.stl", kMesh), mesh_of_object_ = files_.write("part.stl", kMesh);
  const std::string urdf_ = files_.write("robot.urdf", robotWithMesh());
  const std::string srdf_ = files_.write("robot.srdf", "<robot name=\"two sliders\"/>\n");
  const std::string objects_ = files_.write("objects.yaml", kObject);
};

// Regression: --out emptied the states before they were read, so that all of none of them were above any distance.
TEST_F(Outputs, OfClearanceAreNoneOfItsInputs) {
  files_.write("t.yaml", "stop_distance: 0.01\n");
  files_.write("u.yaml", "joint_uncertainty: 0.001\n");
  files_.write("e.yaml", "{slide: 0.001}\n");
  files_.write("i.yaml", "[slide <= 1.7]\n");
  files_.write("slide.npy", npyHeader(npyDictionary("<f8", "(1, 1)")) + bytesOf<double>({0.0}));
  files_.write("slide.joints", "slide\n");
  const auto expect = [&](const std::string& arguments, const std::string& output, const std::string& input,
                          const std::string& file) {
    expectRefused(CLEARANCE " robot.urdf " + arguments, output, input, file);
  };
  expect("--states s.csv --assert-above 0.05 --out s.csv", "--out s.csv", "--states s.csv", "s.csv");
  expect("--zero --out robot.urdf", "--out robot.urdf", "robot robot.urdf", "robot.urdf");
  expect("--zero --srdf robot.srdf --summary robot.srdf", "--summary robot.srdf", "--srdf robot.srdf", "robot.srdf");
  expect("--zero --objects objects.yaml --out objects.yaml", "--out objects.yaml", "--objects objects.yaml",
         "objects.yaml");
  expect("--zero --thresholds t.yaml --out t.yaml", "--out t.yaml", "--thresholds t.yaml", "t.yaml");
  expect("--zero --joint-uncertainty u.yaml --out u.yaml", "--out u.yaml", "--joint-uncertainty u.yaml", "u.yaml");
  expect("--states s.csv --trajectory --tracking-error e.yaml --out e.yaml", "--out e.yaml", "--tracking-error e.yaml",
         "e.yaml");
  expect("--states w.csv --trajectory --start s.csv --out s.csv", "--out s.csv", "--start s.csv", "s.csv");
  expect("--zero --joint-inequalities i.yaml --out i.yaml", "--out i.yaml", "--joint-inequalities i.yaml", "i.yaml");
  expect("--states slide.npy --format npy --out slide.npy", "--out slide.npy", "--states slide.npy", "slide.npy");
  expect("--states slide.npy --quiet --out slide.joints", "--out slide.joints", "the names of joints slide.joints",
         "slide.joints");
  expect("--out s.csv < s.csv", "--out s.csv", "standard input /dev/stdin", "s.csv");
  expect("--states s.csv >> s.csv", "/dev/stdout", "--states s.csv", "s.csv");
}

TEST_F(Outputs, ThatAreMeshesAreRefused) {
  const std::string clearance = CLEARANCE " robot.urdf --zero --quiet ";
  expectRefused(clearance + "--out mast.stl", "--out mast.stl", "the mesh " + mesh_, "mast.stl");
  expectRefused(clearance + "--allow-missing-meshes --out mast.stl", "--out mast.stl", "the mesh " + mesh_, "mast.stl");
  expectRefused(clearance + "--objects objects.yaml --out part.stl", "--out part.stl", "the mesh " + mesh_of_object_,
                "part.stl");
  files_.write("seen.stl", kMesh);
  std::string visual = kTwoSliders;
  const std::string first = "<collision>";
  visual.insert(visual.find(first), "<visual><geometry><mesh filename=\"seen.stl\"/></geometry></visual>");
  files_.write("visual.urdf", visual);
  expectRefused(MODEL_CHECK " visual.urdf --quiet --junit seen.stl", "--junit seen.stl",
                "the mesh " + files_.path("seen.stl"), "seen.stl");
}

TEST_F(Outputs, AreNoInputsInAnySpelling) {
  const std::string clearance = CLEARANCE " robot.urdf --states s.csv ";
  fs::create_symlink("s.csv", files_.path("soft.csv"));
  fs::create_hard_link(states_, files_.path("hard.csv"));
  fs::create_symlink("soft.csv", files_.path("soft.html"));
  fs::create_symlink(states_, files_.path("soft.svg"));
  fs::create_directory(files_.path("folder"));
  for (const std::string out : {"./s.csv", "folder/../s.csv", "soft.csv", "hard.csv"})
    expectRefused(clearance + "--out " + out, "--out " + out, "--states s.csv", "s.csv");
  expectRefused(CLEARANCE " robot.urdf --states soft.csv --out hard.csv", "--out hard.csv", "--states soft.csv",
                "s.csv");
  expectRefused(clearance + "--report soft.html", "--report soft.html", "--states s.csv", "s.csv");
  expectRefused(clearance + "--plot soft.svg", "--plot soft.svg", "--states s.csv", "s.csv");
  EXPECT_TRUE(fs::is_symlink(files_.path("soft.csv")));
}

TEST_F(Outputs, OfTheOtherToolsAreNoneOfTheirInputs) {
  files_.write("box.yaml", "slide: [-0.9, 1]\n");
  fs::create_symlink("robot.urdf", files_.path("robot.png"));
  const std::string prove = PROVE " robot.urdf --box box.yaml ";
  expectRefused(prove + "--certificate box.yaml", "--certificate box.yaml", "--box box.yaml", "box.yaml");
  expectRefused(prove + "--refuting robot.urdf", "--refuting robot.urdf", "robot robot.urdf", "robot.urdf");
  const std::string audit = PAIR_AUDIT " robot.urdf --srdf robot.srdf ";
  for (const std::string option : {"--write", "--write-thresholds", "--write-safe-limits"}) {
    expectRefused(audit + option + " robot.urdf", option + " robot.urdf", "robot robot.urdf", "robot.urdf");
    expectRefused(audit + option + " robot.srdf", option + " robot.srdf", "--srdf robot.srdf", "robot.srdf");
  }
  expectRefused(MODEL_CHECK " robot.urdf --junit robot.urdf", "--junit robot.urdf", "robot robot.urdf", "robot.urdf");
  expectRefused(EXPLAIN " base ball --urdf robot.urdf --plot robot.png", "--plot robot.png", "--urdf robot.urdf",
                "robot.urdf");
}

TEST_F(Outputs, OfAMergeAreNoneOfItsParts) {
  const std::string sweep = CLEARANCE " robot.urdf --states s.csv --quiet --out parts --shard ";
  ASSERT_EQ(run(sweep + "1/2 && " + sweep + "2/2").exit_code, 0);
  const std::string part = "parts/states-000000000000-000000000001.csv", manifest = part + ".manifest";
  const std::string merge = CLEARANCE " --merge parts ";
  expectRefused(merge + "--out " + part, "--out " + part, "the part " + part, part);
  expectRefused(merge + "--out whole.csv --summary " + manifest, "--summary " + manifest, "the part " + manifest,
                manifest);
  EXPECT_FALSE(fs::exists(files_.path("whole.csv")));
}

TEST_F(Outputs, AreDifferentFiles) {
  const CommandResult result = run(PAIR_AUDIT " robot.urdf --samples 10 --write a --write-thresholds ./a");
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_EQ(result.errors,
            "pair_audit: --write-thresholds ./a: is the same file as --write a, and both would be written\n");
  EXPECT_EQ(run(CLEARANCE " robot.urdf --zero --quiet --out /dev/null --summary /dev/null").exit_code, 0);
}

TEST_F(Outputs, OfARunThatFailsLeaveWhatWasThere) {
  files_.write("bad.csv", "slide\n0\nx\n");
  files_.write("out.csv", "old\n");
  const CommandResult result = run(CLEARANCE " robot.urdf --states bad.csv --out out.csv");
  EXPECT_EQ(result.exit_code, 1) << result.errors;
  EXPECT_EQ(readFile(files_.path("out.csv")), "old\n");
  EXPECT_EQ(run("ls -A | grep tmp").output, "") << "a temporary file is left";
}

TEST_F(Outputs, KeepLinksAndPermissions) {
  files_.write("target.csv", "old\n");
  fs::create_symlink("target.csv", files_.path("out.csv"));
  ASSERT_EQ(chmod(files_.path("target.csv").c_str(), 0640), 0);
  const CommandResult result = run(CLEARANCE " robot.urdf --states s.csv --quiet --out out.csv");
  ASSERT_EQ(result.exit_code, 0) << result.errors;
  EXPECT_TRUE(fs::is_symlink(files_.path("out.csv")));
  EXPECT_EQ(readFile(files_.path("target.csv")), run(CLEARANCE " robot.urdf --states s.csv --quiet").output);
  EXPECT_EQ(fs::status(files_.path("target.csv")).permissions(), fs::perms{0640});
}

TEST_F(Outputs, ThatAreStreamsAreWrittenThrough) {
  const std::string clearance = CLEARANCE " robot.urdf --states s.csv --quiet";
  const std::string rows = run(clearance).output;
  ASSERT_EQ(std::count(rows.begin(), rows.end(), '\n'), 3);
  EXPECT_EQ(run(clearance + " --out /dev/stdout").output, rows);
  EXPECT_EQ(run("echo before > log; " + clearance + " --out /dev/stdout >> log; cat log").output, "before\n" + rows);
  EXPECT_EQ(run("mkfifo pipe; cat pipe > copy & " + clearance + " --out pipe; wait; cat copy").output, rows);
  EXPECT_TRUE(fs::is_fifo(files_.path("pipe")));
}

}  // namespace proximity_server::tools::outputs_test
