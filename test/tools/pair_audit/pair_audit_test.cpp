// The executable from end to end, on a robot whose pairs are in the class that paper says, and on the Panda.
#include "proximity_server/scene/proof/prove_apart.h"
#include "robots/urdf.h"
#include "sanitized.h"
#include "scene/example_robots.h"
#include "scene/files.h"
#include "scene/small_robots.h"
#include "tools/program/run_command.h"
#include "tools/robot/crossing_sliders.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace proximity_server::tools::pair_audit_test {

using namespace narrowphase;
using namespace scene;

bool says(const std::string& text, const std::string& what) { return text.find(what) != std::string::npos; }

/// The indented lines under the title that begins with `title`.
std::vector<std::string> linesUnder(const std::string& title, const std::string& report) {
  std::istringstream stream(report);
  std::vector<std::string> lines;
  std::string line;
  while (std::getline(stream, line) && line.compare(0, title.size(), title) != 0) {
  }
  while (std::getline(stream, line) && line.compare(0, 2, "  ") == 0) lines.push_back(line.substr(2));
  return lines;
}

// Options of a study that may be short. A sanitizer finds in the first states what it finds.
const std::string kShort = kIsSanitized ? " --samples 2000" : "";

class PairAudit : public ::testing::Test {
 protected:
  CommandResult run(const std::string& arguments) const {
    return runCommand(PAIR_AUDIT " " + urdf_ + " " + arguments + " 2>&1");
  }

  TemporaryFiles files_;
  std::string urdf_ = files_.write("robot.urdf", kCrossingSliders);
  std::string srdf_ = files_.write("robot.srdf", kFaultySrdf);
};

using Lines = std::vector<std::string>;

TEST_F(PairAudit, ListsEveryPairUnderItsClass) {
  const CommandResult result = run(kShort);
  ASSERT_EQ(result.exit_code, 0) << result.output;
  EXPECT_TRUE(says(result.output, "Robot \"crossing sliders\": 15 pairs of links, ")) << result.output;
  EXPECT_TRUE(says(result.output, "Joint \"drift\" is floating or planar; it stood still.")) << result.output;
  EXPECT_EQ(linesUnder("within 0.02 m in some states (1)", result.output), Lines{"base - tip: down to contact"});
  EXPECT_EQ(linesUnder("adjacent (joined by one joint)", result.output).size(), 5U);
  EXPECT_EQ(linesUnder("not decided (4)", result.output).size(), 4U);
  EXPECT_EQ(linesUnder("never within 0.02 m (4)", result.output).size(), 4U);
  EXPECT_TRUE(
      says(linesUnder("never within 0.02 m", result.output).at(0), "base - far: closest seen 3.25 m; proven: "));
  EXPECT_TRUE(says(linesUnder("always within 0.02 m (1)", result.output).at(0), "base - rod: not seen apart in "));
  EXPECT_FALSE(says(result.output, "SRDF"));
}

TEST_F(PairAudit, ClassesAreThoseOfTheDistance) {
  const std::string in_contact = run("--distance 0").output;
  EXPECT_EQ(linesUnder("in contact in some states (1)", in_contact), Lines{"base - tip"});
  EXPECT_EQ(linesUnder("never in contact (4)", in_contact).size(), 4U);
  EXPECT_EQ(linesUnder("always in contact (1)", in_contact).size(), 1U);
  EXPECT_FALSE(says(in_contact, "within 0.02"));

  const std::string near = run("--distance 3 --samples 2000 --srdf " + srdf_).output;
  const Lines always = linesUnder("always within 3 m (4)", near);
  ASSERT_EQ(always.size(), 4U) << near;
  EXPECT_TRUE(says(always[0], "base - tip: from contact to 2.67 m in ")) << always[0];
  EXPECT_TRUE(says(always[1], "base - rod: not seen apart in ")) << always[1];
  EXPECT_TRUE(says(always[3], "far - rod: from 0.75 m to 2.75 m in ")) << always[3];
  const Lines hidden = linesUnder("disabled, but they come within 3 m (1)", near);
  ASSERT_EQ(hidden.size(), 1U) << near;
  EXPECT_TRUE(says(hidden[0], "tip - rod: said to be \"Never\", 0.359 m apart at ")) << hidden[0];
}

