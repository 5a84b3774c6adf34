// The executable with --objects from end to end, on the two sliders: the sled reaches from 1.5 + slide to 2.5 + slide,
// the ball is a sphere of radius 0.25 about 5 + 2 slide.
#include "tools/program/clearance_command.h"

#include <cmath>
#include <map>
#include <string>

namespace proximity_server::tools::clearance_objects_test {

using Row = std::map<std::string, std::string>;

class ClearanceObjects : public Clearance {
 protected:
  CommandResult runWith(const std::string& objects, const std::string& states, const std::string& arguments = "") {
    return run(states, "--objects " + files_.write(name_, objects) + " " + arguments);
  }

  std::vector<Row> rows(const std::string& objects, const std::string& states, const std::string& arguments = "") {
    const CommandResult result = runWith(objects, states, arguments);
    EXPECT_EQ(result.exit_code, 0) << result.errors;
    errors_ = result.errors;
    const auto lines = rowsOf(result.output);
    std::vector<Row> named;
    for (std::size_t i = 1; i < lines.size(); ++i) {
      named.emplace_back();
      for (std::size_t k = 0; k < lines[i].size(); ++k) named.back()[lines[0].at(k)] = lines[i][k];
    }
    return named;
  }

  std::string refusal(const std::string& objects, const std::string& states = "slide\n0\n") {
    const CommandResult result = runWith(objects, states);
    EXPECT_EQ(result.exit_code, 1) << result.output;
    return result.errors;
  }

