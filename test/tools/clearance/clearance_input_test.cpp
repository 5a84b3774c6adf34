// Checks the messages of the executable about its input and its options, and how it ends.
#include "sanitized.h"
#include "tools/program/clearance_command.h"
#include "tools/states/numpy_bytes.h"

#include <algorithm>
#include <filesystem>

namespace proximity_server::tools::clearance_input_test {

using namespace scene;

// Regression: an id of 50 MB came back whole.
TEST_F(Clearance, CutsNamesOfAnyLengthInErrors) {
  const std::string id(5000000, 'x');
  const std::string objects = files_.write(
      "o.yaml", "objects: [{id: " + id + ", link: " + id + ", primitives: [{type: SPHERE, dimensions: [0.1]}]}]\n");
  const CommandResult result = run("slide\n0\n", "--objects " + objects);
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_LT(result.errors.size(), 3000U);
  EXPECT_TRUE(says(result.errors, "bytes left out)...xxx")) << result.errors;
}

TEST_F(Clearance, GivesTheSameRowsForAStateFromAnySource) {
  const auto runOn = [&](const std::string& arguments) {
    return runCommandApart(CLEARANCE " " + urdf_ + " " + arguments);
  };
  const std::string numbers = bytesOf<double>({-1.0, 0.5, 2.0});
  files_.write("s.npy", npyHeader(npyDictionary("<f8", "(3, 1)")) + numbers);
  files_.write("table", npyHeader(npyDictionary("<f8", "(3, 1)")) + numbers);
  const CommandResult expected = run("slide\n-1\n0.5\n2\n", "");
  EXPECT_EQ(rowsOf(expected.output).size(), 4U) << expected.errors;
  for (const std::string& source :
       {"--states " + files_.path("s.npy") + " --joints slide", "--states " + files_.path("table") + " --joints slide",
        std::string("--grid slide=-1:2:3"), std::string("--grid 3"), "--states - < " + files_.path("s.csv")}) {
    EXPECT_EQ(runOn(source).output, expected.output) << source;
    EXPECT_EQ(runOn("--threads 2 " + source).output, expected.output) << source;
  }
  const std::string way = "--trajectory --states ";
  const CommandResult along = runOn(way + files_.path("s.npy") + " --joints slide");
  EXPECT_EQ(rowsOf(along.output).size(), 3U) << along.errors;
  EXPECT_EQ(along.output, runOn(way + files_.path("s.csv")).output);
}

TEST_F(Clearance, ReadsStatesFromAPipe) {
  const CommandResult expected = run("slide\n-1\n0.5\n", "");
  const CommandResult piped =
      runCommandApart("cat " + files_.path("s.csv") + " | " CLEARANCE " " + urdf_ + " --states /dev/stdin");
  EXPECT_EQ(piped.output, expected.output) << piped.errors;
}

// Compressed by zlib: 100,000 zeros.
TEST_F(Clearance, SaysWhereACompressedArrayCannotBeUnpacked) {
  const std::string script =
      "import numpy as np; np.savez_compressed(\"" + files_.path("s.npz") + "\", states=np.zeros((100000, 1)))";
  if (runCommand("/usr/bin/python3 -c '" + script + "' 2>&1").exit_code != 0) GTEST_SKIP() << "needs python3-numpy";
  const std::string command =
      CLEARANCE " " + urdf_ + " --joints slide --out /dev/null --states " + files_.path("s.npz");
  const auto expect = [&](const std::string& before, const std::string& message) {
    const CommandResult result = runCommandApart(before + command);
    EXPECT_EQ(result.exit_code, 1);
    EXPECT_TRUE(says(result.errors, message)) << result.errors;
  };
  expect("TMPDIR=/nowhere ", "s.npz, states.npy: no folder for temporary files to unpack it into; set TMPDIR\n");
  expect("trap '' XFSZ; ulimit -f 64; ", ": writing failed, to unpack " + files_.path("s.npz") + ", states.npy\n");
}

// Regression: a signal ended the tool at the largest size of a file, and a full disk had no reason.
TEST_F(Clearance, NamesTheFileThatCannotBeWrittenAndWhy) {
  const std::string command = CLEARANCE " " + urdf_ + " --sample 20000 ";
  const auto expect = [&](const std::string& before, const std::string& output, const std::string& message) {
    const CommandResult result = runCommandApart(before + command + output);
    EXPECT_EQ(result.exit_code, 1);
    EXPECT_TRUE(says(result.errors, "clearance: " + message)) << result.errors;
  };
  const std::string file = files_.path("rows.csv");
  expect("ulimit -f 64; ", "--out " + file, file + ": writing failed (File too large)\n");
  expect("ulimit -f 64; ", "> " + file, "standard output: writing failed (File too large)\n");
  if (!std::filesystem::exists("/dev/full")) GTEST_SKIP() << "there is no /dev/full";
  expect("", "--out /dev/full", "/dev/full: writing failed (No space left on device)\n");
  expect("", "> /dev/full", "standard output: writing failed (No space left on device)\n");
}

TEST_F(Clearance, PrintsTheWarningsOfModelAndSrdf) {
  urdf_ = files_.write("crossing.urdf", kCrossingSliders);
  const CommandResult result = run("slide\n0\n", "--srdf " + files_.write("faulty.srdf", kFaultySrdf));
  const std::vector<std::string> warnings = filterPairs(crossingSlidersStudy().model->robot, kFaultySrdf).warnings;
  ASSERT_FALSE(warnings.empty());
  for (const std::string& warning : warnings) {
    EXPECT_TRUE(says(result.errors, "warning: " + warning + "\n")) << result.errors;
  }
  EXPECT_EQ(rowsOf(result.output).size(), 2U);
}

TEST_F(Clearance, IsQuietIfAsked) {
  urdf_ = files_.write("crossing.urdf", kCrossingSliders);
  const std::string srdf = "--srdf " + files_.write("faulty.srdf", kFaultySrdf);
  const CommandResult loud = run("time,slide\n0,9\n", srdf), quiet = run("time,slide\n0,9\n", srdf + " --quiet");
  for (const std::string what : {"disable_collisions", "column \"time\"", "beyond the limits"})
    EXPECT_TRUE(says(loud.errors, what)) << loud.errors;
  EXPECT_EQ(quiet.errors, "");
  EXPECT_EQ(quiet.output, loud.output);
}

// One joint of each type, one that follows another, and a mesh that is not there.
const char* const kAllJoints = R"(<robot name="all">
  <link name="base"><collision><geometry><box size="1 1 1"/></geometry></collision></link>
  <link name="a"><collision><geometry><mesh filename="package://nowhere/a.stl"/></geometry></collision></link>
  <link name="b"/><link name="c"/><link name="d"/><link name="e"/><link name="f"/>
  <joint name="turn" type="revolute"><parent link="base"/><child link="a"/>
    <limit lower="-2.5" upper="-0.5" effort="1" velocity="1"/></joint>
  <joint name="wheel, left" type="continuous"><parent link="base"/><child link="b"/></joint>
  <joint name="slide" type="prismatic"><parent link="base"/><child link="c"/>
    <limit lower="0.25" upper="1" effort="1" velocity="1"/></joint>
  <joint name="drift" type="floating"><parent link="base"/><child link="d"/></joint>
  <joint name="finger" type="prismatic"><parent link="base"/><child link="e"/>
    <limit lower="0.5" upper="1" effort="1" velocity="1"/><mimic joint="slide" multiplier="2"/></joint>
  <joint name="weld" type="fixed"><parent link="base"/><child link="f"/></joint>
</robot>)";