// The forearm hangs below the upper arm and folds back onto it. Its cover is fixed to it, and has the joint between
// them.
const char* const kFoldingArm = R"(<robot name="folding arm">
  <link name="upper"><collision><geometry><box size="0.1 0.1 1"/></geometry></collision></link>
  <link name="fore"><collision><origin xyz="0 0 0.6"/><geometry><box size="0.1 0.1 0.9"/></geometry></collision></link>
  <link name="cover"><collision><origin xyz="0 0 0.1"/><geometry><box size="0.2 0.2 0.1"/></geometry></collision></link>
  <joint name="elbow" type="revolute">
    <parent link="upper"/><child link="fore"/><origin xyz="0 0 0.6"/><axis xyz="0 1 0"/>
    <limit lower="0" upper="3.14" effort="1" velocity="1"/></joint>
  <joint name="screws" type="fixed"><parent link="fore"/><child link="cover"/></joint>
</robot>)";

TEST_F(PairAudit, NeighboursThatCollideComeFirstAndAreNotDisabled) {
  const std::string urdf = files_.write("arm.urdf", kFoldingArm), out = files_.path("arm.srdf");
  const CommandResult result = runCommand(PAIR_AUDIT " " + urdf + " --write " + out + " 2>/dev/null");
  ASSERT_EQ(result.exit_code, 0) << result.output;
  const std::string title = "adjacent, but apart in some states and in contact in others (1)";
  ASSERT_EQ(linesUnder(title, result.output).size(), 1U) << result.output;
  EXPECT_TRUE(says(linesUnder(title, result.output)[0], "upper - fore: in contact, ")) << result.output;
  EXPECT_TRUE(says(linesUnder(title, result.output)[0], ", at elbow=")) << result.output;
  EXPECT_LT(result.output.find(title), result.output.find("always in contact"));
  EXPECT_FALSE(says(readFile(out), "disable_collisions")) << readFile(out);
}

TEST_F(PairAudit, WhatIsFixedToANeighbourIsNoNeighbour) {
  const std::string report = runCommand(PAIR_AUDIT " " + files_.write("arm.urdf", kFoldingArm) + " 2>&1").output;
  EXPECT_EQ(linesUnder("within 0.02 m in some states (1)", report), Lines{"upper - cover: down to contact"}) << report;
  EXPECT_EQ(linesUnder("adjacent (joined by one joint) (1)", report).size(), 1U) << report;
}

// The cover meets the upper arm where the elbow is bent by a right angle: its corner (0.1, 0.05) is then at (0.05, -0.1),
// where the upper arm ends.
constexpr double kMeeting = M_PI / 2.0, kSearchError = 3.14 / 64.0;

TEST_F(PairAudit, PrintsRangesInWhichPairsAreProvenApart) {
  const std::string urdf = files_.write("arm.urdf", kFoldingArm);
  const CommandResult result = runCommand(PAIR_AUDIT " " + urdf + " --samples 2000 --ranges 0 2>&1");
  ASSERT_EQ(result.exit_code, 0) << result.output;
  const Lines pairs = linesUnder("Proven apart in a range of one joint, or in all states (1)", result.output);
  ASSERT_EQ(pairs.size(), 1U) << result.output;
  const std::string range = " m, elbow from 0 to ";
  const std::size_t place = pairs[0].find(range);
  ASSERT_EQ(pairs[0].find("upper - cover: at least "), 0U) << pairs[0];
  ASSERT_NE(place, std::string::npos) << pairs[0];
  const double upper = std::stod(pairs[0].substr(place + range.size()));
  EXPECT_LT(upper, kMeeting);
  EXPECT_GT(upper, kMeeting - kSearchError);
}