  std::string name_ = "objects.yaml", errors_;
};

std::string pairOf(const Row& row) { return row.at("link_a") + "|" + row.at("link_b"); }
double number(const Row& row, const std::string& column) { return std::stod(row.at(column)); }

const std::string kSphere = "primitives: [{type: SPHERE, dimensions: [0.1]}]";

TEST_F(ClearanceObjects, TheClosestPairMayBeThatOfALinkAndAnObject) {
  // The part reaches down to z = 0.9, the sled up to 0.5.
  const auto answers = rows("- {id: part, pose: {position: [2, 0, 1]}, " + kSphere + "}", "slide\n0\n0.5\n");
  ASSERT_EQ(answers.size(), 2U);
  EXPECT_EQ(pairOf(answers[0]), "sled, left|part");
  EXPECT_NEAR(number(answers[0], "distance"), 0.4, 1e-9);
  EXPECT_NEAR(number(answers[0], "point_b_z"), 0.9, 1e-9);
  EXPECT_NEAR(number(answers[1], "distance"), 0.4, 1e-9) << "the sled reaches from 2 to 3 then";
}

TEST_F(ClearanceObjects, WithoutObjectsNothingChanges) {
  EXPECT_EQ(runWith("objects: []", "slide\n0\n1\n").output, run("slide\n0\n1\n", "").output);
}

TEST_F(ClearanceObjects, AnRpyThatLooksLikeDegreesIsAWarning) {
  const std::string turned = "[{id: part, pose: {position: [2, 0, 1], rpy: [90, 0, 0]}, " + kSphere + "}]";
  const std::string warning = "/pose/rpy[0]: 90 rad is more than a turn; degrees are written 90deg";
  EXPECT_NE(runWith(turned, "slide\n0\n").errors.find(warning), std::string::npos);
  const std::string config = files_.write("cell.yaml", "objects: " + turned);
  EXPECT_NE(run("slide\n0\n", "--config " + config).errors.find(warning), std::string::npos);
}

TEST_F(ClearanceObjects, PaddingAndRulesCount) {
  const std::string part = "objects: [{id: part, pose: {position: [2, 0, 1]}, padding: 0.1, " + kSphere + "}]\n";
  EXPECT_NEAR(number(rows(part, "slide\n0\n").at(0), "distance"), 0.3, 1e-9);
  const auto allowed = rows(part + "rules: [{a: part, b: '*', allowed: true}]", "slide\n0\n");
  EXPECT_EQ(pairOf(allowed.at(0)), "ball|sled, left");
}

TEST_F(ClearanceObjects, WhatALinkHoldsMovesWithItAndIsCheckedAgainstTheBase) {
  // The frame of the sled is at 2 + slide; the held sphere touches its sled, and reaches back to 0.9 + slide.
  const auto answers =
      rows("- {id: bar, link: \"sled, left\", pose: {position: [-1, 0, 0]}, " + kSphere + "}", "slide\n0\n-0.2\n");
  EXPECT_EQ(pairOf(answers.at(0)), "base|bar");
  EXPECT_NEAR(number(answers.at(0), "distance"), 0.4, 1e-9);
  EXPECT_NEAR(number(answers.at(1), "distance"), 0.2, 1e-9);
}

TEST_F(ClearanceObjects, WhatMovesWithTheFrameOfALinkMayCollideWithIt) {
  const auto answers =
      rows("- {id: bar, frame: \"sled, left\", pose: {position: [0, 0, 1]}, " + kSphere + "}", "slide\n0\n1\n");
  for (const Row& answer : answers) {
    EXPECT_EQ(pairOf(answer), "sled, left|bar");
    EXPECT_NEAR(number(answer, "distance"), 0.4, 1e-9);
  }
}

TEST_F(ClearanceObjects, TheBaseIsNotCheckedAgainstWhatStandsStill) {
  const std::string floor = "- {id: floor, planes: [{coef: [0, 0, 1, 0.5]}]}";  // the base stands on it
  const auto answers = rows(floor, "slide\n0\n", "--pairs all");
  for (const Row& answer : answers) EXPECT_NE(pairOf(answer), "base|floor");
  const auto unfiltered = rows(floor, "slide\n0\n", "--pairs all --no-filter");
  EXPECT_EQ(unfiltered.size(), 5U + 4U) << "5 pairs of links, and all links with the floor";
}

TEST_F(ClearanceObjects, ObjectsAreAttachedAndDetachedAtRows) {
  // The part stands at x = 4 until row 1. The sled takes it along from 2.5 to 3.5, and leaves it at x = 5.
  const std::string objects = R"(
objects: [{id: part, pose: {position: [4, 0, 3]}, primitives: [{type: SPHERE, dimensions: [0.1]}]}]
changes:
- {at: {row: 1}, operation: ATTACH, id: part, link: "sled, left", keep_pose: true}
- {at: {row: 3}, operation: DETACH, id: part}
- {at: {row: 5}, operation: REMOVE, id: part}
)";
  const auto answers = rows(objects, "slide\n0\n0.5\n1\n1.5\n0\n0\n", "--pairs all");
  std::map<std::string, double> x;
  for (const Row& answer : answers)
    if (answer.at("link_b") == "part") x[answer.at("state") + " " + answer.at("link_a")] = number(answer, "point_b_x");
  // The point of the part that is closest to the mast tells where the part is: the mast is at (0, 4, 0).
  const auto placeFrom = [&](const std::string& state) {
    double found = std::nan("");
    for (const Row& answer : answers) {
      if (answer.at("state") != state || answer.at("link_b") != "part" || answer.at("link_a") != "mast") continue;
      found = number(answer, "point_b_x") + 0.1 * number(answer, "normal_x");
    }
    return found;
  };
  EXPECT_TRUE(std::isnan(placeFrom("0"))) << "both stand still";
  EXPECT_NEAR(placeFrom("1"), 4.0, 1e-9);
  EXPECT_NEAR(placeFrom("2"), 4.5, 1e-9);
  EXPECT_EQ(x.count("1 sled, left"), 0U) << "it is held";
  EXPECT_EQ(x.count("3 sled, left"), 1U) << "it is not held any more";
  EXPECT_EQ(x.count("4 ball"), 1U);
  EXPECT_EQ(x.count("5 ball"), 0U) << "it is gone";
}

