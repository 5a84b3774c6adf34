#include <proximity_server/ApplyObjects.h>
#include <proximity_server/Clearance.h>
#include <proximity_server/FirstContact.h>
#include <proximity_server/MinimumDistance.h>
#include <proximity_server/ModelInfo.h>
#include <proximity_server/QueryConfiguration.h>
#include <proximity_server/QueryPairs.h>
#include <proximity_server/QueryTrajectory.h>
#include "node/answers.h"
#include "node/diagnosis.h"
#include "node/gantry.h"
#include "node/joint_states.h"
#include "node/object_messages.h"
#include "node/settings.h"
#include "node/state_publisher.h"

#include <sensor_msgs/JointState.h>
#include <std_msgs/Float64.h>
#include <std_srvs/Trigger.h>
#include <visualization_msgs/MarkerArray.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <string>

// Two robots of gantry.urdf in one node. The left one stands in the origin of the world, the right one at (2, 0, 0) and
// turned by half a turn about z, so that its ball at x is at (2 - x, 0, 0): the balls of radius 0.1 are 2 - 0.7 - 0.8 =
// 0.5 m apart, less their radii.

namespace proximity_server::node::several_robots_test {

constexpr double kLeft = 0.7, kRight = 0.8;  // [m] x of the balls
constexpr double kApart = 0.3;               // [m] the distance of the balls
constexpr double kVelocity = 0.1;            // [m/s] of each ball, in the joint states

// The transforms of the robots' bases are in double precision, but go through quaternions.
constexpr double kOfTf = 1e-8;  // [m]

const std::string kNode = "/proximity_server/";

geometry_msgs::TransformStamped placeOf(const std::string& frame, const std::string& parent, double x) {
  geometry_msgs::TransformStamped place;
  place.header.stamp = ros::Time::now();
  place.header.frame_id = parent;
  place.child_frame_id = frame;
  place.transform.translation.x = x;
  place.transform.rotation.w = 1.0;
  return place;
}

/// Half a turn about z.
geometry_msgs::TransformStamped turned(geometry_msgs::TransformStamped place) {
  place.transform.rotation.w = 0.0;
  place.transform.rotation.z = 1.0;
  return place;
}

/// Publishes joint states and the static places of the robots.
class Robots {
 public:
  Robots() {
    left_.hold(slidingAt(kVelocity), positionsAt(kLeft));
    right_.hold(slidingAt(kVelocity), positionsAt(kRight));
    third_.hold(slidingAt(kVelocity), positionsAt(kRight));
    tf2_msgs::TFMessage message;
    // A chain: the right robot stands on a plate.
    message.transforms = {placeOf("left/base", "world", 0.0), placeOf("plate", "world", 2.0),
                          turned(placeOf("right/base", "plate", 0.0))};
    static_.publish(message);
  }

 private:
  JointStates left_{"/left"}, right_{"/right"}, third_{"/third"};
  ros::Publisher static_ = ros::NodeHandle().advertise<tf2_msgs::TFMessage>("/tf_static", 1, /*latch=*/true);
};

bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

class SeveralRobotsOfANode : public testing::Test {
 protected:
  void SetUp() override {
    if (!statePublisherKnowsPrefixes()) GTEST_SKIP() << kStatePublisherWithoutPrefixes;
    static const Robots robots;
  }

  template <class Accept>
  static std::optional<Clearance> clearance(const std::string& node, Accept accept) {
    Inbox<Clearance> inbox(ros::NodeHandle(), node + "clearance");
    return inbox.next(accept);
  }
  static std::optional<Clearance> validClearance(const std::string& node = kNode) {
    return clearance(node, [](const Clearance& message) { return message.level != Clearance::INVALID; });
  }