TEST_F(PairAudit, WritesLimitsWithinWhichTheRobotIsProvenApart) {
  const std::string urdf = files_.write("arm.urdf", kFoldingArm), out = files_.path("limits.yaml");
  const CommandResult result =
      runCommand(PAIR_AUDIT " " + urdf + " --samples 2000 --write-safe-limits " + out + " 2>&1");
  ASSERT_EQ(result.exit_code, 0) << result.output;
  EXPECT_TRUE(says(result.output, "Safe limits: 2 pairs are proven apart within them")) << result.output;
  EXPECT_TRUE(says(result.output, "They say nothing about these pairs (0)")) << result.output;
  const auto model = modelOf(std::string(kFoldingArm));
  const JointBox box = jointBoxFrom(readFile(out), out, model->robot, knownRanges(model->robot));
  ASSERT_EQ(box.size(), 1U);
  EXPECT_EQ(box[0].lower, 0.0);
  EXPECT_LT(box[0].upper, kMeeting);
  EXPECT_GT(box[0].upper, kMeeting - kSearchError);
  for (const std::string link : {"fore", "cover"})
    EXPECT_EQ(proveApart(model, {pairOf(*model, "upper", link)}, box)[0].outcome, ProofOutcome::Proven);
}

// A finger is not caught between "upper" and "cover", which are no neighbours.
TEST_F(PairAudit, WritesLimitsWithinWhichAGapStaysOpen) {
  const std::string urdf = files_.write("arm.urdf", kFoldingArm), out = files_.path("limits.yaml");
  const std::string options = " --samples 2000 --write-safe-limits " + out + " --safe-distance 0.025";
  const CommandResult result = runCommand(PAIR_AUDIT " " + urdf + options + " 2>&1");
  ASSERT_EQ(result.exit_code, 0) << result.output;
  const auto model = modelOf(std::string(kFoldingArm));
  const JointBox box = jointBoxFrom(readFile(out), out, model->robot, knownRanges(model->robot));
  ASSERT_EQ(box.size(), 1U);
  const std::vector<ShapeRefPair> pair = {pairOf(*model, "upper", "cover")};
  ProofQuestion finger;
  finger.contact_distance = 0.025;
  EXPECT_EQ(proveApart(model, pair, box, finger)[0].outcome, ProofOutcome::Proven);
  // The limit is as far as the gap stays open, and the limit without contact is farther.
  EXPECT_LT(box[0].upper, kMeeting);
  JointBox larger = box;
  larger[0].upper += kSearchError;
  EXPECT_EQ(proveApart(model, pair, larger)[0].outcome, ProofOutcome::Proven);
  EXPECT_NE(proveApart(model, pair, larger, finger)[0].outcome, ProofOutcome::Proven);
}

TEST_F(PairAudit, SafeLimitsNameThePairsThatTheyDoNotCover) {
  const std::string out = files_.path("limits.yaml");
  const CommandResult result = run("--samples 2000 --srdf " + srdf_ + " --write-safe-limits " + out);
  ASSERT_EQ(result.exit_code, 0) << result.output;
  const Lines uncovered = linesUnder("They say nothing about these pairs (7)", result.output);
  ASSERT_EQ(uncovered.size(), 7U) << result.output;
  EXPECT_EQ(std::count(uncovered.begin(), uncovered.end(), "base - tip: disabled in the SRDF"), 1);
  EXPECT_EQ(std::count(uncovered.begin(), uncovered.end(), "base - rod: always in contact"), 1);
  EXPECT_EQ(std::count(uncovered.begin(), uncovered.end(), "base - loose: a joint between them has no known limits"),
            1);
}

TEST_F(PairAudit, NamesWhatTheSrdfGetsWrong) {
  const std::string report = run("--srdf " + srdf_ + kShort).output;
  const Lines dangerous = linesUnder("disabled, but they can collide (1)", report);
  ASSERT_EQ(dangerous.size(), 1U) << report;
  EXPECT_TRUE(says(dangerous[0], "base - tip: said to be \"User\", in contact, ")) << dangerous[0];
  EXPECT_TRUE(says(dangerous[0], "approach=2.25")) << dangerous[0];
  EXPECT_EQ(linesUnder("checked, but never within 0.05 m (2)", report).size(), 2U);
  EXPECT_EQ(linesUnder("checked, but always in contact (1)", report).size(), 1U);
  EXPECT_EQ(
      linesUnder("entries without effect (3)", report),
      (Lines{"disable_collisions tip - rod: said before", "disable_collisions base - camera: no collision geometry",
             "disable_collisions base - raod: there is no such link"}));
  EXPECT_TRUE(says(report, "no link \"raod\" (did you mean \"rod\"?)")) << report;
}