TEST_F(Clearance, ListsTheJointsWithoutReadingAMesh) {
  const CommandResult result = runCommandApart(CLEARANCE " " + files_.write("all.urdf", kAllJoints) + " --list");
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_EQ(result.errors, "");
  EXPECT_EQ(result.output,
            "joint,type,lower,upper,unit,mimic\n"
            "drift,floating,-inf,inf,,\n"
            "finger,prismatic,0.5,1,m,slide\n"
            "slide,prismatic,0.25,1,m,\n"
            "turn,revolute,-2.5,-0.5,rad,\n"
            "\"wheel, left\",continuous,-inf,inf,rad,\n");
}

TEST_F(Clearance, ZeroIsTheStateNearestToZeroWithinTheLimits) {
  std::string urdf = kAllJoints;
  const std::string mesh = R"(<mesh filename="package://nowhere/a.stl"/>)";
  urdf.replace(urdf.find(mesh), mesh.size(), R"(<sphere radius="0.1"/>)");
  const std::string robot = CLEARANCE " " + files_.write("all.urdf", urdf);
  const CommandResult zero = runCommandApart(robot + " --no-filter --zero --assert-above 0");
  EXPECT_TRUE(says(zero.errors, "with turn=-0.5")) << zero.errors;
  const std::string sliders = CLEARANCE " " + urdf_ + " ";
  EXPECT_EQ(runCommandApart(sliders + "--zero").output, run("slide\n0\n", "").output);
  EXPECT_TRUE(says(runCommandApart(sliders + "--zero --sample 1").errors, "excludes")) << "two sources";
}

