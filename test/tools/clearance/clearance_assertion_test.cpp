// --assert-above of the executable, on robots whose distances are worked out on paper.
#include "tools/program/clearance_command.h"

namespace proximity_server::tools::clearance_assertion_test {

/// With --no-filter the closest pair of the two sliders is base - sled, 1 + slide apart.
class ClearanceAssertion : public Clearance {
 protected:
  /// Expects that the rows are those that come without it.
  CommandResult assertAbove(const std::string& distance, const std::string& states,
                            const std::string& arguments = "--no-filter") {
    const CommandResult result = run(states, arguments + " --assert-above " + distance);
    EXPECT_EQ(result.output, run(states, arguments).output);
    return result;
  }
};

TEST_F(ClearanceAssertion, SaysWhatIsProven) {
  const CommandResult result = assertAbove("0.4", "slide\n0\n-0.5\n0.25\n");
  EXPECT_EQ(result.exit_code, 0) << result.errors;
  EXPECT_TRUE(says(result.errors,
                   "clearance: proven: in 3 states all 5 pairs are above 0.4 m; the closest is state 1: "
                   "base - sled, left at 0.5 m, bounds "))
      << result.errors;
}

TEST_F(ClearanceAssertion, NamesTheFirstAndTheWorstState) {
  const CommandResult result = assertAbove("0.4", "slide\n0\n-0.625\n-0.875\n-0.75\n");
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_TRUE(says(result.errors,
                   "clearance: not proven to be above 0.4 m: 3 of 4 states (3 at that distance or below)"
                   "\n  first: state 1: base - sled, left at 0.375 m, bounds "))
      << result.errors;
  EXPECT_TRUE(says(result.errors, "\n  worst: state 2: base - sled, left at 0.125 m, bounds ")) << result.errors;
  EXPECT_TRUE(says(result.errors, "with slide=-0.875\n")) << result.errors;
}

TEST_F(ClearanceAssertion, IsAboutTheMinimumWhicheverPairsAreChosen) {
  for (const std::string pairs : {"all", "minimum", "k:1", "k:3", "below:0.1", "below:2"}) {
    const std::string arguments = "--no-filter --pairs " + pairs;
    EXPECT_EQ(assertAbove("0.25", "slide\n0\n-0.5\n", arguments).exit_code, 0) << pairs;
    EXPECT_EQ(assertAbove("0.25", "slide\n0\n-0.875\n", arguments).exit_code, 2) << pairs;
  }
}

TEST_F(ClearanceAssertion, TheDistanceItselfIsNotAboveIt) {
  EXPECT_EQ(assertAbove("0.5", "slide\n-0.5\n").exit_code, 2);
  EXPECT_EQ(assertAbove("0", "slide\n-1\n").exit_code, 2);
}

TEST_F(ClearanceAssertion, NothingIsProvenOfWhatIsNotKnown) {
  // The ball, at twice the position, is nowhere; base - sled are known to be far apart.
  for (const std::string arguments : {"--no-filter", "--no-filter --pairs all", "--no-filter --trajectory"}) {
    const CommandResult result = assertAbove("0.1", "slide\n1e308\n1e308\n", arguments);
    EXPECT_EQ(result.exit_code, 2);
    EXPECT_TRUE(says(result.errors, "with pairs of which nothing is known)")) << result.errors;
  }
}

TEST_F(ClearanceAssertion, NothingIsProvenOfAMotionThatOverflows) {
  const CommandResult result = assertAbove("0.1", "slide\n-1e31\n1e31\n", "--no-filter --trajectory");
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_TRUE(says(result.errors, "the motion is too large to compute with")) << result.errors;
}

TEST_F(ClearanceAssertion, NoStatesAreNoProof) {
  const CommandResult result = assertAbove("0.1", "slide\n");
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_TRUE(says(result.errors, "s.csv: no state, so --assert-above proves nothing")) << result.errors;
}

TEST_F(ClearanceAssertion, BadInputIsNoFailedAssertion) {
  EXPECT_EQ(assertAbove("0.4", "slide\n-0.75\nnan\n").exit_code, 1);
}

// The pair is 0.65 m apart at both way points, and 0.75 - sqrt(0.02) = 0.609 in the middle.
TEST_F(ClearanceAssertion, ATrajectoryIsProvenBetweenItsWayPoints) {
  const std::string states = "time,spin,approach\n10,0,2\n14,1.5707963267948966,2\n", srdf = crossingSliders();
  EXPECT_EQ(assertAbove("0.63", states, srdf).exit_code, 0);
  const CommandResult close = assertAbove("0.63", states, srdf + " --trajectory");
  EXPECT_EQ(close.exit_code, 2);
  EXPECT_TRUE(says(close.errors,
                   "clearance: not proven to be above 0.63 m: 1 of 1 segment (1 at that distance or below)"
                   "\n  first: segment 0 (10 to 14 s), at "))
      << close.errors;
  EXPECT_TRUE(says(close.errors, " s: tip - rod at 0.60")) << close.errors;
  EXPECT_TRUE(says(close.errors, "\n  worst: the same\n")) << close.errors;
  const CommandResult far = assertAbove("0.6", states, srdf + " --trajectory");
  EXPECT_EQ(far.exit_code, 0) << far.errors;
  EXPECT_TRUE(says(far.errors, "clearance: proven: in 1 segment all ")) << far.errors;
}

// After 16,000 turns the search gives up; the smallest distance is 0.609 m.
TEST_F(ClearanceAssertion, WhatCouldNotBeDecidedIsNotProven) {
  const CommandResult result = assertAbove("0.6", "spin,approach\n0,1.9\n1e5,2\n", crossingSliders() + " --trajectory");
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_TRUE(says(result.errors, "1 of 1 segment (1 not decided within the budget of the search)")) << result.errors;
}

}  // namespace proximity_server::tools::clearance_assertion_test