TEST_F(PairAudit, WritesAnSrdfInWhichItFindsNoFault) {
  const std::string out = files_.path("out.srdf");
  ASSERT_EQ(run("--srdf " + srdf_ + kShort + " --write " + out).exit_code, 0);
  const std::string report = run("--srdf " + out + kShort).output;
  for (const std::string fault : {"disabled, but they can collide (0)", "disabled, but they come within 0.02 m (0)",
                                  "checked, but never within 0.05 m (0)", "checked, but always in contact (0)",
                                  "entries without effect (0)", "remarks (0)"}) {
    EXPECT_TRUE(says(report, fault)) << fault << " is not in\n" << report;
  }
  EXPECT_TRUE(says(readFile(out), "<group_state name=\"home\""));
}

TEST_F(PairAudit, WritesThresholdsForWhatIsAlwaysNear) {
  const std::string srdf = files_.path("out.srdf"), yaml = files_.path("out.yaml");
  const CommandResult result =
      run("--distance 0.9 --warn-distance 3 --samples 2000 --write " + srdf + " --write-thresholds " + yaml);
  ASSERT_EQ(result.exit_code, 0) << result.output;
  const std::string text = readFile(yaml);
  EXPECT_EQ(linesUnder("pair_stop_distance:", text).size(), 0U);  // no indentation
  EXPECT_TRUE(says(text, "- {links: [far, rod], distance: 0.37}  # stays between 750 mm and 2.75e+03 mm\n")) << text;
  EXPECT_TRUE(says(text, "- {links: [far, rod], distance: 0.56}")) << text;
  EXPECT_FALSE(says(text, "[base, rod]")) << text;
  EXPECT_EQ(linesUnder("The level in 500 random states:", result.output).size(), 3U) << result.output;
}

TEST_F(PairAudit, ThresholdsAloneAreThoseOfThePairsThatTheGivenSrdfChecks) {
  const std::string yaml = files_.path("out.yaml");
  const std::string options = "--distance 0.9 --warn-distance 3 --samples 2000 --write-thresholds " + yaml;
  ASSERT_EQ(run(options).exit_code, 0);
  EXPECT_TRUE(says(readFile(yaml), "[tip, rod]")) << readFile(yaml);
  ASSERT_EQ(run(options + " --srdf " + srdf_).exit_code, 0);
  EXPECT_FALSE(says(readFile(yaml), "[tip, rod]")) << readFile(yaml);
  EXPECT_TRUE(says(readFile(yaml), "[far, rod]")) << readFile(yaml);
}

/// The files of a folder, by name.
std::vector<std::string> filesIn(const std::string& folder) {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) names.push_back(entry.path().filename());
  std::sort(names.begin(), names.end());
  return names;
}

TEST_F(PairAudit, SetupMakesAFolder) {
  const std::string folder = files_.path("My Robot-2/");
  const CommandResult result = run("--samples 2000 --setup '" + folder + "'");
  ASSERT_EQ(result.exit_code, 0) << result.output;
  EXPECT_EQ(filesIn(folder), (Lines{"CMakeLists.txt", "package.xml", "proximity.launch", "proximity.test",
                                    "proximity.yaml", "rest.yaml", "robot.srdf", "robot.urdf"}));
  EXPECT_EQ(readFile(folder + "robot.urdf"), kCrossingSliders);
  EXPECT_TRUE(says(readFile(folder + "robot.srdf"), R"(link1="base" link2="rod" reason="Always")"));
  EXPECT_TRUE(says(readFile(folder + "package.xml"), "<name>my_robot_2</name>"));
  EXPECT_TRUE(says(readFile(folder + "CMakeLists.txt"), "project(my_robot_2)"));
  EXPECT_TRUE(says(readFile(folder + "proximity.yaml"), "stop_distance: 0.02\nwarn_distance: 0.05\n"));
  EXPECT_TRUE(says(readFile(folder + "proximity.yaml"), "pair_stop_distance: []\n"));
  EXPECT_TRUE(says(readFile(folder + "rest.yaml"), "level is CLEAR"));
  EXPECT_TRUE(says(readFile(folder + "rest.yaml"), "joints: [slide, approach, reach, spin]\n"))
      << readFile(folder + "rest.yaml");
  EXPECT_TRUE(says(readFile(folder + "rest.yaml"), "- [0, 0, 0, 0, 0]\n"));
  EXPECT_TRUE(says(readFile(folder + "proximity.test"), R"(<param name="worst_level" value="CLEAR"/>)"));
}

