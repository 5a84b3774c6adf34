// The executable from end to end: each finding on a robot that shows it, and none on the same robot without the fault.
#include "sanitized.h"
#include "tools/program/run_command.h"

#include <gtest/gtest.h>
#include <tinyxml2.h>
#include <nlohmann/json.hpp>

#include <string>

namespace proximity_server::tools::model_check_test {

using Json = nlohmann::json;

bool says(const std::string& text, const std::string& what) { return text.find(what) != std::string::npos; }

const std::string kBox = "<geometry><box size=\"0.2 0.2 0.2\"/></geometry>";

std::string box(const std::string& kind, const std::string& x = "0") {
  return "<" + kind + "><origin xyz=\"" + x + " 0 0\"/>" + kBox + "</" + kind + ">";
}
std::string link(const std::string& name, const std::string& content) {
  return "<link name=\"" + name + "\">" + content + "</link>\n";
}
std::string joint(const std::string& name, const std::string& type, const std::string& parent, const std::string& child,
                  const std::string& x, const std::string& rest) {
  return "<joint name=\"" + name + "\" type=\"" + type + "\"><parent link=\"" + parent + "\"/><child link=\"" + child +
         "\"/><origin xyz=\"" + x + " 0 0\"/><axis xyz=\"1 0 0\"/>" + rest + "</joint>\n";
}
const std::string kLimit = "<limit lower=\"0\" upper=\"0.3\" effort=\"1\" velocity=\"1\"/>";

/// Three cubes of edge 0.2 that slide along x: "a" at 0, "b" from 0.5 to 0.8, "c" 0.5 to 0.8 behind "b".
struct Parts {
  std::string a = box("collision"), b = box("collision"), c = box("collision");
  std::string first = joint("first", "prismatic", "a", "b", "0.5", kLimit);
  std::string second = joint("second", "prismatic", "b", "c", "0.5", kLimit);
  std::string more;

  std::string urdf() const {
    return "<robot name=\"cubes\">\n" + link("a", a) + link("b", b) + link("c", c) + first + second + more +
           "</robot>\n";
  }
};

class ModelCheck : public ::testing::Test {
 protected:
  CommandResult run(const std::string& urdf, const std::string& arguments, const std::string& entries = "") const {
    const std::string srdf = files_.write("robot.srdf", "<robot name=\"cubes\">" + entries + "</robot>");
    return runCommandApart(MODEL_CHECK " " + files_.write("robot.urdf", urdf) + " --srdf " + srdf +
                           " --quiet --samples 2000 " + arguments);
  }
  /// The SRDF names the neighbours, and has these entries besides.
  CommandResult run(const Parts& parts, const std::string& arguments, const std::string& entries = "") const {
    return run(parts.urdf(), arguments, disabled("a", "b", "Adjacent") + disabled("b", "c", "Adjacent") + entries);
  }
  static std::string disabled(const std::string& a, const std::string& b, const std::string& reason) {
    return "<disable_collisions link1=\"" + a + "\" link2=\"" + b + "\" reason=\"" + reason + "\"/>";
  }

  /// The robot has this finding; all of it ends with 2 where that is what was asked for.
  void expectFinding(const Parts& parts, const std::string& finding, const std::string& entries = "") const {
    const CommandResult result = run(parts, "--fail-on note", entries);
    EXPECT_EQ(result.exit_code, 2) << result.errors;
    EXPECT_TRUE(says(result.output, finding)) << result.output;
  }