TEST_F(ClearanceObjects, WhereAPartWasPutDownItStays) {
  const std::string objects = R"(
objects: [{id: part, link: "sled, left", pose: {position: [1, 0, 0]}, primitives: [{type: SPHERE, dimensions: [0.1]}]}]
changes: [{at: {time: 1.5}, operation: DETACH, id: part}]
)";
  // Held, the part is at 3 + slide; the first row at 1.5 s or later is that at 2 s, where it is put down at 3.5. The
  // ball is at 5 + 2 slide: at -0.5 it is at 4, and 0.15 from the part.
  const auto answers = rows(objects, "time,slide\n1,0\n2,0.5\n3,-0.5\n");
  EXPECT_EQ(pairOf(answers.at(2)), "ball|part");
  EXPECT_NEAR(number(answers.at(2), "distance"), 0.15, 1e-9);
}

TEST_F(ClearanceObjects, ObjectsComeAndAreReplacedAndMovedAtRows) {
  const std::string objects = R"(
changes:
- {at: {row: 1}, operation: ADD, id: part, pose: {position: [2, 0, 1]}, primitives: [{type: SPHERE, dimensions: [0.1]}]}
- {at: {row: 2}, operation: MOVE, id: part, pose: {position: [2, 0, 1.1]}}
- {at: {row: 3}, operation: REPLACE, id: part, pose: {position: [2, 0, 1]}, primitives: [{type: SPHERE, dimensions: [0.2]}]}
- {at: {row: 4}, operation: ATTACH, id: part, link: "sled, left", pose: {position: [-1, 0, 0]}}
)";
  const auto answers = rows(objects, "slide\n0\n0\n0\n0\n0\n");
  ASSERT_EQ(answers.size(), 5U);
  EXPECT_EQ(pairOf(answers[0]), "ball|sled, left");
  EXPECT_NEAR(number(answers[1], "distance"), 0.4, 1e-9);
  EXPECT_NEAR(number(answers[2], "distance"), 0.5, 1e-9);
  EXPECT_NEAR(number(answers[3], "distance"), 0.3, 1e-9);
  EXPECT_EQ(pairOf(answers[4]), "base|part");
  EXPECT_NEAR(number(answers[4], "distance"), 0.3, 1e-9);
}

// The answers about a block of states begin anew, with the objects of that block.
TEST_F(ClearanceObjects, TheAnswersAreTheSameForAnyNumberOfThreads) {
  std::string states = "slide\n";
  for (int i = 0; i < 1000; ++i) states += shortest(std::sin(0.01 * i)) + "\n";
  const std::string objects = R"(
objects: [{id: part, pose: {position: [3, 0, 1]}, primitives: [{type: BOX, dimensions: [0.1, 0.2, 0.3]}]}]
changes:
- {at: {row: 300}, operation: ATTACH, id: part, link: "sled, left", keep_pose: true}
- {at: {row: 700}, operation: DETACH, id: part}
)";
  const CommandResult one = runWith(objects, states, "--threads 1"), four = runWith(objects, states, "--threads 4");
  EXPECT_EQ(one.exit_code, 0) << one.errors;
  EXPECT_EQ(one.output, four.output);
  EXPECT_TRUE(says(one.output, "part"));
}

TEST_F(ClearanceObjects, SkippingChangesNoDistance) {
  std::string states = "slide\n";
  for (int i = 0; i < 600; ++i) states += shortest(std::sin(0.05 * i)) + "\n";
  const std::string objects = R"(
objects: [{id: part, pose: {position: [3, 0, 1]}, primitives: [{type: BOX, dimensions: [0.1, 0.2, 0.3]}]}]
changes:
- {at: {row: 200}, operation: ATTACH, id: part, link: "sled, left", keep_pose: true}
- {at: {row: 400}, operation: DETACH, id: part}
)";
  const auto skipping = rows(objects, states), all = rows(objects, states, "--no-skip");
  ASSERT_EQ(skipping.size(), all.size());
  for (std::size_t i = 0; i < all.size(); ++i)
    ASSERT_NEAR(number(skipping[i], "distance"), number(all[i], "distance"), 2e-9) << i;
}