TEST_F(PairAudit, SetupKeepsAGivenSrdfUnlessItIsToBeWritten) {
  const std::string kept = files_.path("kept"), written = files_.path("written"), out = files_.path("out.srdf");
  const std::string options = "--samples 2000 --srdf " + srdf_ + " --setup ";
  ASSERT_EQ(run(options + kept).exit_code, 2) << "it checks base - rod, which is always in contact";
  EXPECT_EQ(readFile(kept + "/robot.srdf"), kFaultySrdf);
  ASSERT_EQ(run(options + written + " --write " + out).exit_code, 0);
  EXPECT_EQ(readFile(written + "/robot.srdf"), readFile(out));
}

TEST_F(PairAudit, SetupOverwritesNothing) {
  const std::string folder = files_.path("robot");
  std::filesystem::create_directory(folder);
  std::ofstream(folder + "/robot.srdf") << "mine";
  const CommandResult result = run("--setup " + folder);
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_TRUE(says(result.output, "robot/robot.srdf: is there already, and --setup overwrites nothing"))
      << result.output;
  EXPECT_FALSE(says(result.output, "pairs of links")) << result.output;  // before the study
  EXPECT_EQ(filesIn(folder), Lines{"robot.srdf"});
  EXPECT_EQ(readFile(folder + "/robot.srdf"), "mine");
  EXPECT_TRUE(says(run("--setup " + files_.write("file", "")).output, files_.path("file") + ": is not a folder"));
}

TEST_F(PairAudit, SetupMakesMeshesAbsolute) {
  files_.write("tip.stl",
               "solid t\nfacet normal 0 0 0\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\n"
               "endfacet\nendsolid t\n");
  const std::string urdf = files_.write("mesh.urdf", R"(<robot name="m"><link name="a"><collision><geometry>
      <mesh filename="tip.stl"/></geometry></collision></link></robot>)");
  const std::string folder = files_.path("meshes");
  const CommandResult result = runCommand(PAIR_AUDIT " " + urdf + " --setup " + folder + " 2>&1");
  ASSERT_EQ(result.exit_code, 0) << result.output;
  EXPECT_TRUE(says(readFile(folder + "/robot.urdf"), "filename=\"file://" + files_.path("tip.stl") + "\""));
}

/// The position in which a joint rests that moves a box of 1 m away from another one; at 0 they are `gap` [m] apart.
double restOf(const TemporaryFiles& files, const std::string& gap, int exit_code, const std::string& options = "") {
  using namespace robots;
  const std::string urdf = files.write(
      "rest.urdf",
      urdfOf(link("a", box("1 1 1")) + link("b", box("1 1 1", "1 0 0")) +
                 joint("j", "prismatic", "a", "b", origin(gap + " 0 0") + axis("1 0 0") + limits("0", "1.5")),
             "r"));
  const std::string srdf =
      files.write("rest.srdf", R"(<robot name="r"><enable_collisions link1="a" link2="b"/></robot>)");
  const std::string folder = files.path("rest");
  const CommandResult result =
      runCommand(PAIR_AUDIT " " + urdf + " --samples 2000 --srdf " + srdf + " --setup " + folder + options + " 2>&1");
  EXPECT_EQ(result.exit_code, exit_code) << result.output;
  const std::string rest = readFile(folder + "/rest.yaml");
  std::filesystem::remove_all(folder);
  const std::size_t row = rest.find("- [0, ");
  return row == std::string::npos ? -1.0 : std::stod(rest.substr(row + 6));
}

TEST_F(PairAudit, SetupRestsAtZeroOrInTheMiddleIfTheLevelIsNotStop) {
  EXPECT_EQ(restOf(files_, "0.03", 0), 0.0);   // WARN
  EXPECT_EQ(restOf(files_, "0.01", 0), 0.75);  // 0 is STOP
  EXPECT_GT(restOf(files_, "-1", 2), 1.05);    // the middle is in collision, too
}

