// Proofs over boxes of joint positions. The robot is that of gantry.urdf: its ball of radius 0.1 slides along x and y, its
// base is a cube from -0.1 to 0.1, and its block has two cubes of edge 0.2 at (0, 1, lift) and (0, 1, lift + 0.5).
#include "node/answers.h"
#include "node/asked_robot.h"
#include "node/object_messages.h"
#include "node/services/queries.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

namespace proximity_server::node::proof_query_test {

JointInterval interval(const std::string& name, double lower, double upper) {
  JointInterval result;
  result.name = name;
  result.lower = lower;
  result.upper = upper;
  return result;
}

class Proof : public AskedGantry {
 protected:
  explicit Proof(const std::string& reference_frame = "") : AskedGantry(reference_frame, /*max_batch=*/100) {}

  static ProveJointBoxRequest within(const std::vector<JointInterval>& box, const std::string& a = "",
                                     const std::string& b = "") {
    auto request = between<ProveJointBoxRequest>(a, b);
    request.box = box;
    request.missing_joints = ProveJointBoxRequest::ZERO;
    return request;
  }
  void add(const std::vector<ObjectChange>& changes) {
    const ApplyObjectsResponse response = gantry_.ask(requestOf(changes));
    ASSERT_TRUE(response.success) << response.status.message;
  }
};

TEST_F(Proof, HoldsWhereThePairStaysApart) {
  const auto response = ask(within({interval("x_axis", 0.4, 0.6)}, "base", "ball"));
  ASSERT_TRUE(response.success) << response.status.message;
  EXPECT_TRUE(response.proven);
  ASSERT_EQ(response.pairs.size(), 1u);
  const PairProof& proof = response.pairs.front();
  EXPECT_EQ(proof.outcome, PairProof::PROVEN);
  EXPECT_EQ(proof.a.link, "base");
  EXPECT_EQ(proof.b.link, "ball");
  EXPECT_NEAR(proof.lower_bound, 0.2, 1e-9);  // sliding straight on, the bound is exact
  EXPECT_LE(proof.lower_bound, 0.2);
  EXPECT_EQ(response.lower_bound, proof.lower_bound);
  EXPECT_EQ(proof.closest.name, (std::vector<std::string>{"x_axis", "y_axis"}));
  EXPECT_NEAR(proof.closest_upper_bound, proof.closest.position.at(0) - 0.2, 1e-9);
  EXPECT_EQ(proof.undecided, 0.0);
  EXPECT_TRUE(proof.worst.empty());
}

TEST_F(Proof, IsRefutedByAStateInContact) {
  const auto response = ask(within({interval("x_axis", 0.0, 0.6), interval("y_axis", -0.1, 0.3)}, "base", "ball"));
  ASSERT_TRUE(response.success) << response.status.message;
  EXPECT_FALSE(response.proven);
  const PairProof& proof = response.pairs.at(0);
  ASSERT_EQ(proof.outcome, PairProof::REFUTED);
  QueryConfigurationRequest there;
  there.states = {proof.closest};
  there.missing_joints = QueryConfigurationRequest::ZERO;
  there.a = {shape("base")};
  there.b = {shape("ball")};
  EXPECT_LE(ask(there).states.at(0).minimum.upper_bound, 1e-6);
}

TEST_F(Proof, SaysWhatIsLeftWhenTheBudgetEnds) {
  // At the centre (0.5, 0.6) the two are a diagonal apart, which the box may lose.
  auto request = within({interval("x_axis", 0.0, 1.0), interval("y_axis", 0.21, 0.99)}, "base", "ball");
  request.most_boxes = 1;
  const auto response = ask(request);
  EXPECT_FALSE(response.success);
  EXPECT_FALSE(response.proven);
  EXPECT_EQ(response.status.code, QueryStatus::OVER_BUDGET);
  EXPECT_NE(response.status.message.find("1 of 1 pairs"), std::string::npos) << response.status.message;
  const PairProof& proof = response.pairs.at(0);
  EXPECT_EQ(proof.outcome, PairProof::UNDECIDED);
  EXPECT_EQ(proof.undecided, 1.0);
  ASSERT_EQ(proof.worst.size(), 2u);
  EXPECT_EQ(proof.worst[0].name, "x_axis");
  EXPECT_LT(proof.worst[0].lower, proof.worst[0].upper);
  request.most_boxes = 0;
  EXPECT_TRUE(ask(request).proven);
}

TEST_F(Proof, ListsTheWorstPairsFirst) {
  auto request = within({});
  request.missing_joints = ProveJointBoxRequest::WITHIN_LIMITS;
  const auto response = ask(request);
  ASSERT_TRUE(response.success) << response.status.message;
  EXPECT_FALSE(response.proven);
  ASSERT_EQ(response.pairs.size(), 2u) << "base and block are neighbours";
  for (const PairProof& proof : response.pairs) EXPECT_EQ(proof.outcome, PairProof::REFUTED);
  const auto apart = ask(within({interval("x_axis", 0.0, 1.0), interval("y_axis", 0.5, 0.5)}));
  ASSERT_EQ(apart.pairs.size(), 2u);
  EXPECT_TRUE(apart.proven);
  EXPECT_LE(apart.pairs[0].lower_bound, apart.pairs[1].lower_bound);
  EXPECT_EQ(apart.lower_bound, apart.pairs[0].lower_bound);
}

TEST_F(Proof, TakesTheOtherJointsFromTf) {
  auto request = within({}, "base", "ball");
  request.missing_joints = ProveJointBoxRequest::FROM_TF;
  request.stamp = moveTo({0.5, 0.0, 0.0});
  auto response = ask(request);
  ASSERT_TRUE(response.success) << response.status.message;
  EXPECT_EQ(response.header.stamp, request.stamp);
  EXPECT_NEAR(response.lower_bound, 0.3, 1e-9);
  moveTo({0.15, 0.0, 0.0});
  request.stamp = {};
  response = ask(request);
  EXPECT_EQ(response.pairs.at(0).outcome, PairProof::REFUTED);
  EXPECT_NEAR(response.pairs.at(0).closest.position.at(0), 0.15, 1e-9);
}

TEST_F(Proof, CountsTheContactDistance) {
  auto request = within({interval("x_axis", 0.4, 0.6)}, "base", "ball");
  request.contact_distance = 0.19;
  EXPECT_TRUE(ask(request).proven);
  request.contact_distance = 0.21;
  EXPECT_EQ(ask(request).pairs.at(0).outcome, PairProof::REFUTED);
}

TEST_F(Proof, CountsFlushFacesAsContact) {
  EXPECT_EQ(ask(within({interval("x_axis", 0.2, 0.6)}, "base", "ball")).pairs.at(0).outcome, PairProof::REFUTED);
}

TEST_F(Proof, KnowsObjects) {
  moveTo({1.0, 0.0, 0.0});
  add({addBall("part", poseAt(0.5, 0.5, 0.0)), addBallInFrame("held", "ball", poseAt(0.0, 0.0, 0.3))});
  // The ball passes "part" at a distance of 0.3; what moves with its frame never comes nearer to it.
  const auto passing = ask(within({interval("x_axis", 0.0, 1.0)}, "ball", "part"));
  ASSERT_TRUE(passing.success) << passing.status.message;
  EXPECT_TRUE(passing.proven);
  EXPECT_LE(passing.lower_bound, 0.3);
  EXPECT_EQ(passing.pairs.at(0).b.kind, ShapeRef::OBJECT);
  EXPECT_NEAR(ask(within({interval("x_axis", -1.0, 1.0)}, "ball", "held")).lower_bound, 0.1, 1e-9);
  const auto meeting = ask(within({interval("x_axis", 0.0, 1.0), interval("y_axis", 0.0, 1.0)}, "ball", "part"));
  EXPECT_EQ(meeting.pairs.at(0).outcome, PairProof::REFUTED);
  // All pairs: two of links, those of the links with "part", and those with "held".
  EXPECT_GT(ask(within({interval("x_axis", 0.9, 1.0)})).pairs.size(), 4u);
}

TEST_F(Proof, KnowsWhereTfHasTheFramesOfObjects) {
  const ros::Time stamp = moveTo({1.0, 0.0, 0.0});
  geometry_msgs::TransformStamped frame = Gantry::post({0.0, 0.0, 0.25});
  frame.child_frame_id = "belt";
  gantry_.publish({frame}, stamp);
  add({addBallInFrame("part", "belt", poseAt(0.5, 0.0, 0.25))});
  const auto response = ask(within({interval("x_axis", 0.4, 0.6)}, "ball", "part"));
  ASSERT_TRUE(response.success) << response.status.message;
  EXPECT_NEAR(response.pairs.at(0).closest_upper_bound, 0.3, 1e-9);
  EXPECT_TRUE(response.proven);
}

/// Fixed objects rest relative to the ball, whatever the joints do.
class ProofSeenFromTheBall : public Proof {
 protected:
  ProofSeenFromTheBall() : Proof("ball") {}
};

TEST_F(ProofSeenFromTheBall, ObjectsRestInTheReferenceFrame) {
  moveTo({1.0, 0.0, 0.0});
  add({addBall("part", poseAt(0.0, 0.0, 0.5))});
  EXPECT_EQ(ask(within({interval("x_axis", 0.1, 2.0)}, "block", "part")).header.frame_id, "ball");
  // The part is 0.5 m above the ball: 0.2 m beside the block at its nearest when the ball is at (0.4, 1, 0).
  const auto response = ask(within({interval("x_axis", 0.4, 2.0), interval("y_axis", 1.0, 1.0)}, "block", "part"));
  ASSERT_TRUE(response.success) << response.status.message;
  EXPECT_NEAR(response.lower_bound, 0.2, 1e-9);
  EXPECT_TRUE(response.proven);
}

/// The base stands in the world, 2 m above its origin.
class ProofInTheWorld : public Proof {
 protected:
  ProofInTheWorld() : Proof("world") {
    geometry_msgs::TransformStamped base = Gantry::post({0.0, 0.0, 2.0});
    base.header.frame_id = "world";
    base.child_frame_id = "base";
    gantry_.publish({base}, ros::Time(), TfTree::Kind::Static);
  }
};

TEST_F(ProofInTheWorld, ObjectsStandWhereTheWorldHasThem) {
  moveTo({1.0, 0.0, 0.0});
  add({addBall("part", poseAt(0.5, 0.0, 2.5))});
  const auto response = ask(within({interval("x_axis", 0.0, 1.0)}, "ball", "part"));
  ASSERT_TRUE(response.success) << response.status.message;
  EXPECT_NEAR(response.pairs.at(0).closest_upper_bound, 0.3, 1e-9);
  EXPECT_TRUE(response.proven);
}

/// Boxes and balls whose joint follows another one, or has more than one position.
class ProofOfFollowers : public testing::Test {
 protected:
  ProveJointBoxResponse ask(const std::string& a, const std::string& joint) {
    auto request = between<ProveJointBoxRequest>(a, "base");
    request.ignore_filter = true;  // all are neighbours of the base
    request.missing_joints = ProveJointBoxRequest::ZERO;
    request.box = {interval(joint, -0.1, 0.2)};
    return robot_.ask(request);
  }