TEST_F(Clearance, AllowsAMimicThatMakesNoSenseIfAsked) {
  std::string urdf = kAllJoints;
  urdf.replace(urdf.find("joint=\"slide\" multiplier"), 13, "joint=\"slyde\"");
  urdf.replace(urdf.find("<link name=\"e\"/>"), 16,
               "<link name=\"e\"><collision><geometry><sphere radius=\"0.1\"/></geometry></collision></link>");
  const std::string list = CLEARANCE " " + files_.write("broken.urdf", urdf) + " --list";
  const CommandResult refused = runCommandApart(list);
  EXPECT_EQ(refused.exit_code, 1);
  EXPECT_TRUE(says(refused.errors,
                   "joint \"finger\" mimics the unknown joint \"slyde\" (did you mean \"slide\"?); with "
                   "allow_broken_mimics"))
      << refused.errors;
  EXPECT_TRUE(says(runCommandApart(list + " --allow-broken-mimics").output, "finger,prismatic,0.5,1,m,\n"));
}

TEST_F(Clearance, ReportsStatesBeyondTheLimitsAtTheEnd) {
  const std::string report =
      "s.csv: 2 of 3 states are beyond the limits of a joint. The first is state 1, line 3: \"slide\" is at 5 m, its "
      "limits are -1 and 2 m.\n";
  for (const std::string arguments : {"", "--trajectory"}) {
    const CommandResult result = run("slide\n0\n5\n-3\n", arguments);
    EXPECT_EQ(result.exit_code, 0) << "nobody is kept from asking";
    EXPECT_TRUE(says(result.errors, report)) << result.errors;
    EXPECT_FALSE(says(run("slide\n0\n2\n-1\n", arguments).errors, "limits"));
  }
}

TEST_F(Clearance, TakesJointInequalities) {
  const std::string option =
      "--joint-inequalities " + files_.write("cables.yaml", "- slide + follow <= 1.5\n");  // 3 slide
  const CommandResult given = run("slide\n0.5\n1\n", option);
  EXPECT_EQ(given.exit_code, 0);
  EXPECT_EQ(rowsOf(given.output).size(), 3U);
  EXPECT_TRUE(says(given.errors,
                   "s.csv: 1 of 2 states break a joint inequality. The first is state 1, line 3: "
                   "'slide + follow <= 1.5' is broken by 1.5.\n"))
      << given.errors;

  const CommandResult spline = run("time,slide,slide.velocity\n0,0.25,1.5\n1,0.25,-1.5\n",
                                   option + " --trajectory --interpolation cubic");  // 0.25 + 1.5 (t - t^2)
  EXPECT_TRUE(says(spline.errors,
                   "s.csv: the motion breaks a joint inequality in 1 segment. That is segment 0, at 0.5 "
                   "s: 'slide + follow <= 1.5' is broken by 0.375.\n"))
      << spline.errors;

  const CommandResult sampled = runCommandApart(CLEARANCE " " + urdf_ + " --sample 200 --summary /dev/null " + option);
  EXPECT_EQ(sampled.exit_code, 0);
  EXPECT_FALSE(says(sampled.errors, "break"));

  const CommandResult unknown =
      run("slide\n0\n", "--joint-inequalities " + files_.write("bad.yaml", "- slide <= 1\n- slyde <= 1\n"));
  EXPECT_EQ(unknown.exit_code, 1);
  EXPECT_TRUE(says(unknown.errors,
                   "bad.yaml, line 2: [1]: 'slyde <= 1': there is no joint \"slyde\" (did you mean "
                   "\"slide\"?)\n"))
      << unknown.errors;
}

TEST_F(Clearance, RefusesALineThatIsTooLong) {
  const CommandResult result =
      runCommandApart("{ echo slide; echo 0; head -c 20000000 /dev/zero | tr '\\0' 1; } | " CLEARANCE " " + urdf_);
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_EQ(rowsOf(result.output).size(), 2U) << "the state before it is answered";
  EXPECT_TRUE(says(result.errors, "clearance: standard input, line 3: longer than 8388608 characters"))
      << result.errors;
}

TEST_F(Clearance, EndsWithAMessageWhereTheSystemGivesNoMoreThreads) {
#ifdef PROXIMITY_SANITIZED
  GTEST_SKIP() << "a sanitizer reserves more memory than the limit of this test";
#endif
  std::string states = "slide\n";
  for (int i = 0; i < 400000; ++i) states += "0\n";
  files_.write("s.csv", states);
  // The stacks of three threads are too much, long before there is no memory for anything else.
  const CommandResult result =
      runCommandApart("ulimit -v 1000000; ulimit -s 400000; MALLOC_ARENA_MAX=1 " CLEARANCE " " + urdf_ +
                      " --no-filter --threads 1024 --states " + files_.path("s.csv"));
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_TRUE(says(result.errors, " of 1024 threads could be started (")) << result.errors;
}

}  // namespace proximity_server::tools::clearance_input_test
