#include "scene/state/link_groups.h"

#include "proximity_server/scene/filter/pair_filter.h"
#include "scene/model/numbers.h"
#include "scene/small_robots.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <set>

namespace proximity_server::scene::link_groups_test {

using namespace narrowphase;

using Eigen::Isometry3d;
using Eigen::Vector3d;
using Links = std::set<std::string>;

/// Floating links, or another robot, with all pairs that the filter leaves.
struct Grouped {
  explicit Grouped(RobotModel robot, const PairFilterOptions& options = {}) {
    model.pairs = filterPairs(robot, "", options);
    model.robot = std::move(robot);
  }
  PlacedRobot placedBodies(const BodyPoses& poses) const {
    PlacedRobot robot(model.robot, std::make_shared<const Volumes>(model.robot));
    robot.update(poses, {});
    return robot;
  }
  PlacedRobot placed(const std::vector<Isometry3d>& poses) const { return placedBodies(posesOf(model.robot, poses)); }

  int link(const std::string& name) const { return model.robot.findLink(name); }

  SceneModel model;
};

int groupOf(const LinkGroups& groups, int link, int below = 0) {
  const BoxTree::Node& group = groups.tree()[below];
  if (group.isLeaf()) return group.item == link ? below : -1;
  const int found = groupOf(groups, link, group.parts[0]);
  return found >= 0 ? found : groupOf(groups, link, group.parts[1]);
}

std::vector<int> linksOf(const LinkGroups& groups, int group) {
  const BoxTree::Node& here = groups.tree()[group];
  if (here.isLeaf()) return {here.item};
  std::vector<int> links = linksOf(groups, here.parts[0]);
  const std::vector<int> others = linksOf(groups, here.parts[1]);
  links.insert(links.end(), others.begin(), others.end());
  return links;
}

Links namesOf(const Grouped& robot, const std::vector<int>& links) {
  Links names;
  for (const int link : links) names.insert(robot.model.robot.links[link].name);
  return names;
}

const std::vector<std::string> kFiveBalls(5, ball("0.5"));

/// Two arms of two links each. Neighbours in an arm are no candidates, all other pairs are.
const std::string kTwoArms =
    urdfOf(link("base") + link("left upper", ball("0.1")) + link("left fore", ball("0.1")) +
           link("right upper", ball("0.1")) + link("right fore", ball("0.1")) +
           hinge("1", "base", "left upper", "1 0 0") + hinge("2", "base", "right upper", "1 0 0") +
           hinge("3", "left upper", "left fore", "1 0 0") + hinge("4", "right upper", "right fore", "1 0 0"));

// --- the tree

TEST(LinkGroups, HaveEachLinkOfACandidateOnce) {
  const Grouped robot(floatingLinks(kFiveBalls));
  const LinkGroups groups(robot.model);
  const std::vector<int> links = linksOf(groups, 0);
  EXPECT_EQ(links.size(), 5u);
  EXPECT_EQ(namesOf(robot, links), (Links{"0", "1", "2", "3", "4"}));
}

TEST(LinkGroups, LeaveOutLinksOfNoCandidate) {
  PairFilterOptions options;
  options.only_pairs = {{"0", "3"}, {"3", "4"}};
  const Grouped robot(floatingLinks(kFiveBalls), options);
  EXPECT_EQ(namesOf(robot, linksOf(LinkGroups(robot.model), 0)), (Links{"0", "3", "4"}));
}

TEST(LinkGroups, AreNoneWithoutCandidates) {
  const Grouped robot(floatingLinks({ball("1")}));
  EXPECT_TRUE(LinkGroups(robot.model).tree().empty());
  EXPECT_FALSE(LinkGroups(Grouped(floatingLinks(kFiveBalls)).model).tree().empty());
}

TEST(LinkGroups, KeepABranchOfTheKinematicTreeTogether) {
  const Grouped robot(robotOf(kTwoArms));
  const LinkGroups groups(robot.model);
  const std::set<Links> arms{namesOf(robot, linksOf(groups, groups.tree()[0].parts[0])),
                             namesOf(robot, linksOf(groups, groups.tree()[0].parts[1]))};
  EXPECT_EQ(arms, (std::set<Links>{{"left upper", "left fore"}, {"right upper", "right fore"}}));
}

// --- boxes

// Balls of radius 0.5 in a row along y, seen from the frame, which is at the origin of no body with geometry.
TEST(LinkGroups, HaveTheBoxAroundTheirLinks) {
  const Grouped robot(floatingLinks(kFiveBalls));
  LinkGroups groups(robot.model);
  const std::vector<Isometry3d> poses{at(10, 0, 1), at(10, 2, 1), at(10, 4, 1), at(10, 6, 1), at(10, 8, 1)};
  ASSERT_TRUE(groups.refit(robot.placed(poses)));
  EXPECT_LE((groups.tree()[0].box.sizes() - Vector3d(1, 9, 1)).norm(), 1e-12);
  const int first = groupOf(groups, robot.link("0")), last = groupOf(groups, robot.link("4"));
  EXPECT_LE((groups.tree()[first].box.sizes() - Vector3d(1, 1, 1)).norm(), 1e-12);
  EXPECT_LE((groups.tree()[last].box.center() - groups.tree()[first].box.center() - Vector3d(0, 8, 0)).norm(), 1e-12);
}

TEST(LinkGroups, HoldTheBoxesOfTheirParts) {
  const Grouped robot(floatingLinks(kFiveBalls));
  LinkGroups groups(robot.model);
  Chance chance(17);
  std::vector<Isometry3d> poses;
  for (int i = 0; i < 5; ++i) poses.push_back(chance.pose(3.0));
  ASSERT_TRUE(groups.refit(robot.placed(poses)));
  std::vector<int> pending{0};
  while (!pending.empty()) {
    const BoxTree::Node& group = groups.tree()[pending.back()];
    pending.pop_back();
    if (group.isLeaf()) continue;
    for (const int part : group.parts) {
      EXPECT_TRUE(group.box.contains(groups.tree()[part].box));
      pending.push_back(part);
    }
  }
}

TEST(LinkGroups, AreFittedToTheLastPoses) {
  const Grouped robot(floatingLinks({ball("0.5"), ball("0.5")}));
  LinkGroups groups(robot.model);
  const int a = groupOf(groups, robot.link("0")), b = groupOf(groups, robot.link("1"));
  ASSERT_TRUE(groups.refit(robot.placed({at(0, 0, 0), at(3, 0, 0)})));
  EXPECT_NEAR(groups.gap(a, b), 2.0, 1e-12);
  ASSERT_TRUE(groups.refit(robot.placed({at(0, 0, 0), at(0, 0, -9)})));
  EXPECT_NEAR(groups.gap(a, b), 8.0, 1e-12);
}

TEST(LinkGroups, CannotBeFittedWhereAPoseIsMissing) {
  const Grouped robot(floatingLinks(kFiveBalls));
  LinkGroups groups(robot.model);
  BodyPoses poses = posesOf(robot.model.robot, std::vector<Isometry3d>(5, at(1, 2, 3)));
  EXPECT_TRUE(groups.refit(robot.placedBodies(poses)));
  poses[bodyOf(robot.model.robot, "2")].reset();
  EXPECT_FALSE(groups.refit(robot.placedBodies(poses)));
}

// --- gaps

// Balls of radius 0.5 at x = 0, 1, 2 and, 10 away along y, x = 0, 1: the box of the first three ends at y = 0.5, that
// of the others begins at y = 9.5.
TEST(GapOfLinkGroups, IsThatOfTheirBoxes) {
  PairFilterOptions options;
  options.only_pairs = {{"0", "1"}, {"2", "3"}};
  const Grouped robot(floatingLinks({ball("0.5"), ball("0.5"), ball("0.5"), ball("0.5")}), options);
  LinkGroups groups(robot.model);
  ASSERT_TRUE(groups.refit(robot.placed({at(0, 0, 0), at(1, 0, 0), at(0, 10, 0), at(1, 10, 0)})));
  const auto [first, second] = groups.tree()[0].parts;
  ASSERT_EQ(linksOf(groups, first).size(), 2u);
  EXPECT_NEAR(groups.gap(first, second), 9.0, 1e-12);
  EXPECT_NEAR(groups.gap(second, first), 9.0, 1e-12);
}

// The centre of one ball is 1000 from that of the other, and as much is rounded once more in the boxes.
TEST(GapOfLinkGroups, AllowsForTheRoundingOfTheirBoxes) {
  const Grouped robot(floatingLinks({ball("0.5"), ball("0.5")}));
  LinkGroups groups(robot.model);
  ASSERT_TRUE(groups.refit(robot.placed({at(0, 0, 0), at(1000, 0, 0)})));
  EXPECT_LE(groups.gap(1, 2), 999.0 - 1.9 * kPoseRounding * 1000.0);
  EXPECT_GE(groups.gap(1, 2), 999.0 - 2.1 * kPoseRounding * 1000.0);
}

TEST(GapOfLinkGroups, IsLessThePaddingOfThePairThatHasMost) {
  PairFilterOptions options;
  options.pair_padding = {{{"0", "1"}, 0.25}, {{"0", "2"}, 0.125}};
  const Grouped robot(floatingLinks({ball("0.5"), ball("0.5"), ball("0.5")}), options);
  LinkGroups groups(robot.model);
  ASSERT_TRUE(groups.refit(robot.placed({at(0, 0, 0), at(3, 0, 0), at(0, 5, 0)})));
  EXPECT_NEAR(groups.gap(groupOf(groups, robot.link("0")), groupOf(groups, robot.link("1"))), 1.75, 1e-12);
}

TEST(GapOfLinkGroups, ThatOverlapIsUnknown) {
  const Grouped robot(floatingLinks({ball("0.5"), ball("0.5")}));
  LinkGroups groups(robot.model);
  ASSERT_TRUE(groups.refit(robot.placed({at(0, 0, 0), at(0.9, 0.9, 0.9)})));
  EXPECT_EQ(groups.gap(1, 2), -kInfinity);
  EXPECT_EQ(groups.gap(0, 0), -kInfinity);
}

TEST(GapOfLinkGroups, IsNeverAboveTheDistanceOfAnyOfTheirLinks) {
  const Grouped robot(floatingLinks(kFiveBalls));
  LinkGroups groups(robot.model);
  Chance chance(23);
  int positive = 0;
  for (int i = 0; i < 100; ++i) {
    std::vector<Isometry3d> poses;
    for (int link = 0; link < 5; ++link) poses.push_back(chance.pose(6.0));
    ASSERT_TRUE(groups.refit(robot.placed(poses)));
    for (int a = 0; a < 9; ++a) {
      for (int b = 0; b < 9; ++b) {
        const double gap = groups.gap(a, b);
        positive += gap > 0.0;
        for (const int link_a : linksOf(groups, a)) {
          for (const int link_b : linksOf(groups, b)) {
            const auto place = [&](int link) {
              return poses[std::stoi(robot.model.robot.links[link].name)].translation();
            };
            EXPECT_LE(gap, (place(link_a) - place(link_b)).norm() - 1.0);
          }
        }
      }
    }
  }
  EXPECT_GT(positive, 1000);
}

// --- candidates

TEST(CandidateOfLinkGroups, IsTheIndexOfThePairInEitherOrder) {
  PairFilterOptions options;
  options.exclude_pairs = {{"0", "1"}, {"2", "4"}};
  const Grouped robot(floatingLinks(kFiveBalls), options);
  const LinkGroups groups(robot.model);
  const PairTable& pairs = robot.model.pairs;
  ASSERT_EQ(pairs.checked.size(), 8u);
  for (int i = 0; i < 8; ++i) {
    const LinkPair& pair = pairs.pairs[pairs.checked[i]];
    EXPECT_EQ(groups.candidate(pair.link_a, pair.link_b), i);
    EXPECT_EQ(groups.candidate(pair.link_b, pair.link_a), i);
  }
}

TEST(CandidateOfLinkGroups, IsNoneForPairsThatAreNotChecked) {
  PairFilterOptions options;
  options.exclude_pairs = {{"0", "1"}, {"2", "4"}};
  const Grouped robot(floatingLinks(kFiveBalls), options);
  const LinkGroups groups(robot.model);
  EXPECT_EQ(groups.candidate(robot.link("0"), robot.link("1")), -1);
  EXPECT_EQ(groups.candidate(robot.link("4"), robot.link("2")), -1);
  EXPECT_EQ(groups.candidate(robot.link("3"), robot.link("3")), -1);
  EXPECT_EQ(groups.candidate(robot.link("frame"), robot.link("3")), -1);
}

}  // namespace proximity_server::scene::link_groups_test