  TemporaryFiles files_;
};

TEST_F(ModelCheck, ASoundRobotHasNoFinding) {
  const CommandResult result = run(Parts(), "--fail-on note");
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_EQ(result.errors, "");
  EXPECT_EQ(result.output, "robot \"cubes\": 3 links, 2 joints, 1 checked pairs\nerrors: 0, warnings: 0, notes: 0\n");
}

TEST_F(ModelCheck, NamesWhatXacroLeft) {
  Parts parts;
  parts.more = "<gazebo reference=\"a\"><mu1>${friction}</mu1></gazebo>\n";
  expectFinding(parts, "error: xacro: ");
  expectFinding(parts, "line 7: \"${friction}\" was not expanded. Run xacro on the file first.");
  parts.first = joint("first", "prismatic", "a", "b", "${length}", kLimit);
  const CommandResult result = run(parts, "");
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_TRUE(says(result.errors, "\"${length} 0 0\" was not expanded")) << result.errors;
}

TEST_F(ModelCheck, NamesJointsWithoutLimitsRangeOrVelocity) {
  Parts parts;
  parts.first =
      joint("first", "prismatic", "a", "b", "0.5", "<limit lower=\"0.1\" upper=\"0.1\" effort=\"1\" velocity=\"0\"/>");
  expectFinding(parts, "warning: limits: first: its limits are the same number: it cannot move.");
  expectFinding(parts, "note: limits: first: it has no largest velocity.");
  parts.first =
      joint("first", "prismatic", "a", "b", "0.5", "<limit lower=\"1\" upper=\"-1\" effort=\"1\" velocity=\"1\"/>");
  expectFinding(parts, "warning: limits: first: it has no limits.");
  expectFinding(parts, "warning: loading: URDF: joint \"first\": its lower limit is above the upper one");
}

TEST_F(ModelCheck, NamesMimicsThatLeaveTheirLimits) {
  Parts parts;
  parts.second = joint("second", "prismatic", "b", "c", "0.5",
                       kLimit + "<mimic joint=\"first\" multiplier=\"-2\" offset=\"0.1\"/>");
  expectFinding(parts,
                "warning: mimic: second: it follows joint \"first\" from -0.5 to 0.1, beyond its limits 0 to 0.3.");
  parts.second = joint("second", "prismatic", "b", "c", "0.5", kLimit + "<mimic joint=\"first\"/>");
  EXPECT_EQ(run(parts, "--fail-on note").exit_code, 0);
}

TEST_F(ModelCheck, NamesLinksThatAreSeenAndNotChecked) {
  Parts parts;
  parts.more = link("lamp", box("visual")) +
               "<joint name=\"weld\" type=\"fixed\"><parent link=\"a\"/><child link=\"lamp\"/></joint>";
  expectFinding(parts, "warning: geometry: lamp: it has visual, but no collision geometry.");
  const std::string small = "<visual><geometry><box size=\"0.01 0.01 0.01\"/></geometry></visual>";
  parts.more =
      link("lamp", small) + "<joint name=\"weld\" type=\"fixed\"><parent link=\"a\"/><child link=\"lamp\"/></joint>";
  expectFinding(parts, "note: geometry: lamp: ");
}

TEST_F(ModelCheck, NamesLinksOfWhichTheVisualCounts) {
  Parts parts;
  parts.c = box("visual");
  const std::string moved = "<group name=\"last\"><link name=\"c\"/></group>";
  for (const char* named : {"all", "[c]", "[last]"}) {
    const std::string config = files_.write("cell.yaml", std::string("collision_from_visual: ") + named);
    const CommandResult result = run(parts, "--config " + config, moved);
    EXPECT_EQ(result.output,
              "robot \"cubes\": 3 links, 2 joints, 1 checked pairs\n"
              "note: geometry: c: it has no collision geometry: its visual geometry counts. The parameter "
              "collision_from_visual names it.\nerrors: 0, warnings: 0, notes: 1\n")
        << result.errors;
  }
}

TEST_F(ModelCheck, MeasuresHowFarTheVisualReachesOutOfTheCollisionGeometry) {
  Parts parts;
  parts.b += box("visual", "0.05");
  expectFinding(parts,
                "warning: visual: b: its visual geometry reaches 50 mm out of its collision geometry, at (0.15, ");
  EXPECT_EQ(run(parts, "--fail-on note --visual-tolerance 0.051").exit_code, 0);
  // Inside of the cube nothing reaches out of it, nor where a second cube stands.
  parts.b += box("collision", "0.1");
  EXPECT_EQ(run(parts, "--fail-on note").exit_code, 0);
  parts.b = box("collision") + "<visual><geometry><sphere radius=\"0.13\"/></geometry></visual>";
  expectFinding(parts, "warning: visual: b: its visual geometry reaches 30 mm out of its collision geometry");
}

TEST_F(ModelCheck, MeasuresHowFarPiecesReachOutOfTheirMesh) {
  std::string l_shape;  // six corners below and above; each face is a fan about the first corner, which sees all others
  for (const char* z : {" 0", " 0.1"})
    for (const char* corner : {"0 0", "0.2 0", "0.2 0.1", "0.1 0.1", "0.1 0.2", "0 0.2"})
      l_shape += "v " + std::string(corner) + z + "\n";
  const auto face = [&](int a, int b, int c) {
    l_shape += "f " + std::to_string(a) + " " + std::to_string(b) + " " + std::to_string(c) + "\n";
  };
  for (int i = 2; i < 6; ++i) {
    face(1, i + 1, i);
    face(7, i + 6, i + 7);
  }
  for (int i = 1; i <= 6; ++i) {
    const int next = i % 6 + 1;
    face(i, next, next + 6);
    face(i, next + 6, i + 6);
  }
  Parts parts;
  parts.c =
      "<collision><geometry><mesh filename=\"file://" + files_.write("l.obj", l_shape) + "\"/></geometry></collision>";
  const CommandResult coarse = run(parts, "--mesh-tolerance 0.2 --fail-on note");
  EXPECT_EQ(coarse.exit_code, 2) << coarse.errors;
  EXPECT_TRUE(says(coarse.output, "warning: pieces: c: ")) << coarse.output;
  EXPECT_TRUE(says(coarse.output, "its convex pieces reach 50 mm out of it.")) << coarse.output;
  const CommandResult fine = run(parts, "--mesh-tolerance 0.001 --fail-on note");
  EXPECT_EQ(fine.exit_code, 0) << fine.output;
}

TEST_F(ModelCheck, NamesNeighboursThatMeet) {
  Parts parts;
  parts.first = joint("first", "prismatic", "a", "b", "0.1", kLimit);  // from 0.1 to 0.4
  expectFinding(parts,
                "warning: neighbour: a - b: neighbours are not checked, but are apart in some states, and in others "
                "they overlap by ");
  parts.first = joint("first", "prismatic", "a", "b", "-0.15", kLimit);  // from -0.15 to 0.15
  expectFinding(parts, "note: neighbour: a - b: neighbours that are in contact in every state");
}

TEST_F(ModelCheck, NamesEntriesThatHideACollision) {
  Parts parts;
  parts.second = joint("second", "prismatic", "b", "c", "-0.6", kLimit);  // "c" from -0.1 to 0.5 seen from "a"
  const std::string never = disabled("a", "c", "Never");
  expectFinding(parts, "error: srdf: a - c: disabled as \"Never\", but they overlap by ", never);
  EXPECT_EQ(run(parts, "", never).exit_code, 2) << "an error fails by default";
  EXPECT_EQ(run(Parts(), "--fail-on error", never).exit_code, 0);
}

TEST_F(ModelCheck, AnEntryThatSaysWhyIsANote) {
  Parts parts;
  parts.second = joint("second", "prismatic", "b", "c", "-0.6", kLimit);
  const std::string decided = disabled("a", "c", "User: c hangs in a pocket of a");
  expectFinding(parts,
                "note: srdf: a - c: disabled by decision, as \"User: c hangs in a pocket of a\", although they overlap "
                "by ",
                decided);
  EXPECT_EQ(run(parts, "", decided).exit_code, 0);
  EXPECT_EQ(run(parts, "", disabled("a", "c", "User")).exit_code, 2);
}

// What a newcomer tries first.
TEST_F(ModelCheck, TheRobotOfTheDemoHasNoErrorAndNoWarning) {
  if (kIsSanitized) GTEST_SKIP() << "its states take ten minutes there";
  const std::string demo = PROXIMITY_SOURCE_DIR "/config/demo/robot";
  const CommandResult result = runCommandApart("ROS_PACKAGE_PATH=" PROXIMITY_SOURCE_DIR " " MODEL_CHECK " " + demo +
                                               ".urdf --srdf " + demo + ".srdf --fail-on warning --quiet");
  EXPECT_EQ(result.exit_code, 0) << result.errors;
  EXPECT_TRUE(says(result.output, "errors: 0, warnings: 0, notes: 20\n")) << result.output;
}

TEST_F(ModelCheck, ReadsADeclarationBehindAComment) {
  const CommandResult result = run("<!-- licence -->\n<?xml version=\"1.0\"?>\n" + Parts().urdf(), "");
  EXPECT_EQ(result.exit_code, 0) << result.errors;
}

TEST_F(ModelCheck, NamesPairsThatAlwaysAlarm) {
  Parts parts;
  parts.c = "<collision><geometry><box size=\"4 0.1 0.1\"/></geometry></collision>";
  expectFinding(parts, "error: srdf: a - c: checked, but in contact in every state that was tried");
}

TEST_F(ModelCheck, NamesPairsInContactAtRestOrInMostStates) {
  Parts parts;
  parts.second = joint("second", "prismatic", "b", "c", "-0.6", kLimit);  // "c" from -0.1 to 0.5 seen from "a"
  expectFinding(parts, "warning: srdf: a - c: checked, but in contact at rest and in ");
  expectFinding(parts,
                "Is it an overlap of the model, or the robot never rests so? Disabling it costs: nobody reports");
  expectFinding(parts, R"(<disable_collisions link1="a" link2="c" reason="User: in contact at rest and in )");
}

// "c" is 0.8 to 1.4 m from "a".
TEST_F(ModelCheck, NamesPinchPoints) {
  EXPECT_EQ(run(Parts(), "--fail-on note --pinch 0.1").exit_code, 0);
  const CommandResult closes = run(Parts(), "--fail-on note --pinch 0.9");
  EXPECT_EQ(closes.exit_code, 2);
  EXPECT_TRUE(says(closes.output,
                   "note: pinch: a - c: their gap closes from more than 900 mm until 800 mm, at first=0 second=0. A "
                   "pair_stop_distance stops before; `pair_audit --safe-distance 0.9` looks for limits."))
      << closes.output;
  EXPECT_EQ(run(Parts(), "--fail-on note --pinch 1.5").exit_code, 0) << "never that far apart";
}

TEST_F(ModelCheck, NamesWhatTheNodeWarnsOf) {
  expectFinding(Parts(), "warning: srdf: SRDF: ", disabled("a", "d", "Never"));
}

TEST_F(ModelCheck, AcceptsFindingsByCheckAndPlace) {
  Parts parts;
  parts.b += box("visual", "0.05");
  EXPECT_EQ(run(parts, "--fail-on warning").exit_code, 2);
  for (const char* accepted : {"visual", "visual:b"}) {
    const CommandResult result = run(parts, std::string("--fail-on note --accept ") + accepted);
    EXPECT_EQ(result.exit_code, 0) << result.output;
    EXPECT_FALSE(says(result.output, "visual geometry")) << result.output;
  }
  EXPECT_EQ(run(parts, "--fail-on warning --accept visual:a").exit_code, 2);
  const CommandResult loud =
      runCommandApart(MODEL_CHECK " " + files_.path("robot.urdf") + " --samples 2000 --accept visual:a");
  EXPECT_TRUE(says(loud.errors, "warning: --accept visual:a: there is no such finding\n")) << loud.errors;
}

TEST_F(ModelCheck, JsonAndJUnitHaveTheSameFindings) {
  Parts parts;
  parts.b += box("visual", "0.05");
  const std::string junit = files_.path("junit.xml");
  const Json json = Json::parse(run(parts, "--format json --fail-on warning --junit " + junit).output);
  ASSERT_EQ(json.at("findings").size(), 1U);
  const Json& finding = json.at("findings").at(0);
  EXPECT_EQ(finding.at("severity"), "warning");
  EXPECT_EQ(finding.at("check"), "visual");
  EXPECT_EQ(finding.at("where"), "b");
  tinyxml2::XMLDocument document;
  ASSERT_EQ(document.LoadFile(junit.c_str()), tinyxml2::XML_SUCCESS);
  int tests = 0, failures = 0;
  for (auto* test = document.RootElement()->FirstChildElement("testcase"); test; test = test->NextSiblingElement()) {
    ++tests;
    if (!test->FirstChildElement("failure")) continue;
    ++failures;
    EXPECT_EQ(std::string(test->Attribute("name")), "visual");
    EXPECT_TRUE(says(test->FirstChildElement("failure")->GetText(), finding.at("what").get<std::string>()));
  }
  EXPECT_EQ(tests, document.RootElement()->IntAttribute("tests"));
  EXPECT_EQ(failures, 1);
  EXPECT_EQ(run(parts, "--junit " + junit).exit_code, 0);
  document.LoadFile(junit.c_str());
  EXPECT_FALSE(says(readFile(junit), "<failure")) << "a warning does not fail by default";
}

}  // namespace proximity_server::tools::model_check_test