  /// Waits until the node knows all transforms.
  static void awaitPoses() { ASSERT_TRUE(validClearance()); }
};

std::set<std::string> robotsOf(const Proximity& pair) { return {pair.a.robot, pair.b.robot}; }

MinimumDistanceRequest between(const std::string& a, const std::string& b) {
  return node::between<MinimumDistanceRequest>(a, b);
}

TEST_F(SeveralRobotsOfANode, AreCheckedAgainstEachOtherInTheReferenceFrame) {
  const auto message = validClearance();
  ASSERT_TRUE(message);
  EXPECT_EQ(message->header.frame_id, "world");
  EXPECT_EQ(message->level, Clearance::CLEAR);
  EXPECT_EQ(links(message->minimum), (std::set<std::string>{"left/ball", "right/ball"}));
  EXPECT_EQ(robotsOf(message->minimum), (std::set<std::string>{"left", "right"}));
  EXPECT_NEAR(message->minimum.distance, kApart, kOfTf);
  const bool left_first = message->minimum.a.robot == "left";
  expectNear(left_first ? message->minimum.point_a : message->minimum.point_b, 0.8, 0.0, 0.0, kOfTf);
  expectNear(left_first ? message->minimum.point_b : message->minimum.point_a, 1.1, 0.0, 0.0, kOfTf);
  // Two neighbours of each robot are not checked.
  EXPECT_EQ(message->pairs_total, 15U);
  EXPECT_EQ(message->pairs_filtered, 2U);
}

TEST_F(SeveralRobotsOfANode, AreNamedInRequests) {
  awaitPoses();
  const auto across = call<MinimumDistanceResponse>(kNode + "minimum_distance", between("left/base", "right/ball"));
  ASSERT_TRUE(across.success) << across.status.message;
  EXPECT_NEAR(across.pair.distance, 1.0, kOfTf);  // from 0.1 to 1.1
  const auto within = call<MinimumDistanceResponse>(kNode + "minimum_distance", between("right/base", "right/ball"));
  ASSERT_TRUE(within.success) << within.status.message;
  EXPECT_NEAR(within.pair.distance, kRight - 0.2, kOfTf);
  expectNear(within.pair.point_b_link, 0.0, 0.1, 0.0, kOfTf);  // its frame is turned by a quarter about z
  expectRefusal(call<MinimumDistanceResponse>(kNode + "minimum_distance", between("ball", "right/ball")),
                QueryStatus::UNKNOWN_LINK, "'ball'");
}

TEST_F(SeveralRobotsOfANode, StandAsInTfWhenARequestGivesPositions) {
  awaitPoses();
  for (const std::uint8_t missing : {QueryConfigurationRequest::FROM_TF, QueryConfigurationRequest::ZERO}) {
    QueryConfigurationRequest request;
    request.a = {shape("left/ball")};
    request.b = {shape("right/ball")};
    request.mode = QueryConfigurationRequest::PER_PAIR;
    request.missing_joints = missing;
    request.states.resize(1);
    request.states[0].name = {"left/x_axis"};
    request.states[0].position = {1.0};
    const auto response = call<QueryConfigurationResponse>(kNode + "query_configuration", request);
    ASSERT_TRUE(response.success) << response.status.message;
    const double right = missing == QueryConfigurationRequest::FROM_TF ? kRight : 0.0;
    EXPECT_NEAR(response.states[0].pairs[0].distance, 2.0 - right - 1.0 - 0.2, kOfTf);
  }
}

TEST_F(SeveralRobotsOfANode, MeetWhenBothOfThemMove) {
  awaitPoses();
  FirstContactRequest request;
  request.joints.name = {"left/x_axis", "right/x_axis"};
  request.joints.velocity = {1.0, 1.0};
  request.horizon = 1.0;
  const auto response = call<FirstContactResponse>(kNode + "time_of_contact", request);
  ASSERT_TRUE(response.success) << response.status.message;
  ASSERT_TRUE(response.contact);
  EXPECT_NEAR(response.t_contact, 0.15, 1e-5);
  EXPECT_NEAR(response.pair.point_a.x, kLeft + 0.1 + 0.15, 1e-5);

  QueryTrajectoryRequest along;
  along.trajectory.joint_names = {"right/x_axis"};
  along.trajectory.points.resize(2);
  along.trajectory.points[0].positions = {0.8};
  along.trajectory.points[1].positions = {1.8};
  along.trajectory.points[1].time_from_start = ros::Duration(1.0);
  const auto found = call<QueryTrajectoryResponse>(kNode + "query_trajectory", along);
  ASSERT_TRUE(found.success) << found.status.message;
  EXPECT_NEAR(found.t_contact, 0.3, 1e-5);
}

TEST_F(SeveralRobotsOfANode, AreAheadOfContactByTheVelocitiesOfTheirOwnTopics) {
  const auto message =
      clearance(kNode, [](const Clearance& candidate) { return candidate.lookahead.state == Lookahead::CONTACT; });
  ASSERT_TRUE(message);
  EXPECT_NEAR(message->lookahead.time_to_contact, (kApart - 0.02) / (2.0 * kVelocity), 1e-4);
  EXPECT_EQ(robotsOf(message->lookahead.pair), (std::set<std::string>{"left", "right"}));
}

// The balls come nearer by x of both.
TEST_F(SeveralRobotsOfANode, HaveGradientsByTheJointsOfBoth) {
  QueryPairsRequest request;
  request.a = {shape("left/ball")};
  request.b = {shape("right/ball")};
  request.want_gradient = true;
  const auto response = call<QueryPairsResponse>(kNode + "query_pairs", request);
  ASSERT_TRUE(response.success) << response.status.message;
  EXPECT_EQ(response.joint_names, (std::vector<std::string>{"left/lift", "left/x_axis", "left/y_axis", "right/lift",
                                                            "right/x_axis", "right/y_axis"}));
  const std::vector<double> expected{0.0, -1.0, 0.0, 0.0, -1.0, 0.0};
  ASSERT_EQ(response.minimum.gradient.size(), expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i) EXPECT_NEAR(response.minimum.gradient[i], expected[i], kOfTf) << i;
}

// They come nearer by 0.2 m/s, and have 0.28 m: both may go on at their velocities only if they can stop in that. They
// brake with 0.05 m/s^2 each, which takes 0.2 m.
TEST_F(SeveralRobotsOfANode, AreSlowedByTheVelocitiesOfTheirOwnTopics) {
  Inbox<std_msgs::Float64> scales(ros::NodeHandle(), kNode + "collision_velocity_scale");
  // The age of the poses is part of the latency: on a busy machine, where it is above 0.3 s, they are slowed at once.
  EXPECT_TRUE(scales.next([](const std_msgs::Float64& message) { return message.data == 1.0; }));
  set(kNode, "stop_latency", 1.0);
  const double largest = (-0.2 + std::sqrt(0.04 + 4.0 * 0.2 * 0.28)) / 0.4 + 1e-6;  // 0.2 s + 0.2 s^2 = 0.28
  // 0 is also the answer of a search that got no time. Scales of cycles before the change may still arrive.
  const auto isSlowed = [&](const std_msgs::Float64& message) { return message.data > 0.0 && message.data <= largest; };
  EXPECT_TRUE(scales.next(isSlowed));
  const auto slowed = scales.next([](const std_msgs::Float64& message) { return message.data > 0.0; });
  ASSERT_TRUE(slowed);
  EXPECT_LE(slowed->data, largest) << "and stay so";
}

/// Names a joint of each robot that moves, and all others, on the topic of both.
sensor_msgs::JointState velocitiesOf(const std::vector<std::string>& prefixes) {
  sensor_msgs::JointState state;
  state.header.stamp = ros::Time::now();
  for (const std::string& prefix : prefixes) {
    for (const char* joint : {"x_axis", "y_axis", "lift"}) {
      state.name.push_back(prefix + joint);
      state.velocity.push_back(state.name.back() == prefix + "x_axis" ? kVelocity : 0.0);
    }
  }
  return state;
}

TEST_F(SeveralRobotsOfANode, AreToldApartOnOneTopicByTheirNamesOnly) {
  ros::Publisher both = ros::NodeHandle().advertise<sensor_msgs::JointState>("/joint_states", 10);
  // Names without a robot could be of either, and the velocities of the left robot are not those of the right one.
  const auto unnamed = clearance("/on_one_topic/", [&](const Clearance& candidate) {
    both.publish(velocitiesOf({"", "left/"}));
    return contains(candidate.lookahead.status.message, "joint 'right/");
  });
  ASSERT_TRUE(unnamed);
  EXPECT_EQ(unnamed->lookahead.status.code, QueryStatus::NO_VELOCITY);
  const auto named = clearance("/on_one_topic/", [&](const Clearance& candidate) {
    both.publish(velocitiesOf({"left/", "right/"}));
    return candidate.lookahead.state == Lookahead::CONTACT;
  });
  ASSERT_TRUE(named);
  EXPECT_NEAR(named->lookahead.time_to_contact, (kApart - 0.02) / (2.0 * kVelocity), 1e-4);
}

TEST_F(SeveralRobotsOfANode, CarryObjects) {
  awaitPoses();
  ObjectChange rod = addBall("rod");
  rod.header.frame_id = rod.link = "right/ball";
  rod.primitives[0].dimensions = {0.15};
  const auto added = call<ApplyObjectsResponse>(kNode + "apply_objects", requestOf({rod}));
  ASSERT_TRUE(added.success) << added.status.message;
  const auto response = call<MinimumDistanceResponse>(kNode + "minimum_distance", between("left/ball", "rod"));
  ASSERT_TRUE(response.success) << response.status.message;
  EXPECT_NEAR(response.pair.distance, kApart - 0.05, kOfTf);
  EXPECT_EQ(response.pair.b.robot, "right");
  const auto remove = requestOf({change(ObjectChange::REMOVE, "rod")});
  EXPECT_TRUE(call<ApplyObjectsResponse>(kNode + "apply_objects", remove).success);
}

TEST_F(SeveralRobotsOfANode, AreDescribedAndDrawnInTheirFrames) {
  Inbox<ModelInfo> infos(ros::NodeHandle(), kNode + "model_info");
  const auto info = infos.next();
  ASSERT_TRUE(info);
  EXPECT_EQ(info->robot, "left (gantry), right (gantry)");
  EXPECT_EQ(info->links.size(), 10U);
  EXPECT_EQ(info->links.back().name.rfind("right/", 0), 0U);

  using visualization_msgs::MarkerArray;
  Inbox<MarkerArray> inbox(ros::NodeHandle(), kNode + "markers");
  const auto pieces = inbox.next(
      [](const MarkerArray& array) { return !array.markers.empty() && array.markers.front().ns == "pieces"; });
  ASSERT_TRUE(pieces);
  std::set<std::string> frames;
  for (const auto& marker : pieces->markers) frames.insert(marker.header.frame_id);
  EXPECT_EQ(frames,
            (std::set<std::string>{"left/ball", "left/base", "left/block", "right/ball", "right/base", "right/block"}));
}

TEST_F(SeveralRobotsOfANode, StayWhenAReloadFails) {
  awaitPoses();
  std::string description;
  ASSERT_TRUE(ros::param::get(kNode + "robots/right/description", description));
  ros::param::set(kNode + "robots/right/description", "/nowhere");
  const auto failed = call<std_srvs::TriggerResponse>(kNode + "reload", std_srvs::TriggerRequest());
  EXPECT_FALSE(failed.success);
  EXPECT_TRUE(contains(failed.message, "'/nowhere', which robots/right/description names")) << failed.message;
  EXPECT_TRUE(validClearance());
  ros::param::set(kNode + "robots/right/description", description);
  const auto loaded = call<std_srvs::TriggerResponse>(kNode + "reload", std_srvs::TriggerRequest());
  EXPECT_TRUE(loaded.success) << loaded.message;
  const auto message = validClearance();
  ASSERT_TRUE(message);
  EXPECT_NEAR(message->minimum.distance, kApart, kOfTf);
}

// ---- a base of which tf knows nothing

TEST_F(SeveralRobotsOfANode, AreInvalidWhereABaseIsMissingAndNamed) {
  const std::string frame = "frame 'third/base' of robot 'third' in 'world'";
  const auto message = clearance("/unplaced/", [&](const Clearance& candidate) {
    return contains(candidate.status.message, frame) && candidate.pairs_unknown == 11;
  });
  ASSERT_TRUE(message);  // 9 pairs between the two, and the 2 of the third robot
  EXPECT_EQ(message->level, Clearance::INVALID);
  EXPECT_EQ(message->status.code, QueryStatus::TF_UNAVAILABLE);
  EXPECT_TRUE(Diagnosis("unplaced: tf").next([&](const auto& status) { return contains(status.message, frame); }));
}

TEST_F(SeveralRobotsOfANode, AnswerForTheRobotWhoseBaseIsKnown) {
  awaitPoses();
  const auto known = call<MinimumDistanceResponse>("/unplaced/minimum_distance", between("left/base", "left/ball"));
  ASSERT_TRUE(known.success) << known.status.message;
  EXPECT_NEAR(known.pair.distance, kLeft - 0.2, kOfTf);
  expectRefusal(call<MinimumDistanceResponse>("/unplaced/minimum_distance", between("left/base", "third/ball")),
                QueryStatus::TF_UNAVAILABLE, "frame 'third/base' of robot 'third'");
}

// ---- a base that moves

/// Plays a robot with the prefix "cart", whose base is on /tf.
class Cart {
 public:
  Cart() : publisher_(ros::NodeHandle().advertise<tf2_msgs::TFMessage>("/tf", 100)) {}