TEST_F(PairAudit, SetupTakesAStateOfRest) {
  EXPECT_EQ(restOf(files_, "-0.5", 2), 0.75) << "in collision at 0, as in a third of the states";
  EXPECT_EQ(restOf(files_, "-0.5", 0, " --rest j=0.6"), 0.6);
  EXPECT_EQ(restOf(files_, "-0.5", 2, " --rest j=0.4"), 0.4);
  EXPECT_TRUE(says(run("--setup " + files_.path("new") + " --rest sldie=1").output, "sldie"));
}

// A telescope: each section slides out of the one before it. The tip leaves the mast where both are out by more than 1 m
// together, which is so in 11 % of the states.
const std::string kTelescope = [] {
  using namespace robots;
  const auto out = [](const char* name, const char* from, const char* to, const char* most) {
    return joint(name, "prismatic", from, to, axis("0 0 1") + limits("0", most));
  };
  return urdfOf(link("mast", box("0.3 0.3 1")) + link("inner", box("0.2 0.2 1")) + link("tip", box("0.1 0.1 1")) +
                    out("out", "mast", "inner", "0.5") + out("farther", "inner", "tip", "0.8"),
                "telescope");
}();

TEST_F(PairAudit, ASetupWhosePairsOverlapAsksForADecision) {
  const std::string urdf = files_.write("telescope.urdf", kTelescope), folder = files_.path("telescope");
  const std::string command = PAIR_AUDIT " " + urdf + " --samples 2000 --setup ";
  const CommandResult asked = runCommand(command + folder + " 2>&1");
  EXPECT_EQ(asked.exit_code, 2) << asked.output;
  const Lines pairs = linesUnder("The pairs that set COLLISION and STOP most often", asked.output);
  ASSERT_GE(pairs.size(), 3U) << asked.output;
  EXPECT_TRUE(says(pairs[0], "mast - tip: COLLISION at rest and in 8")) << pairs[0];
  EXPECT_TRUE(says(pairs[0], " of the states, STOP in ")) << pairs[0];
  EXPECT_TRUE(says(pairs[0], ": an overlap of the model")) << pairs[0];
  const std::string entry = R"(<disable_collisions link1="mast" link2="tip" reason="User: in contact at rest and in 8)";
  EXPECT_TRUE(says(pairs[1], entry)) << pairs[1];
  EXPECT_TRUE(says(pairs[2], "costs: nobody reports that the two meet; they were apart in 1")) << pairs[2];
  EXPECT_TRUE(
      says(asked.output, "telescope is not ready: pairs in contact at rest or in more than half of the states (1)"))
      << asked.output;
  EXPECT_FALSE(says(asked.output, "is ready"));
  EXPECT_FALSE(says(readFile(folder + "/robot.srdf"), entry));

  const std::string accepted = files_.path("accepted");
  const CommandResult ready = runCommand(command + accepted + " --accept-overlaps 2>&1");
  EXPECT_EQ(ready.exit_code, 0) << ready.output;
  EXPECT_TRUE(says(ready.output, "accepted as overlaps of the model (1)\n  " + entry)) << ready.output;
  EXPECT_TRUE(says(ready.output, "accepted is ready")) << ready.output;
  EXPECT_TRUE(says(readFile(accepted + "/robot.srdf"), entry));
}

TEST_F(PairAudit, AHighShareOfCollisionsWithoutSuchAPairIsExplained) {
  std::string legs = R"(<robot name="legs"><link name="body"/>)";
  for (const std::string name : {"a", "b", "c", "d", "e", "f"})
    legs += "<link name='" + name +
            "'><collision><origin xyz='0.3 0 0'/><geometry><box size='0.4 0.02 0.02'/></geometry>"
            "</collision></link><joint name='j" +
            name + "' type='revolute'><parent link='body'/><child link='" + name +
            "'/><axis xyz='0 0 1'/><origin rpy='0 0 " + std::to_string(name[0] - 'a') +
            "'/><limit lower='-3.14' upper='3.14' effort='1' velocity='1'/></joint>";
  const std::string urdf = files_.write("legs.urdf", legs + "</robot>");
  const CommandResult result =
      runCommand(PAIR_AUDIT " " + urdf + " --samples 2000 --setup " + files_.path("legs") + " 2>&1");
  EXPECT_EQ(result.exit_code, 0) << result.output;
  EXPECT_TRUE(says(result.output, " of the random states, but no pair in more than half of them: ")) << result.output;
}

