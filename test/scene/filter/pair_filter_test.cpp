#include "proximity_server/scene/filter/pair_filter.h"

#include "proximity_server/scene/levels/make_scene_model.h"
#include "proximity_server/scene/query/scene.h"
#include "scene/files.h"
#include "scene/small_robots.h"

#include <gtest/gtest.h>

#include <limits>
#include <set>

namespace proximity_server::scene::pair_filter_test {

using namespace narrowphase;

/// A torso with two arms of two links each; the hand is fixed to the left forearm, the neck has no geometry.
///
///   torso -l1- l_upper -l2- l_fore -weld- l_hand
///   torso -r1- r_upper -r2- r_fore
///   torso -n1- neck -n2- head
const std::string kCube = box("1 1 1");
const std::string kUrdf =
    urdfOf(link("torso", kCube) + link("l_upper", kCube) + link("l_fore", kCube) + link("l_hand", kCube) +
               link("r_upper", kCube) + link("r_fore", kCube) + link("neck") + link("head", kCube) +
               joint("l1", "continuous", "torso", "l_upper") + joint("l2", "continuous", "l_upper", "l_fore") +
               weld("weld", "l_fore", "l_hand") + joint("r1", "continuous", "torso", "r_upper") +
               joint("r2", "continuous", "r_upper", "r_fore", mimic("l2")) +
               joint("n1", "continuous", "torso", "neck") + joint("n2", "continuous", "neck", "head"),
           "twin");

using Names = PairFilterOptions::Names;

class PairFilter : public ::testing::Test {
 protected:
  PairTable filter(const std::string& srdf_body = "", const PairFilterOptions& options = {}) const {
    return filterPairs(robot_, "<robot name=\"twin\">" + srdf_body + "</robot>", options);
  }
  std::string error(const std::string& srdf_body, const PairFilterOptions& options = {}) const {
    return errorOf([&] { filter(srdf_body, options); });
  }
  const LinkPair& pair(const PairTable& table, const std::string& a, const std::string& b) const {
    return table.pairs.at(table.find(robot_.findLink(a), robot_.findLink(b)));
  }
  PairReason reason(const PairTable& table, const std::string& a, const std::string& b) const {
    return pair(table, a, b).reason;
  }
  RobotModel robot_ = robotOf(kUrdf);
};

std::string entry(const std::string& element, const std::string& a, const std::string& b,
                  const std::string& more = "") {
  return "<" + element + " link1=\"" + a + "\" link2=\"" + b + "\" " + more + "/>";
}
std::string disable(const std::string& a, const std::string& b, const std::string& more = "") {
  return entry("disable_collisions", a, b, more);
}
std::string enable(const std::string& a, const std::string& b) { return entry("enable_collisions", a, b); }

std::string joined(const std::vector<std::string>& warnings) {
  std::string all;
  for (const std::string& warning : warnings) all += warning + "\n";
  return all;
}

/// The warning that mentions `what`, or "".
std::string warning(const PairTable& table, const std::string& what) {
  for (const std::string& text : table.warnings) {
    if (text.find(what) != std::string::npos) return text;
  }
  return "";
}

bool says(const std::string& text, const std::string& what) { return text.find(what) != std::string::npos; }

// --- the table

// Seven links have geometry: 21 pairs. One is in the same body. Adjacent are torso to l_upper and r_upper, l_upper -
// l_fore, r_upper - r_fore: four. The hand is fixed to the forearm, which has geometry, so it is no neighbour of the
// upper arm; the head is two joints away from the torso.
TEST_F(PairFilter, WithoutAnSrdfBodiesAndNeighboursAreLeftOut) {
  for (const PairTable& table : {filterPairs(robot_, ""), filter()}) {
    EXPECT_EQ(table.pairs.size(), 21U);
    EXPECT_EQ(table.checked.size(), 16U);
    EXPECT_EQ(reason(table, "l_fore", "l_hand"), PairReason::SameBody);
    EXPECT_EQ(reason(table, "torso", "l_upper"), PairReason::Adjacent);
    EXPECT_EQ(reason(table, "l_hand", "l_upper"), PairReason::Checked);
    EXPECT_EQ(reason(table, "torso", "head"), PairReason::Checked);
    EXPECT_EQ(reason(table, "torso", "l_fore"), PairReason::Checked);
  }
}

TEST_F(PairFilter, PairsAreSortedAndFoundInEitherOrder) {
  const PairTable table = filter();
  for (std::size_t i = 0; i < table.pairs.size(); ++i) {
    const LinkPair& pair = table.pairs[i];
    EXPECT_LT(pair.link_a, pair.link_b);
    EXPECT_EQ(table.find(pair.link_a, pair.link_b), static_cast<int>(i));
    EXPECT_EQ(table.find(pair.link_b, pair.link_a), static_cast<int>(i));
  }
  EXPECT_EQ(table.find(robot_.findLink("torso"), robot_.findLink("neck")), -1);
  EXPECT_EQ(table.find(robot_.findLink("torso"), robot_.findLink("torso")), -1);
}

TEST_F(PairFilter, CheckedListsExactlyThePairsWithoutAnObjection) {
  const PairTable table = filter(disable("torso", "head"));
  std::vector<int> expected;
  for (int i = 0; i < static_cast<int>(table.pairs.size()); ++i) {
    if (table.pairs[i].reason == PairReason::Checked) expected.push_back(i);
  }
  EXPECT_EQ(table.checked, expected);
}

TEST(PairReasons, HaveDifferentNames) {
  std::set<std::string> names;
  for (int i = 0; i <= static_cast<int>(PairReason::NotInGroup); ++i) {
    names.insert(toString(static_cast<PairReason>(i)));
  }
  EXPECT_EQ(names.size(), static_cast<std::size_t>(PairReason::NotInGroup) + 1);
}

// --- SRDF

TEST_F(PairFilter, DisabledPairsKeepTheReasonOfTheSrdf) {
  const PairTable table = filter(disable("head", "torso", "reason=\"Never\""));
  EXPECT_EQ(reason(table, "torso", "head"), PairReason::SrdfDisabled);
  EXPECT_EQ(pair(table, "torso", "head").detail, "Never");
  EXPECT_EQ(pair(table, "torso", "l_fore").detail, "");
}

TEST_F(PairFilter, DisableDefaultTakesAllPairsOfALink) {
  const PairTable table = filter("<disable_default_collisions link='head'/>");
  EXPECT_EQ(table.checked.size(), 16U - 6U);
  EXPECT_EQ(reason(table, "l_hand", "head"), PairReason::SrdfDisabled);
}

TEST_F(PairFilter, EnableBringsBackWhatDefaultsOrAdjacencyTook) {
  const PairTable table =
      filter("<disable_default_collisions link='head'/>" + enable("head", "l_hand") + enable("torso", "l_upper"));
  EXPECT_EQ(reason(table, "l_hand", "head"), PairReason::Checked);
  EXPECT_EQ(reason(table, "r_fore", "head"), PairReason::SrdfDisabled);
  EXPECT_EQ(reason(table, "torso", "l_upper"), PairReason::Checked);
}

TEST_F(PairFilter, EnableYieldsToDisableOfTheSamePairWithAWarning) {
  const PairTable table = filter(enable("head", "torso") + disable("torso", "head"));
  EXPECT_EQ(reason(table, "torso", "head"), PairReason::SrdfDisabled);
  EXPECT_TRUE(says(warning(table, "yields"), "torso - head"));
}

TEST_F(PairFilter, EnableOfAPairThatIsCheckedAnywayIsReported) {
  EXPECT_TRUE(says(warning(filter(enable("head", "torso")), "anyway"), "torso - head"));
}

TEST_F(PairFilter, UnknownLinksOfTheSrdfAreReportedWithTheNearestName) {
  const PairTable table = filter(disable("l_hamd", "head") + "<disable_default_collisions link='haed'/>");
  EXPECT_EQ(table.checked.size(), 16U);
  EXPECT_TRUE(says(warning(table, "\"l_hamd\""), "\"l_hand\""));
  EXPECT_TRUE(says(warning(table, "\"haed\""), "\"head\""));
}

TEST_F(PairFilter, UselessEntriesAreCountedInOneSentence) {
  std::string srdf;
  for (int i = 0; i < 300; ++i) srdf += disable("neck", "head") + disable("absent" + std::to_string(i), "head");
  srdf += disable("torso", "head") + disable("head", "torso") + disable("torso", "head");
  srdf += disable("l_fore", "l_hand");
  const PairTable table = filter(srdf);
  EXPECT_EQ(
      warning(table, "of 604"),
      "disable_collisions: 603 of 604 entries have no effect: name a link that does not exist (300), a link without "
      "collision geometry (300), two links of one rigid body (1), a pair for the second time (2).");
  EXPECT_LE(table.warnings.size(), 5U) << joined(table.warnings);
}

TEST_F(PairFilter, NeighboursThatTheSrdfDoesNotListAreReported) {
  const PairTable table =
      filter(disable("torso", "l_upper") + disable("l_upper", "l_fore") + disable("torso", "r_upper"));
  EXPECT_TRUE(says(warning(table, "neighbours"), "(1): r_upper - r_fore."));
}

TEST_F(PairFilter, PairsWithOnlyEmptyLinksBetweenThemAreReported) {
  EXPECT_TRUE(says(warning(filter(), "may always touch"), "(1): torso - head."));
  EXPECT_EQ(warning(filter(disable("torso", "head")), "may always touch"), "");
}

TEST_F(PairFilter, SrdfOfAnotherRobotIsReported) {
  EXPECT_TRUE(says(joined(filterPairs(robot_, "<robot name='other'/>").warnings), "\"other\""));
}

TEST_F(PairFilter, CompleteSrdfGivesNoWarning) {
  const PairTable table = filter(disable("torso", "l_upper") + disable("l_upper", "l_fore") +
                                 disable("torso", "r_upper") + disable("r_upper", "r_fore") + disable("torso", "head"));
  EXPECT_EQ(joined(table.warnings), "");
}

TEST_F(PairFilter, MalformedSrdfThrows) {
  EXPECT_NE(errorOf([&] { filterPairs(robot_, "<robot"); }), "");
  EXPECT_NE(errorOf([&] { filterPairs(robot_, "no XML"); }), "");
  EXPECT_TRUE(says(errorOf([&] { filterPairs(robot_, "<sdf/>"); }), "<robot>"));
  EXPECT_TRUE(says(error("\n\n<disable_collisions link1='torso'/>"), "line 3"));
  EXPECT_TRUE(says(error("<disable_collisions link1='torso'/>"), "link2"));
}

// --- neighbours

std::string fixed(const std::string& parent, const std::string& child, const std::string& xyz = "0 0 0") {
  return weld(parent + "_" + child, parent, child, xyz);
}
std::string turning(const std::string& parent, const std::string& child, const std::string& xyz = "0 0 0") {
  return hinge(parent + "_" + child, parent, child, "0 0 1", xyz);
}
RobotModel robotWith(const std::string& links_and_joints) { return robotOf(urdfOf(links_and_joints, "r")); }
bool areNeighbours(const RobotModel& robot, const std::string& a, const std::string& b) {
  const bool answer = robot.areNeighbours(robot.findLink(a), robot.findLink(b));
  EXPECT_EQ(robot.areNeighbours(robot.findLink(b), robot.findLink(a)), answer);
  return answer;
}

const std::string kBox = box("0.2 0.2 0.2");

TEST(Neighbours, AreJoinedByOneJointSeenThroughFixedLinksWithoutGeometry) {
  const RobotModel robot = robotWith(link("base", kBox) + link("flange") + link("axle") + link("arm", kBox) +
                                     fixed("base", "flange") + turning("flange", "axle") + fixed("axle", "arm"));
  EXPECT_TRUE(areNeighbours(robot, "base", "arm"));
}

TEST(Neighbours, AreSeenThroughACommonParentWithoutGeometry) {
  const RobotModel robot =
      robotWith(link("root") + link("base", kBox) + link("arm", kBox) + fixed("root", "base") + turning("root", "arm"));
  EXPECT_TRUE(areNeighbours(robot, "base", "arm"));
}

TEST(Neighbours, AreNotSeenThroughLinksWithGeometry) {
  const RobotModel robot = robotWith(link("base", kBox) + link("mast", kBox) + link("arm", kBox) + link("lamp", kBox) +
                                     fixed("base", "mast") + turning("base", "arm") + fixed("arm", "lamp"));
  EXPECT_TRUE(areNeighbours(robot, "base", "arm"));
  EXPECT_FALSE(areNeighbours(robot, "mast", "arm"));
  EXPECT_FALSE(areNeighbours(robot, "base", "lamp"));
  EXPECT_FALSE(areNeighbours(robot, "mast", "lamp"));
}

TEST(Neighbours, AreNeitherOfOneBodyNorTwoJointsApart) {
  const RobotModel robot = robotWith(link("base", kBox) + link("mast", kBox) + link("cross") + link("arm", kBox) +
                                     fixed("base", "mast") + turning("base", "cross") + turning("cross", "arm"));
  EXPECT_FALSE(areNeighbours(robot, "base", "mast"));
  EXPECT_FALSE(areNeighbours(robot, "base", "arm"));
  EXPECT_FALSE(areNeighbours(robot, "base", "base"));
}

TEST_F(PairFilter, EveryNeighbourThatTheSrdfDoesNotListIsNamed) {
  std::string body = link("hub", kBox);
  for (int i = 0; i < 20; ++i) {
    body += link("spoke" + std::to_string(i), kBox) + turning("hub", "spoke" + std::to_string(i));
  }
  const std::string text = warning(filterPairs(robotWith(body), ""), "neighbours");
  for (int i = 0; i < 20; ++i) EXPECT_TRUE(says(text, "hub - spoke" + std::to_string(i))) << text;
}

// The arm turns about z above its base. The rod stands in its axis, so they overlap in every state; the mast is in its
// way only where the joint is near 0 and pi. Rod and mast are fixed to the base.
const std::string kMast = link("base", box("0.4 0.4 0.1")) + link("mast", box("0.1 0.1 1")) +
                          link("rod", cylinder("0.05", "1")) + link("arm", box("0.8 0.1 0.1")) +
                          fixed("base", "mast", "-0.3 0 0.5") + fixed("base", "rod", "0 0 0.5") +
                          turning("base", "arm", "0 0 0.5");

TEST(SceneModelPairs, WhatIsFixedToANeighbourIsChecked) {
  const SceneModel model = makeSceneModel(robotWith(kMast), "");
  const auto reason = [&](const char* a, const char* b) {
    return model.pairs.pairs.at(model.pairs.find(model.robot.findLink(a), model.robot.findLink(b))).reason;
  };
  EXPECT_EQ(reason("mast", "arm"), PairReason::Checked);
  EXPECT_EQ(reason("rod", "arm"), PairReason::Checked);
  EXPECT_EQ(reason("base", "arm"), PairReason::Adjacent);
}

TEST(SceneModelPairs, OnlyWhatTouchesInAllStatesOfItsJointIsReported) {
  const std::string what = "in contact in each of 300 states";
  const std::string text = warning(makeSceneModel(robotWith(kMast), "").pairs, what);
  EXPECT_TRUE(says(text, "(1): arm - rod.")) << text;
  const std::string disabled = "<robot name='r'>" + disable("rod", "arm") + "</robot>";
  EXPECT_EQ(warning(makeSceneModel(robotWith(kMast), disabled).pairs, what), "");
}

TEST(SceneModelPairs, ThatAJointWithoutAPositionNeverMovesIsNotReported) {
  const std::string loose = link("base", kBox) + link("mast", kBox) + link("cart", kBox) + fixed("base", "mast") +
                            joint("loose", "floating", "base", "cart");
  EXPECT_EQ(warning(makeSceneModel(robotWith(loose), "").pairs, "in contact"), "");
}

// --- configuration

TEST_F(PairFilter, RefusesAUrdfInPlaceOfTheSrdf) {
  EXPECT_EQ(errorOf([&] { filterPairs(robot_, kUrdf); }),
            "SRDF, line 1: this is a URDF: it describes the link \"torso\", and has nothing that an SRDF has "
            "(disable_collisions, groups)");
  EXPECT_TRUE(says(error("<link name='a'/><link name='b'/>"
                         "<joint name='j' type='fixed'><parent link='a'/><child link='b'/></joint>"),
                   "this is a URDF: it describes the joint \"j\""));
}

// Elements of an SRDF that have the name of one of a URDF, and those of other programs.
TEST_F(PairFilter, TakesWhateverMayStandInAnSrdf) {
  EXPECT_EQ(error("<group name='g'><link name='torso'/><joint name='l1'/></group>"
                  "<group_state name='home' group='g'><joint name='l1' value='0'/></group_state>"),
            "");
  EXPECT_EQ(error("<group_state name='home' group='g'><joint name='l1' value='0'/></group_state>"
                  "<passive_joint name='l1'/><link name='torso'/><joint name='l1' mass='1'/>"
                  "<gripper name='g'><link name='l_hand'/><position>0 0 0</position></gripper>"
                  "<rotor_params><joint name='l1' mass='1' gear_ratio='2'/></rotor_params>"),
            "");
  EXPECT_EQ(error("<link name='torso'><collision/></link>" + disable("torso", "l_fore")), "") << "both in one file";
}

TEST_F(PairFilter, ExcludedPairsAreNotChecked) {
  PairFilterOptions options;
  options.exclude_pairs = {{"head", "torso"}};
  const PairTable table = filter("", options);
  EXPECT_EQ(reason(table, "torso", "head"), PairReason::ConfigExcluded);
  EXPECT_EQ(table.checked.size(), 15U);
}

TEST_F(PairFilter, OnlyPairsLeaveNothingElseAndBringBackNeighbours) {
  PairFilterOptions options;
  options.only_pairs = {{"l_hand", "head"}, {"l_upper", "torso"}};
  const PairTable table = filter("", options);
  EXPECT_EQ(table.checked.size(), 2U);
  EXPECT_EQ(reason(table, "torso", "l_upper"), PairReason::Checked);
  EXPECT_EQ(reason(table, "torso", "head"), PairReason::NotInOnlyPairs);
}

TEST_F(PairFilter, FirstReasonThatAppliesIsGiven) {
  PairFilterOptions options;
  options.only_pairs = {{"torso", "head"}, {"l_hand", "l_fore"}, {"torso", "l_fore"}};
  options.exclude_pairs = {{"torso", "head"}, {"r_fore", "head"}};
  const PairTable table = filter(disable("torso", "head") + disable("torso", "l_fore"), options);
  EXPECT_EQ(reason(table, "l_hand", "l_fore"), PairReason::SameBody);
  EXPECT_EQ(reason(table, "r_fore", "head"), PairReason::NotInOnlyPairs);
  EXPECT_EQ(reason(table, "torso", "head"), PairReason::ConfigExcluded);
  EXPECT_EQ(reason(table, "torso", "l_fore"), PairReason::SrdfDisabled);
  EXPECT_TRUE(table.checked.empty());
  EXPECT_NE(warning(table, "No pair"), "");
}

TEST_F(PairFilter, PaddingBelongsToItsPair) {
  PairFilterOptions options;
  options.pair_padding = {{{"head", "torso"}, 0.05}};
  const PairTable table = filter("", options);
  EXPECT_EQ(pair(table, "torso", "head").padding, 0.05);
  EXPECT_EQ(pair(table, "torso", "l_fore").padding, 0.0);
}

TEST_F(PairFilter, UselessPairsOfTheConfigurationAreReported) {
  PairFilterOptions options;
  options.exclude_pairs = {{"neck", "head"}};
  EXPECT_EQ(warning(filter("", options), "exclude_pairs"),
            "exclude_pairs: 1 of 1 entries has no effect: a link without collision geometry.");
}

TEST_F(PairFilter, UnknownLinksOfTheConfigurationThrowWithTheNearestName) {
  PairFilterOptions exclude, only, padding, broken;
  exclude.exclude_pairs = only.only_pairs = {{"head", "l_hamd"}};
  padding.pair_padding = {{{"l_hamd", "head"}, 0.1}};
  for (const PairFilterOptions& options : {exclude, only, padding}) {
    EXPECT_TRUE(says(error("", options), "\"l_hamd\" (did you mean \"l_hand\"?)"));
  }
  broken.pair_padding = {{{"head", "torso"}, std::numeric_limits<double>::quiet_NaN()}};
  EXPECT_TRUE(says(error("", broken), "torso - head"));
}

TEST_F(PairFilter, EntriesWithoutEffectAreKeptWithTheirCause) {
  PairFilterOptions options;
  options.exclude_pairs = {{"neck", "head"}};
  const PairTable table = filter(
      disable("torso", "head") + disable("l_fore", "l_hand") + disable("head", "torso") + disable("torso", "haed"),
      options);
  std::vector<std::string> entries;
  for (const IdleEntry& entry : table.idle) {
    entries.push_back(entry.list + ": " + entry.link_a + "-" + entry.link_b + ": " + toString(entry.cause));
  }
  EXPECT_EQ(entries, (std::vector<std::string>{"exclude_pairs: neck-head: a link without collision geometry",
                                               "disable_collisions: l_fore-l_hand: two links of one rigid body",
                                               "disable_collisions: head-torso: a pair for the second time",
                                               "disable_collisions: torso-haed: name a link that does not exist"}));
}

// --- groups

const std::string kGroups =
    "<group name='left_joints'><joint name='l1'/><joint name='l2'/><joint name='weld'/></group>"
    "<group name='left_links'><link name='l_upper'/><link name='l_hand'/></group>"
    "<group name='left_chain'><chain base_link='torso' tip_link='l_hand'/></group>"
    "<group name='head_chain'><chain base_link='neck' tip_link='head'/></group>"
    "<group name='hand_to_hand'><chain base_link='l_hand' tip_link='r_fore'/></group>"
    "<group name='both'><group name='left_chain'/><group name='head_chain'/></group>"
    "<group name='circle'><group name='around'/></group><group name='around'><group name='circle'/></group>"
    "<group name='typos'><joint name='l3'/><link name='haed'/><chain base_link='tors' tip_link='head'/></group>"
    "<group name='dangling'><group name='left_chian'/></group>"
    "<group name='virtual'><joint name='floor'/></group>"
    "<virtual_joint name='floor' type='planar' parent_frame='map' child_link='torso'/>";

class PairGroup : public PairFilter {
 protected:
  PairTable group(const std::string& name) const { return filter(kGroups, inGroup(name)); }
  std::string errorOfGroup(const std::string& name) const { return error(kGroups, inGroup(name)); }
  static PairFilterOptions inGroup(const std::string& name) {
    PairFilterOptions options;
    options.group = name;
    return options;
  }
  /// The links that move with the group: those that still have a pair with the torso, whatever their neighbours.
  std::set<std::string> moved(const std::string& name) const {
    std::string all = kGroups;
    for (const Link& link : robot_.links) all += enable("torso", link.name);
    const PairTable table = filter(all, inGroup(name));
    std::set<std::string> links;
    for (const int i : table.checked) {
      if (table.pairs[i].link_a == robot_.findLink("torso")) links.insert(robot_.links[table.pairs[i].link_b].name);
    }
    return links;
  }
};

using Set = std::set<std::string>;

TEST_F(PairGroup, KeepsThePairsWithALinkThatItMoves) {
  const PairTable table = group("head_chain");
  EXPECT_EQ(table.checked.size(), 6U);
  EXPECT_EQ(reason(table, "head", "l_hand"), PairReason::Checked);
  EXPECT_EQ(reason(table, "l_hand", "r_fore"), PairReason::NotInGroup);
  EXPECT_EQ(reason(table, "torso", "l_upper"), PairReason::Adjacent);
}

// r2 mimics l2, so what moves the left forearm moves the right one.
TEST_F(PairGroup, JointsLinksAndChainsNameTheSameArm) {
  const Set arm{"l_upper", "l_fore", "l_hand", "r_fore"};
  EXPECT_EQ(moved("left_joints"), arm);
  EXPECT_EQ(moved("left_chain"), arm);
  EXPECT_EQ(moved("left_links"), (Set{"l_upper", "l_fore", "l_hand"}));
}

TEST_F(PairGroup, ChainMayGoUpAndDown) {
  EXPECT_EQ(moved("hand_to_hand"), (Set{"l_upper", "l_fore", "l_hand", "r_upper", "r_fore"}));
}

TEST_F(PairGroup, SubgroupsAddUp) { EXPECT_EQ(moved("both"), (Set{"l_upper", "l_fore", "l_hand", "r_fore", "head"})); }

TEST_F(PairGroup, VirtualJointMovesNoLinkAgainstAnother) {
  EXPECT_TRUE(group("virtual").checked.empty());
  EXPECT_EQ(warning(group("virtual"), "floor"), "");
}

TEST_F(PairGroup, UnknownNamesInAGroupAreReportedWithTheNearest) {
  const std::string text = warning(group("typos"), "\"typos\"");
  EXPECT_TRUE(says(text, "no joint \"l3\" (did you mean")) << text;
  EXPECT_TRUE(says(text, "no link \"haed\" (did you mean \"head\"?)")) << text;
  EXPECT_TRUE(says(text, "no link \"tors\" (did you mean \"torso\"?)")) << text;
}

// Regression: a misspelt element was passed over without a word, so that the pairs that it names were checked, or not.
TEST_F(PairGroup, MisspeltElementsAndAttributesThrowWithWhatIsMeant) {
  const std::pair<std::string, std::string> typos[] = {
      {"<disable_collision link1='torso' link2='head'/>",
       "SRDF, line 1: unknown element <disable_collision>, did you mean <disable_collisions>?"},
      {"\n<enable_colisions link1='torso' link2='head'/>",
       "SRDF, line 2: unknown element <enable_colisions>, did you mean <enable_collisions>?"},
      {"<groups name='arm'/>", "SRDF, line 1: unknown element <groups>, did you mean <group>?"},
      {"<group name='arm'><chian base_link='torso' tip_link='head'/></group>",
       "SRDF, line 1: unknown element <chian>, did you mean <chain>?"},
      {"<disable_collisions lnk1='torso' link2='head'/>",
       "SRDF, line 1: <disable_collisions> has the unknown attribute lnk1, did you mean link1?"},
      {"<disable_collisions link1='torso' link2='head' raeson='Never'/>",
       "SRDF, line 1: <disable_collisions> has the unknown attribute raeson, did you mean reason?"},
      {"<group name='arm'><chain base_lnk='torso' tip_link='head'/></group>",
       "SRDF, line 1: <chain> has the unknown attribute base_lnk, did you mean base_link?"},
      {"<disable_collisions link2='head'/>", "SRDF, line 1: <disable_collisions> has no attribute link1"}};
  for (const auto& [srdf, said] : typos) EXPECT_EQ(error(srdf), said);
  // Elements of an SRDF that are of no concern here, and those of others.
  EXPECT_EQ(error("<group_state name='home' group='arm'/><end_effector name='hand'/><passive_joint name='j'/>"
                  "<link_sphere_approximation link='torso'/><joint_property joint_name='j'/><comment/>"),
            "");
}

TEST_F(PairGroup, UnknownGroupThrowsWithTheNearestName) {
  EXPECT_TRUE(says(errorOfGroup("left_chian"), "did you mean \"left_chain\"?"));
  EXPECT_TRUE(says(errorOfGroup("dangling"), "\"left_chian\""));
}

TEST_F(PairGroup, UnknownGroupThrowsWithAllThatThereAre) {
  const std::string said = errorOfGroup("arm");
  for (const std::string group : {"left_chain", "dangling", "circle"}) EXPECT_TRUE(says(said, group)) << said;
  EXPECT_TRUE(says(error("", inGroup("arm")), "no group \"arm\"; it has none"));
}

TEST_F(PairGroup, GroupThatContainsItselfThrows) { EXPECT_TRUE(says(errorOfGroup("circle"), "contains itself")); }

}  // namespace proximity_server::scene::pair_filter_test