  void publish(const ros::Time& joints, const ros::Time& base) {
    tf2_msgs::TFMessage message;
    message.transforms = {placeOf("cart/base", "world", 3.0), placeOf("cart/slide", "cart/base", 0.5),
                          placeOf("cart/ball", "cart/slide", 0.0), placeOf("cart/post", "cart/base", 0.0)};
    for (auto& transform : message.transforms) transform.header.stamp = joints;
    message.transforms[0].header.stamp = base;
    publisher_.publish(message);
  }

 private:
  ros::Publisher publisher_;
};

TEST_F(SeveralRobotsOfANode, AreStaleWithTheirBase) {
  Cart cart;
  const ros::Time old = ros::Time::now() - ros::Duration(5.0);
  const auto message = clearance("/on_a_cart/", [&](const Clearance& candidate) {
    cart.publish(ros::Time::now(), old);
    return candidate.status.code == QueryStatus::TF_STALE;
  });
  ASSERT_TRUE(message);
  EXPECT_EQ(message->level, Clearance::INVALID);
  EXPECT_TRUE(contains(message->status.message, "frame 'cart/base' of robot 'on_cart' in 'left/base'"))
      << message->status.message;
}

TEST_F(SeveralRobotsOfANode, LookNotAheadWhereABaseMayMove) {
  Cart cart;
  const auto message = clearance("/on_a_cart/", [&](const Clearance& candidate) {
    cart.publish(ros::Time::now(), ros::Time::now());
    return candidate.level != Clearance::INVALID && candidate.lookahead.status.code == QueryStatus::NO_VELOCITY &&
           contains(candidate.lookahead.status.message, "robot 'on_cart'");
  });
  ASSERT_TRUE(message);
  EXPECT_EQ(message->header.frame_id, "left/base");
  EXPECT_EQ(message->lookahead.state, Lookahead::UNKNOWN);
  EXPECT_TRUE(contains(message->lookahead.status.message, "its base 'cart/base' may move against 'left/base'"))
      << message->lookahead.status.message;
}

TEST_F(SeveralRobotsOfANode, HaveTheScaleZeroWhereABaseMayMove) {
  Cart cart;
  Inbox<std_msgs::Float64> scales(ros::NodeHandle(), "/on_a_cart/collision_velocity_scale");
  ASSERT_TRUE(clearance("/on_a_cart/", [&](const Clearance& candidate) {
    cart.publish(ros::Time::now(), ros::Time::now());
    return candidate.level != Clearance::INVALID && contains(candidate.lookahead.status.message, "robot 'on_cart'");
  }));
  scales.clear();
  for (int i = 0; i < 5; ++i) {
    cart.publish(ros::Time::now(), ros::Time::now());
    const auto message = scales.next();
    ASSERT_TRUE(message);
    EXPECT_EQ(message->data, 0.0);
  }
}

// The table is far from the robot, and the joints do not move towards it.
TEST_F(SeveralRobotsOfANode, LookNotAheadToFixedObjectsWhereTheBaseOfTheOnlyOneMayMove) {
  Cart cart;
  const auto withState = [&](std::uint8_t state) {
    return clearance("/alone_on_a_cart/", [&](const Clearance& candidate) {
      cart.publish(ros::Time::now(), ros::Time::now());
      return candidate.level != Clearance::INVALID && candidate.lookahead.state == state;
    });
  };
  EXPECT_TRUE(withState(Lookahead::FREE)) << "of itself";
  const auto table = requestOf({addBall("table", poseAt(0.0, 10.0, 0.0))});
  const auto added = call<ApplyObjectsResponse>("/alone_on_a_cart/apply_objects", table);
  ASSERT_TRUE(added.success) << added.status.message;
  const auto message = withState(Lookahead::UNKNOWN);
  ASSERT_TRUE(message);
  EXPECT_EQ(message->lookahead.status.code, QueryStatus::NO_VELOCITY);
  EXPECT_TRUE(contains(message->lookahead.status.message, "the robot: its base 'cart/base' may move against 'world'"))
      << message->lookahead.status.message;
}

}  // namespace proximity_server::node::several_robots_test