TEST_F(ClearanceObjects, AssertAboveIsAboutObjectsToo) {
  const std::string part = "- {id: part, pose: {position: [2, 0, 1]}, " + kSphere + "}";
  const CommandResult fails = runWith(part, "slide\n0\n", "--assert-above 0.5");
  EXPECT_EQ(fails.exit_code, 2);
  EXPECT_TRUE(says(fails.errors, "sled, left - part at 0.4")) << fails.errors;
  EXPECT_TRUE(says(fails.errors, "with slide=0")) << fails.errors;
  const CommandResult holds = runWith(part, "slide\n0\n", "--assert-above 0.3");
  EXPECT_EQ(holds.exit_code, 0);
  EXPECT_TRUE(says(holds.errors, "all pairs, of links and with objects, are above 0.3 m")) << holds.errors;
}

// Between the way points the sled passes below the part at 0.4 m; at both it is 0.9 m and more beside it.
TEST_F(ClearanceObjects, AlongATrajectoryObjectsAreSeenBetweenTheWayPoints) {
  const std::string part = "- {id: part, pose: {position: [3, 0, 1]}, " + kSphere + "}";
  const auto segments = rows(part, "slide\n-1\n2\n", "--trajectory --contact-distance 0.5");
  ASSERT_EQ(segments.size(), 1U);
  EXPECT_EQ(pairOf(segments[0]), "sled, left|part");
  EXPECT_NEAR(number(segments[0], "distance"), 0.4, 1e-6);
  EXPECT_EQ(segments[0].at("contact"), "true");
  EXPECT_EQ(segments[0].at("contact_link_b"), "part");
  // The edge of the sled is at 1.5 + 3 t; at a distance of 0.6 from the centre of the part, 0.5 above it, it is
  // sqrt(0.36 - 0.25) before it.
  EXPECT_NEAR(number(segments[0], "t_contact"), (3.0 - std::sqrt(0.11) - 1.5) / 3.0, 1e-5);
}

TEST_F(ClearanceObjects, AChangeAtATimeDividesItsSegment) {
  // The sled takes the part at 0.5 s, where slide is 0.5, and carries it from 2 to 2.5, on to the ball.
  const std::string objects = R"(
objects: [{id: part, pose: {position: [2.5, 0, 3]}, primitives: [{type: SPHERE, dimensions: [0.1]}]}]
changes:
- {at: {time: 0.5}, operation: ATTACH, id: part, link: "sled, left", keep_pose: true}
- {at: {row: 1}, operation: DETACH, id: part}
)";
  const auto segments = rows(objects, "time,slide\n0,0\n1,1\n2,0\n", "--trajectory");
  ASSERT_EQ(segments.size(), 3U);
  EXPECT_EQ(segments[1].at("segment"), "1");
  EXPECT_EQ(number(segments[0], "t_end"), 0.5);
  EXPECT_EQ(number(segments[1], "t_begin"), 0.5);
  EXPECT_EQ(number(segments[1], "t_end"), 1.0);
  EXPECT_EQ(number(segments[2], "t_begin"), 1.0);
  // Of sled and ball: 2.25 + slide, so at the begin of the rising halves and at the end of the falling one.
  EXPECT_NEAR(number(segments[0], "distance"), 2.25, 1e-6);
  EXPECT_NEAR(number(segments[1], "distance"), 2.75, 1e-6);
  EXPECT_NEAR(number(segments[2], "distance"), 2.25, 1e-6);
}