// The second box comes to 30 mm of the first: the warn distance is 50 mm.
TEST_F(PairAudit, SetupDisablesNothingThatComesWithinTheWarnDistance) {
  const std::string urdf = files_.write("near.urdf", R"(<robot name="near">
    <link name="a"><collision><geometry><box size="1 1 1"/></geometry></collision></link><link name="between"/>
    <link name="b"><collision><origin xyz="1.03 0 0"/><geometry><box size="1 1 1"/></geometry></collision></link>
    <joint name="j" type="prismatic"><parent link="a"/><child link="between"/><axis xyz="1 0 0"/>
      <limit lower="0" upper="0.5" effort="1" velocity="1"/></joint>
    <joint name="k" type="prismatic"><parent link="between"/><child link="b"/><axis xyz="0 1 0"/>
      <limit lower="0" upper="0.5" effort="1" velocity="1"/></joint></robot>)");
  const std::string command = PAIR_AUDIT " " + urdf + " --samples 2000 --setup ";
  const CommandResult checked = runCommand(command + files_.path("checked") + " 2>&1");
  ASSERT_EQ(checked.exit_code, 0) << checked.output;
  EXPECT_TRUE(says(checked.output, "Never within 0.05 m: 0 pairs, 0 of them proven.\n")) << checked.output;
  EXPECT_FALSE(says(readFile(files_.path("checked/robot.srdf")), "Never"));
  const CommandResult never = runCommand(command + files_.path("never") + " --warn-distance 0.02 2>&1");
  EXPECT_TRUE(says(never.output, "Never within 0.02 m: 1 pairs, 1 of them proven.\n")) << never.output;
  EXPECT_TRUE(says(readFile(files_.path("never/robot.srdf")), R"(link1="a" link2="b" reason="Never")"));
}

TEST_F(PairAudit, SaysTheSameForAnyNumberOfThreads) {
  const std::string one = files_.path("1.srdf"), three = files_.path("3.srdf");
  const std::string alone = run("--samples 5000 --threads 1 --srdf " + srdf_ + " --write " + one).output;
  EXPECT_EQ(run("--samples 5000 --threads 3 --srdf " + srdf_ + " --write " + three).output, alone);
  EXPECT_EQ(readFile(one), readFile(three));
}

TEST_F(PairAudit, SaysWhereTooFewSamplesWereAllowed) {
  EXPECT_TRUE(says(run("--samples 100").output, "100 random states, after which pairs may still change their class"));
}

TEST_F(PairAudit, PrintsTheWarningsOfModelAndSrdf) {
  const CommandResult result = runCommandApart(PAIR_AUDIT " " + urdf_ + " --samples 100 --srdf " + srdf_);
  const SceneModel& model = *crossingSlidersStudy().model;
  ASSERT_FALSE(filterPairs(model.robot, kFaultySrdf).warnings.empty());
  for (const std::string& warning : filterPairs(model.robot, kFaultySrdf).warnings) {
    EXPECT_TRUE(says(result.errors, "warning: " + warning + "\n")) << result.errors;
  }
}

class SharedPairAudit : public PairAudit {
 protected:
  void SetUp() override {
    if (!findsExampleRobots(resolve_)) GTEST_SKIP() << kExampleRobotsMissing;
  }
  /// The output for a URDF below the folder `robots` of the package.
  std::string auditOf(const std::string& urdf, const std::string& options) const {
    const std::filesystem::path package = resolve_("package://example-robot-data/package.xml");
    return runCommand("ROS_PACKAGE_PATH=" + std::string(package.parent_path().parent_path()) + " " PAIR_AUDIT " " +
                      exampleRobotFile(resolve_, urdf) + " " + options + " 2>&1")
        .output;
  }

  MeshResolver resolve_ = exampleRobotsResolver();
};