  AskedRobot robot_{{robotText("followers.urdf"), ""}};
};

TEST_F(ProofOfFollowers, MovesAJointWithItsLeader) {
  const auto response = ask("shadow", "lead");  // at 0.5 + 2 x along y: 0.1 from the base at the nearest
  ASSERT_TRUE(response.success) << response.status.message;
  EXPECT_NEAR(response.lower_bound, 0.1, 1e-9);
  EXPECT_EQ(response.pairs.at(0).closest.name, (std::vector<std::string>{"lead"}));
}

TEST_F(ProofOfFollowers, NamesAJointWithoutAPositionOfItsOwn) {
  expectRefusal(ask("shadow", "follow"), QueryStatus::INVALID_ARGUMENT, "'follow' follows another one");
  expectRefusal(ask("drone", "flight"), QueryStatus::INVALID_ARGUMENT, "'flight'");
  expectRefusal(ask("drone", "lead"), QueryStatus::INVALID_ARGUMENT, "flight");
}

class ProofOfFewPairs : public AskedGantry {
 protected:
  ProofOfFewPairs() : AskedGantry("", /*max_batch=*/1) {}
};

TEST_F(ProofOfFewPairs, RefusesMorePairsThanMaxBatch) {
  ProveJointBoxRequest request;
  request.missing_joints = ProveJointBoxRequest::ZERO;
  expectRefusal(ask(request), QueryStatus::OVER_BUDGET, "max_batch is 1");
}

}  // namespace proximity_server::node::proof_query_test