TEST_F(ClearanceObjects, WhatIsCarriedAlongATrajectoryIsCheckedOnItsWay) {
  // The part is held 2 m before the sled: at 4 + slide it comes to the ball at 5 + 2 slide, as near as 0.65 at slide 0.
  const std::string held = "- {id: part, link: \"sled, left\", pose: {position: [2, 0, 0]}, " + kSphere + "}";
  const auto segments = rows(held, "slide\n1\n-0.1\n1\n", "--trajectory");
  ASSERT_EQ(segments.size(), 2U);
  for (const Row& segment : segments) {
    EXPECT_EQ(pairOf(segment), "ball|part");
    EXPECT_NEAR(number(segment, "distance"), 1.0 - 0.1 - 0.35, 1e-6);
  }
}

TEST_F(ClearanceObjects, WhatMovesWithAFrameMovesAlongATrajectory) {
  const std::string moving = "- {id: part, frame: \"sled, left\", pose: {position: [0, 0, 1]}, " + kSphere + "}";
  const auto segments = rows(moving, "slide\n0\n1\n", "--trajectory");
  ASSERT_EQ(segments.size(), 1U);
  EXPECT_EQ(pairOf(segments[0]), "sled, left|part");
  EXPECT_NEAR(number(segments[0], "distance"), 0.4, 1e-6);
}

TEST_F(ClearanceObjects, ATrajectoryWithoutFilterHasAllPairs) {
  const auto segments =
      rows("- {id: part, pose: {position: [0, 0, 0.8]}, " + kSphere + "}", "slide\n0\n1\n", "--trajectory --no-filter");
  EXPECT_EQ(pairOf(segments.at(0)), "base|part");
  EXPECT_NEAR(number(segments.at(0), "distance"), 0.2, 1e-6);
}

TEST_F(ClearanceObjects, ASceneOfMoveitIsRead) {
  name_ = "cell.scene";
  const auto answers =
      rows("(noname)\n* part\n2 0 1\n0 0 0 1\n1\nsphere\n0.1\n0 0 0\n0 0 0 1\n0 0 0 0\n0\n.\n", "slide\n0\n");
  EXPECT_EQ(pairOf(answers.at(0)), "sled, left|part");
  EXPECT_NEAR(number(answers.at(0), "distance"), 0.4, 1e-9);
}

TEST_F(ClearanceObjects, AMeshIsReadFromItsFile) {
  const std::string mesh = files_.write("a.stl",
                                        "solid a\nfacet normal 0 0 0\nouter loop\nvertex 0 0 0\nvertex 1 0 0\n"
                                        "vertex 0 1 0\nendloop\nendfacet\nendsolid a\n");
  for (const std::string& uri : {"file://" + mesh, mesh, std::string("a.stl")}) {  // relative to the file of objects
    const auto answers =
        rows("- {id: plate, pose: {position: [1.9, 0, 0.6]}, mesh_files: [{uri: \"" + uri + "\"}]}", "slide\n0\n");
    EXPECT_EQ(pairOf(answers.at(0)), "sled, left|plate") << uri;
    EXPECT_NEAR(number(answers.at(0), "distance"), 0.1, 1e-9) << uri;
  }
}

TEST_F(ClearanceObjects, SaysWhichChangesWereNeverMade) {
  rows("objects: [{id: a, pose: {position: [9, 9, 9]}, " + kSphere +
           "}]\nchanges: [{at: {row: 5}, operation: REMOVE, id: a}]",
       "slide\n0\n");
  EXPECT_TRUE(says(errors_, "1 change of objects was never made, because the states end before: the first is that of " +
                                files_.path(name_) + ", line 2: changes[0] \"a\""))
      << errors_;
}

TEST_F(ClearanceObjects, AChangeAtATimeNeedsTimes) {
  const std::string text = "objects: [{id: a, " + kSphere + "}]\nchanges: [{at: {time: 5}, operation: REMOVE, id: a}]";
  EXPECT_TRUE(says(refusal(text), "there is no column \"time\", and objects change at a time"));
}

}  // namespace proximity_server::tools::clearance_objects_test
