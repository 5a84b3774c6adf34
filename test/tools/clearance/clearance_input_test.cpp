// What the executable says of its input and its options, and how it ends.
#include <algorithm>

#include "sanitized.h"
#include "tools/command_line/clearance_command.h"
#include "tools/command_line/crossing_sliders.h"

namespace proximity_server::tools {

using namespace scene;
namespace {

TEST_F(Clearance, NamesWhatIsWrongWithTheInput) {
  const auto expect = [&](const CommandResult& result, const std::string& part) {
    EXPECT_EQ(result.exit_code, 1) << result.errors;
    EXPECT_EQ(result.output, "");
    EXPECT_TRUE(says(result.errors, "clearance: ")) << result.errors;
    EXPECT_TRUE(says(result.errors, part)) << result.errors;
  };
  expect(run("", ""), "empty");
  expect(run("elbow\n1\n", ""), "no such joint");
  expect(runCommandApart(CLEARANCE " /nowhere.urdf < /dev/null"), "/nowhere.urdf: cannot be read");
  expect(run("slide\n0\n", "--srdf /nowhere.srdf"), "/nowhere.srdf: cannot be read");
  expect(run("slide\n0\n", "--out /nowhere/out.csv"), "/nowhere/out.csv: cannot be opened");
  expect(run("slide\n0\n", "--srdf " + urdf_), urdf_ + ": SRDF, line 2: this is a URDF");
  expect(runCommandApart(CLEARANCE " " + urdf_ + " --states /tmp"), "reading failed");
}

TEST_F(Clearance, NamesWhatIsWrongWithAnOption) {
  const auto expect = [&](const std::string& arguments, const std::string& message) {
    const CommandResult result = run("slide\n0\n", arguments);
    EXPECT_EQ(result.exit_code, 1) << arguments;
    EXPECT_TRUE(says(result.errors, "clearance: " + message)) << result.errors;
  };
  expect("--pairs below:x", "--pairs: below:x: no number behind below:");
  expect("--pairs k:0", "--pairs: k:0: at least one pair");
  expect("--pairs below:nan", "--pairs: below:nan: not a number");
  expect("--format xml", "--format: 'xml' is neither csv nor json\n");
  expect("--mesh-tolerance -1", "--mesh-tolerance: '-1' is not a finite length of at least 0 m\n");
  expect("--mesh-tolerance nan", "--mesh-tolerance: 'nan' is not a finite length of at least 0 m\n");
  expect("--mesh-tolerance inf", "--mesh-tolerance: 'inf' is not a finite length of at least 0 m\n");
  expect("--assert-above -0.01", "--assert-above: '-0.01' is not a finite length of at least 0 m\n");
  expect("--threads 0", "--threads: '0' is not a whole number from 1 to 1024\n");
  expect("--threads 1.5", "--threads: '1.5' is not a whole number from 1 to 1024\n");
  expect("--fast", "The following argument was not expected: --fast\n");
}

TEST_F(Clearance, HelpIsTextAndTellsTheExitCodes) {
  const CommandResult result = runCommandApart(CLEARANCE " --help");
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_TRUE(std::all_of(result.output.begin(), result.output.end(),
                          [](char letter) { return letter == '\n' || (letter >= ' ' && letter <= '~'); }));
  EXPECT_TRUE(says(result.output, "Exit codes: 0: ")) << result.output;
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
  const CommandResult result = runCommandApart("ulimit -v 1000000; " CLEARANCE " " + urdf_ +
                                               " --no-filter --threads 1024 --states " + files_.path("s.csv"));
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_TRUE(says(result.errors, " of 1024 threads could be started (")) << result.errors;
}

}  // namespace
}  // namespace proximity_server::tools
