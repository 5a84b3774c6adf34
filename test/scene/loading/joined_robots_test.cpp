#include "proximity_server/scene/loading/joined_robots.h"

#include "proximity_server/narrowphase/signed_distance.h"
#include "proximity_server/scene/filter/pair_filter.h"
#include "proximity_server/scene/levels/make_scene_model.h"
#include "proximity_server/scene/model/joint_ranges.h"
#include "proximity_server/scene/model/names.h"
#include "scene/files.h"
#include "scene/posed_scene.h"
#include "scene/small_robots.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <memory>

namespace proximity_server::scene::joined_robots_test {

using Eigen::Isometry3d;

/// A base, and two arms of three links on it; "finger" mimics "elbow", and "camera" is fixed to the base.
const std::string kArms =
    urdfOf(link("base", box("0.4 0.4 0.4")) + link("camera", ball("0.05", "0 0 0.5")) +
               weld("mount", "base", "camera") + link("upper", cylinder("0.1", "0.6", "0.5 0 0", "0 1.5708 0")) +
               link("fore", box("0.6 0.1 0.1", "0.4 0 0")) + link("finger", ball("0.08", "0.2 0 0")) +
               joint("shoulder", "revolute", "base", "upper", origin("0 0 0.3") + axis("0 0 1") + limits("-3", "3")) +
               joint("elbow", "revolute", "upper", "fore", origin("0.9 0 0") + axis("0 1 0") + limits("-2", "2")) +
               joint("follower", "revolute", "fore", "finger",
                     origin("0.8 0 0") + axis("0 0 1") + limits("-2", "2") + mimic("elbow")),
           "arms");

const std::string kSrdf =
    "<robot name='arms'><group name='hand'><link name='finger'/></group>"
    "<disable_collisions link1='base' link2='fore' reason='Never'/></robot>";

using Srdfs = std::vector<std::string>;

const std::vector<NamedUrdf> kTwo = {{"left", kArms}, {"right", kArms}};

RobotModel twoArms(const ModelOptions& options = {}) { return loadRobots(kTwo, packageResolver({}), options); }

bool says(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

// --- the model

TEST(JoinedRobots, HaveLinksAndJointsThatAreNamedByTheirRobot) {
  const RobotModel model = twoArms();
  const std::vector<std::string> links = namesOf(model.links);
  ASSERT_EQ(links.size(), 10U);
  EXPECT_EQ(links.front(), "left/base");
  EXPECT_EQ(model.robotOf(model.findLink("right/fore")).name, "right");
  EXPECT_EQ(model.robotOf(model.findLink("left/fore")).name, "left");
  EXPECT_GE(findNamed(model.joints, "right/elbow"), 0);
  EXPECT_EQ(model.fixed_joints, (std::vector<std::string>{"left/mount", "right/mount"}));
  EXPECT_EQ(model.name, "left (arms), right (arms)");
  EXPECT_EQ(robotOf(kArms).robotOf(0).name, "");
}

TEST(JoinedRobots, AreEachAsTheyAreAlone) {
  const RobotModel alone = robotOf(kArms), model = twoArms();
  ASSERT_EQ(model.bodies.size(), 2 * alone.bodies.size());
  for (std::size_t i = 0; i < model.bodies.size(); ++i) {
    const std::size_t own = i % alone.bodies.size();
    const Member& robot = model.robots[i / alone.bodies.size()];
    const Body &body = model.bodies[i], &single = alone.bodies[own];
    EXPECT_EQ(robot.ownName(model.links[body.link].name), alone.links[single.link].name);
    EXPECT_EQ(body.links.size(), single.links.size());
    ASSERT_EQ(body.pieces.size(), single.pieces.size());
    EXPECT_EQ(body.joint < 0, single.joint < 0);
    if (body.joint >= 0) {
      EXPECT_EQ(model.links[model.joints[body.joint].child_link].body, static_cast<int>(i));
      EXPECT_EQ(model.links[model.joints[body.joint].parent_link].body, body.parent);
    }
    for (const int piece : body.pieces) {
      const Link& link = model.links[model.collisions[model.pieces[piece].collision].link];
      EXPECT_EQ(link.body, static_cast<int>(i));
    }
  }
  for (int i = 0; i < static_cast<int>(model.links.size()); ++i) {
    const Link& link = model.links[i];
    for (const int collision : link.collisions) EXPECT_EQ(model.collisions[collision].link, i);
    if (link.parent >= 0) {
      EXPECT_EQ(model.robotOf(link.parent).name, model.robotOf(i).name);
    }
  }
  const int follower = findNamed(model.joints, "right/follower");
  EXPECT_EQ(model.joints[model.leaderOf(follower).joint].name, "right/elbow");
}

TEST(JoinedRobots, HaveARootEachAndNothingBetweenThem) {
  const RobotModel model = twoArms();
  const std::vector<int> roots = model.roots();
  ASSERT_EQ(roots.size(), 2U);
  EXPECT_EQ(model.links[model.bodies[roots[1]].link].name, "right/base");
  const int left = model.findLink("left/fore"), right = model.findLink("right/upper");
  EXPECT_FALSE(model.connection(left, right));
  EXPECT_FALSE(model.areNeighbours(model.findLink("left/base"), model.findLink("right/base")));
  EXPECT_TRUE(model.areNeighbours(model.findLink("right/base"), model.findLink("right/upper")));
  std::vector<std::string> between;
  for (const int joint : jointsBetween(model, model.links[left].body, model.links[right].body))
    between.push_back(model.joints[joint].name);
  EXPECT_EQ(between, (std::vector<std::string>{"left/elbow", "left/shoulder", "right/shoulder"}));
}

TEST(JoinedRobots, StandWhereTheirRootsAre) {
  const RobotModel alone = robotOf(kArms), model = twoArms();
  Chance chance(3);
  const Isometry3d left = chance.pose(1.0), right = chance.pose(1.0);
  const BodyPoses own = forwardKinematics(alone, {{"elbow", 0.5}});
  const BodyPoses poses =
      placedAt(model, forwardKinematics(model, {{"left/elbow", 0.5}, {"right/elbow", 0.5}}), {left, right});
  for (std::size_t i = 0; i < own.size(); ++i) {
    EXPECT_EQ(poses[i]->matrix(), (left * *own[i]).matrix());
    EXPECT_EQ(poses[own.size() + i]->matrix(), (right * *own[i]).matrix());
  }
  const BodyPoses half =
      placedAt(model, forwardKinematics(model, std::map<std::string, double>()), {left, std::nullopt});
  EXPECT_TRUE(half[0]);
  EXPECT_FALSE(half[own.size()]);
  EXPECT_FALSE(half.back());
}

TEST(JoinedRobots, AreRefusedForTheirNames) {
  const RobotModel arms = robotOf(kArms);
  EXPECT_TRUE(says(errorOf([&] { joined({{"left", arms}, {"left", arms}}); }), "two robots have the name \"left\""));
  EXPECT_TRUE(says(errorOf([&] { joined({{"a/b", arms}}); }), "\"a/b\" has a slash"));
  EXPECT_TRUE(says(errorOf([&] { joined({{"", arms}}); }), "empty name"));
  EXPECT_TRUE(says(errorOf([&] { joined({}); }), "no robot"));
  EXPECT_TRUE(says(errorOf([&] { joined({{"cell", twoArms()}}); }), "\"cell\" are several robots"));
}

TEST(JoinedRobots, TakeTheOptionsOfTheirOwnLinks) {
  ModelOptions options;
  options.link_padding = {{"right/finger", 0.02}};
  const RobotModel model = twoArms(options);
  const auto margin = [&](const std::string& link) {
    const Collision& collision = model.collisions[model.links[model.findLink(link)].collisions.front()];
    return model.pieces[collision.pieces.front()].shape.margin();
  };
  EXPECT_DOUBLE_EQ(margin("right/finger") - margin("left/finger"), 0.02);
  options.link_padding = {{"finger", 0.02}};
  EXPECT_TRUE(says(errorOf([&] { twoArms(options); }), "padding: no link \"finger\""));
  options.link_padding = {{"right/fingr", 0.02}};
  EXPECT_TRUE(says(errorOf([&] { twoArms(options); }), "\"fingr\" (did you mean \"finger\"?)"));
}

TEST(JoinedRobots, AreNamedInErrorsAndWarnings) {
  EXPECT_TRUE(says(errorOf([] {
                     loadRobots({{"left", kArms}, {"right", "<robot"}}, packageResolver({}));
                   }),
                   "robot \"right\": URDF"));
  const std::string odd = "<robot name='odd'><link name='l'/></robot>";
  const RobotModel model = loadRobots({{"left", kArms}, {"right", odd}}, packageResolver({}));
  ASSERT_EQ(model.warnings.size(), 1U);
  EXPECT_TRUE(says(model.warnings.front(), "robot \"right\": No link of the robot has collision geometry"));
}

// --- the pairs

PairReason reasonOf(const RobotModel& model, const PairTable& table, const std::string& a, const std::string& b) {
  return table.pairs.at(table.find(model.findLink(a), model.findLink(b))).reason;
}

TEST(PairsOfJoinedRobots, AreThoseOfEachRobotAndAllBetweenThem) {
  const RobotModel alone = robotOf(kArms), model = twoArms();
  const PairTable of_left = filterPairs(alone, kSrdf), of_right = filterPairs(alone, "");
  const PairTable table = filterPairs(model, Srdfs{kSrdf, ""});
  const int links = static_cast<int>(alone.links.size());
  std::size_t between = 0;
  for (const LinkPair& pair : table.pairs) {
    if (pair.link_a < links && pair.link_b >= links) {
      EXPECT_EQ(pair.reason, PairReason::Checked);
      ++between;
      continue;
    }
    const PairTable& own = pair.link_a < links ? of_left : of_right;
    const LinkPair& single = own.pairs.at(own.find(pair.link_a % links, pair.link_b % links));
    EXPECT_EQ(pair.reason, single.reason);
    EXPECT_EQ(pair.detail, single.detail);
  }
  EXPECT_EQ(between, 25U);
  EXPECT_EQ(table.checked.size(), of_left.checked.size() + of_right.checked.size() + 25U);
  EXPECT_EQ(reasonOf(model, table, "left/base", "left/fore"), PairReason::SrdfDisabled);
  EXPECT_EQ(reasonOf(model, table, "right/base", "right/fore"), PairReason::Checked);
}

TEST(PairsOfJoinedRobots, AreCheckedBetweenThemAlsoWhereAnSrdfDisablesALinkByDefault) {
  const RobotModel model = twoArms();
  const PairTable table =
      filterPairs(model, Srdfs{"<robot name='arms'><disable_default_collisions link='finger'/></robot>", ""});
  EXPECT_EQ(reasonOf(model, table, "left/finger", "left/base"), PairReason::SrdfDisabled);
  EXPECT_EQ(reasonOf(model, table, "left/finger", "right/base"), PairReason::Checked);
  EXPECT_EQ(reasonOf(model, table, "left/finger", "right/finger"), PairReason::Checked);
}

TEST(PairsOfJoinedRobots, AreLeftOutByTheirWholeNames) {
  const RobotModel model = twoArms();
  PairFilterOptions options;
  options.exclude_pairs = {{"right/base", "left/base"}};
  const PairTable table = filterPairs(model, Srdfs{"", ""}, options);
  EXPECT_EQ(reasonOf(model, table, "left/base", "right/base"), PairReason::ConfigExcluded);
  EXPECT_EQ(reasonOf(model, table, "left/base", "right/upper"), PairReason::Checked);
  options.exclude_pairs = {{"base", "left/base"}};
  EXPECT_TRUE(says(errorOf([&] { filterPairs(model, Srdfs{"", ""}, options); }), "exclude_pairs: no link \"base\""));
}

TEST(PairsOfJoinedRobots, AreThoseOfTheGroupOfOneRobot) {
  const RobotModel model = twoArms();
  PairFilterOptions options;
  options.group = "left/hand";
  const PairTable table = filterPairs(model, Srdfs{kSrdf, kSrdf}, options);
  EXPECT_EQ(reasonOf(model, table, "left/finger", "right/base"), PairReason::Checked);
  EXPECT_EQ(reasonOf(model, table, "right/finger", "right/base"), PairReason::NotInGroup);
  options.group = "hand";
  EXPECT_TRUE(says(errorOf([&] { filterPairs(model, Srdfs{kSrdf, kSrdf}, options); }), "no group \"hand\""));
}

TEST(PairsOfJoinedRobots, NameTheRobotOfAWrongSrdf) {
  const RobotModel model = twoArms();
  const PairTable table = filterPairs(model, Srdfs{kSrdf, "<robot name='legs'/>"});
  const auto names_it = [](const std::string& text) {
    return says(text, "robot \"right\": The SRDF is for the robot \"legs\"");
  };
  EXPECT_EQ(std::count_if(table.warnings.begin(), table.warnings.end(), names_it), 1);
  EXPECT_TRUE(says(errorOf([&] { filterPairs(model, Srdfs{kSrdf, "<robot"}); }), "robot \"right\": SRDF"));
  EXPECT_TRUE(says(errorOf([&] { filterPairs(model, kSrdf); }), "1 SRDFs for 2 robots"));
}

// --- their distances

struct Placed {
  std::vector<double> positions;
  Isometry3d root;
};

Placed randomly(const RobotModel& robot, Chance& chance) {
  Placed placed{std::vector<double>(robot.joints.size()), chance.pose(0.6)};
  for (double& position : placed.positions) position = chance.between(-3.1, 3.1);
  return placed;
}

BodyPoses posesAt(const RobotModel& robot, const Placed& placed) {
  return placedAt(robot, forwardKinematics(robot, placed.positions), {placed.root});
}

bool isSame(const narrowphase::SignedDistance& a, const narrowphase::SignedDistance& b) {
  return a.status == b.status && a.distance == b.distance && a.lower_bound == b.lower_bound &&
         a.upper_bound == b.upper_bound && a.point_a == b.point_a && a.point_b == b.point_b && a.normal == b.normal;
}

/// One robot alone, and the two as one, in the same places.
class DistancesOfJoinedRobots : public testing::Test {
 protected:
  void put(const Placed& left, const Placed& right) {
    left_poses_ = posesAt(alone_->robot, left);
    right_poses_ = posesAt(alone_->robot, right);
    left_.update(left_poses_);
    right_.update(right_poses_);
    std::vector<double> positions = left.positions;
    positions.insert(positions.end(), right.positions.begin(), right.positions.end());
    both_.update(placedAt(model_->robot, forwardKinematics(model_->robot, positions), {left.root, right.root}));
  }

  /// The smallest distance of two pieces: the pieces are convex, so their narrowphase distance is exact where apart.
  double between(int link_of_left, int link_of_right) const {
    double smallest = std::numeric_limits<double>::infinity();
    const RobotModel& robot = alone_->robot;
    for (const Piece& a : robot.pieces) {
      for (const Piece& b : robot.pieces) {
        const int link_a = robot.collisions[a.collision].link, link_b = robot.collisions[b.collision].link;
        if (link_a != link_of_left || link_b != link_of_right) continue;
        const Isometry3d pose_a = *left_poses_[robot.links[link_a].body] * a.body_T_piece;
        const Isometry3d pose_b = *right_poses_[robot.links[link_b].body] * b.body_T_piece;
        smallest =
            std::min(smallest, narrowphase::signedDistance(a.shape, b.shape, pose_a.inverse() * pose_b).distance);
      }
    }
    return smallest;
  }

  const std::shared_ptr<const SceneModel> alone_ =
      std::make_shared<const SceneModel>(makeSceneModel(robotOf(kArms), kSrdf));
  const std::shared_ptr<const SceneModel> model_ =
      std::make_shared<const SceneModel>(makeSceneModel(twoArms(), Srdfs{kSrdf, kSrdf}));
  const int links_ = static_cast<int>(alone_->robot.links.size());
  PosedScene left_{alone_}, right_{alone_}, both_{model_};
  BodyPoses left_poses_, right_poses_;
};

TEST_F(DistancesOfJoinedRobots, AreInEachRobotThoseOfTheRobotAloneBitForBit) {
  Chance chance(11);
  int overlaps = 0, compared = 0;
  for (int state = 0; state < 300; ++state) {
    put(randomly(alone_->robot, chance), randomly(alone_->robot, chance));
    for (const PairProximity& pair : both_.all(both_.candidates())) {
      const bool of_left = pair.asked.b.link() < links_, of_right = pair.asked.a.link() >= links_;
      if (!of_left && !of_right) continue;
      PosedScene& single = of_left ? left_ : right_;
      const int first = of_left ? 0 : links_;
      const PairProximity own = single.proximity({{pair.asked.a.link() - first}, {pair.asked.b.link() - first}});
      EXPECT_TRUE(isSame(pair.result, own.result)) << "state " << state;
      overlaps += pair.result.distance < 0.0;
      ++compared;
    }
  }
  EXPECT_GT(overlaps, 30);
  EXPECT_GT(compared, 1000);
}

TEST_F(DistancesOfJoinedRobots, AreBetweenThemThoseOfTheirPieces) {
  Chance chance(12);
  int overlaps = 0, apart = 0;
  for (int state = 0; state < 300; ++state) {
    put(randomly(alone_->robot, chance), randomly(alone_->robot, chance));
    double smallest = std::numeric_limits<double>::infinity();
    for (const PairProximity& pair : both_.all(both_.candidates())) {
      smallest = std::min(smallest, pair.result.distance);
      if (pair.asked.a.link() >= links_ || pair.asked.b.link() < links_) continue;
      EXPECT_NEAR(pair.result.distance, between(pair.asked.a.link(), pair.asked.b.link() - links_), 1e-8);
      (pair.result.distance < 0.0 ? overlaps : apart) += 1;
    }
    EXPECT_DOUBLE_EQ(both_.minimum(both_.candidates())->result.distance, smallest);
  }
  EXPECT_GT(overlaps, 200);
  EXPECT_GT(apart, 3000);
}

TEST_F(DistancesOfJoinedRobots, AreUnknownWhereOneOfThemHasNoPlace) {
  Chance chance(13);
  const Placed left = randomly(alone_->robot, chance);
  put(left, left);
  const std::vector<double> zero(model_->robot.joints.size(), 0.0);
  both_.update(placedAt(model_->robot, forwardKinematics(model_->robot, zero), {left.root, std::nullopt}));
  for (const PairProximity& pair : both_.all(both_.candidates())) {
    const bool is_of_left = pair.asked.b.link() < links_;
    EXPECT_EQ(pair.result.status == narrowphase::Status::Unknown, !is_of_left);
  }
}

}  // namespace proximity_server::scene::joined_robots_test