// shoulder_link - wrist_2_link of the UR10 comes to 1.8 mm, and its wrist_2_link - ee_link stays at 15.6 mm;
// torso_fixed_column_link - arm_2_link of the TIAGo comes to 0.3 mm. None of them may be "Never", or an alarm without
// end.
TEST_F(SharedPairAudit, DisablesNoPairOfRealRobotsThatComesNear) {
  const std::string srdf = files_.path("out.srdf"), yaml = files_.path("out.yaml");
  const std::string options = "--samples 5000 --write " + srdf + " --write-thresholds " + yaml;
  const std::string ur10 = auditOf("ur_description/urdf/ur10_robot.urdf", options);
  EXPECT_FALSE(says(readFile(srdf), R"(link1="shoulder_link" link2="wrist_2_link")")) << ur10;
  EXPECT_FALSE(says(readFile(srdf), R"(link1="shoulder_link" link2="wrist_1_link")")) << "they come to 24 mm";
  EXPECT_TRUE(says(readFile(srdf), R"(link1="wrist_1_link" link2="ee_link" reason="Never")")) << ur10;
  EXPECT_TRUE(says(readFile(yaml), "{links: [wrist_2_link, ee_link], distance: 0.0078}  # stays at 15.6 mm")) << ur10;
  EXPECT_TRUE(says(ur10, "  before      0.0 %      0.0 %")) << ur10;  // STOP or worse in every state
  EXPECT_FALSE(says(ur10, "  after       0.0 %")) << ur10;
#ifndef PROXIMITY_SANITIZED
  const std::string tiago = auditOf("tiago_description/robots/tiago.urdf", options);
  EXPECT_FALSE(says(readFile(srdf), R"(link1="torso_fixed_column_link" link2="arm_2_link")")) << tiago;
#endif
}

/// The result of --setup for a robot of the package public_robots, whose SRDF it writes.
class SharedSetup : public PairAudit {
 protected:
  CommandResult setup(const std::string& robot, const std::string& options = "") const {
    const std::filesystem::path shared = PROXIMITY_SOURCE_DIR "/../shared/robots";
    return runCommand("ROS_PACKAGE_PATH=" + std::string(shared) + " " PAIR_AUDIT " " +
                      std::string(shared / "public_robots" / robot / (robot + ".urdf")) +
                      " --quiet --samples 2000 --setup " + files_.path(robot) + options + " 2>&1");
  }
  void SetUp() override {
    if (!std::filesystem::exists(PROXIMITY_SOURCE_DIR "/../shared/robots/public_robots"))
      GTEST_SKIP() << "there is no ../shared/robots/public_robots";
  }
};

TEST_F(SharedSetup, OfATelescopeThatOverlapsAsksForADecision) {
  if (kIsSanitized) GTEST_SKIP() << "its meshes take minutes; that of a telescope on paper is the same code";
  const CommandResult asked = setup("stretch_se3");
  EXPECT_EQ(asked.exit_code, 2) << asked.output;
  EXPECT_TRUE(says(asked.output, "  link_arm_l4 - link_arm_l2: COLLISION at rest and in ")) << asked.output;
  EXPECT_TRUE(says(asked.output, "stretch_se3 is not ready: ")) << asked.output;
  std::filesystem::remove_all(files_.path("stretch_se3"));
  const CommandResult ready = setup("stretch_se3", " --accept-overlaps");
  EXPECT_EQ(ready.exit_code, 0) << ready.output;
  EXPECT_TRUE(says(ready.output, "stretch_se3 is ready: ")) << ready.output;
}

TEST_F(SharedSetup, ChecksWhatComesWithinTheWarnDistance) {
  const CommandResult result = setup("iiwa14");
  EXPECT_EQ(result.exit_code, 0) << result.output;
  const std::string srdf = readFile(files_.path("iiwa14/robot.srdf"));
  EXPECT_FALSE(says(srdf, R"(link1="base_link" link2="link_4")")) << srdf;  // 32 mm
  EXPECT_TRUE(says(srdf, R"(reason="Never")")) << srdf;
}

TEST_F(SharedPairAudit, FindsThatLinks5And7OfThePandaCollide) {
  const ExampleRobot& panda = kExampleRobots[0];
  const std::string report =
      auditOf(panda.urdf, "--srdf " + exampleRobotFile(resolve_, panda.srdf) + " --samples 5000");
  const Lines dangerous = linesUnder("disabled, but they can collide", report);
  EXPECT_TRUE(std::any_of(dangerous.begin(), dangerous.end(), [](const std::string& line) {
    return line.compare(0, 25, "panda_link5 - panda_link7") == 0 && says(line, " deep, at panda_joint6=");
  })) << report;
}

}  // namespace proximity_server::tools::pair_audit_test
