#include <proximity_server/Clearance.h>
#include <proximity_server/FirstContact.h>
#include <proximity_server/MinimumDistance.h>
#include <proximity_server/ModelInfo.h>
#include <proximity_server/PenetrationDepth.h>
#include <proximity_server/ProveJointBox.h>
#include <proximity_server/QueryConfiguration.h>
#include <proximity_server/QueryPairs.h>
#include <proximity_server/QueryTrajectory.h>
#include <proximity_server/SeparationAxis.h>
#include "node/answers.h"
#include "node/gantry.h"

#include <std_srvs/Trigger.h>

#include <array>
#include <thread>

// These tests call the services through ROS. More questions about their answers are in the tests beside their sources,
// which need no ROS. Every expected number is read off gantry.urdf: with the ball at (0.5, 0, 0) it is 0.3 m from the base.

namespace proximity_server::node::services_test {

const std::string kNode = "/proximity_server/";

Gantry& gantry() { return connectedGantry(1); }

MinimumDistanceResponse ask(const MinimumDistanceRequest& request) {
  return call<MinimumDistanceResponse>(kNode + "minimum_distance", request);
}

// ---- one example of each

/// A request about the base and the ball.
template <class Service>
typename Service::Request aboutTheBall() {
  return between<typename Service::Request>("base", "ball", gantry().moveTo({0.5, 0.0, 0.0}));
}

/// The answer of a service that exists, about the poses of the stamp.
template <class Service>
typename Service::Response askedByName(const std::string& name, const typename Service::Request& request) {
  const auto response = call<typename Service::Response>(kNode + name, request);
  EXPECT_TRUE(response.success) << response.status.message;
  EXPECT_EQ(response.header.stamp, request.stamp);
  EXPECT_EQ(response.header.frame_id, "base");
  return response;
}

TEST(Services, TellTheDistance) {
  const auto response = askedByName<MinimumDistance>("minimum_distance", aboutTheBall<MinimumDistance>());
  EXPECT_NEAR(response.pair.distance, 0.3, kTolerance);
}

TEST(Services, TellTheSeparationAxis) {
  const auto response = askedByName<SeparationAxis>("separation_axis", aboutTheBall<SeparationAxis>());
  expectNear(response.axis, 1.0, 0.0, 0.0);
}

TEST(Services, TellThePenetrationDepth) {
  const auto response = askedByName<PenetrationDepth>("penetration_depth", aboutTheBall<PenetrationDepth>());
  EXPECT_EQ(response.depth, 0.0);
}

TEST(Services, TellManyPairs) {
  QueryPairsRequest request;
  request.mode = QueryPairsRequest::PER_PAIR;
  request.stamp = gantry().moveTo({0.5, 0.0, 0.0});
  EXPECT_EQ(askedByName<QueryPairs>("query_pairs", request).pairs.size(), 2u);
}

TEST(Services, TellThePairsOfAnotherState) {
  QueryConfigurationRequest request;
  request.a = {shape("base")};
  request.b = {shape("ball")};
  request.states.resize(1);
  request.states[0].name = {"x_axis"};
  request.states[0].position = {0.9};
  request.stamp = gantry().moveTo({0.5, 0.0, 0.0});
  const auto response = askedByName<QueryConfiguration>("query_configuration", request);
  EXPECT_NEAR(response.states.at(0).minimum.distance, 0.7, kTolerance);
}

TEST(Services, TellTheTimeOfContact) {
  auto request = aboutTheBall<FirstContact>();
  request.horizon = 3.0;
  request.joints.name = {"x_axis"};
  request.joints.velocity = {-0.5};
  EXPECT_NEAR(askedByName<FirstContact>("time_of_contact", request).t_contact, 0.6, 1e-5);
}

TEST(Services, TellTheContactOnATrajectory) {
  auto request = aboutTheBall<QueryTrajectory>();
  request.trajectory.joint_names = {"x_axis"};
  request.trajectory.points.resize(2);
  request.trajectory.points[0].positions = {0.5};
  request.trajectory.points[1].positions = {0.0};
  request.trajectory.points[1].time_from_start = ros::Duration(1.0);
  EXPECT_NEAR(askedByName<QueryTrajectory>("query_trajectory", request).t_contact, 0.6, 1e-5);
}

TEST(Services, ProveThatABoxIsFree) {
  auto request = aboutTheBall<ProveJointBox>();
  request.box.resize(1);
  request.box[0].name = "x_axis";
  request.box[0].lower = 0.4;
  request.box[0].upper = 0.6;
  const auto response = askedByName<ProveJointBox>("prove_joint_box", request);
  EXPECT_TRUE(response.proven);
  EXPECT_NEAR(response.lower_bound, 0.2, kTolerance);
}

// ---- beside the monitor

TEST(Services, WithABadRequestDoNotDisturbTheMonitor) {
  Inbox<Clearance> clearance(ros::NodeHandle(), kNode + "clearance");
  const ros::Time stamp = gantry().moveTo({0.5, 0.0, 0.0});
  ASSERT_TRUE(clearance.next([&](const Clearance& message) { return message.header.stamp == stamp; }));
  ask(between<MinimumDistanceRequest>("no such link", "ball", stamp));
  clearance.clear();
  const auto after = clearance.next();
  ASSERT_TRUE(after);
  EXPECT_EQ(after->status.code, QueryStatus::OK);
  EXPECT_NEAR(after->minimum.distance, 0.3, kTolerance);
}

// ---- several clients

// Regression: of two requests at the same moment the one that had read the clock first could be overtaken, took that
// for a jump back of the clock, and all transforms were forgotten.
TEST(Clients, AtOnceEachGetTheirOwnAnswer) {
  const std::array<ros::Time, 2> stamps = {gantry().moveTo({0.5, 0.0, 0.0}), gantry().moveTo({0.7, 0.0, 0.0})};
  const std::array<double, 2> distances = {0.3, 0.5};
  const auto client = [&](std::size_t i) {
    for (int n = 0; n < 1000; ++n) {
      const auto response = ask(between<MinimumDistanceRequest>("base", "ball", stamps[i]));
      EXPECT_TRUE(response.success) << response.status.message;
      EXPECT_NEAR(response.pair.distance, distances[i], kTolerance);
    }
  };
  std::thread first(client, 0), second(client, 1);
  first.join();
  second.join();
}

// ---- reload

// reload_under_load_test replaces the model while clients ask.

/// Another robot_description as long as it lives.
class OtherRobot {
 public:
  explicit OtherRobot(const std::string& urdf) {
    ros::param::get("/robot_description", before_);
    ros::param::set("/robot_description", urdf);
  }
  ~OtherRobot() {
    ros::param::set("/robot_description", before_);
    EXPECT_TRUE(reload().success);
  }

  static std_srvs::TriggerResponse reload() {
    return call<std_srvs::TriggerResponse>(kNode + "reload", std_srvs::TriggerRequest());
  }

 private:
  std::string before_;
};

std::string gantryWith(const std::string& radius) {
  std::string urdf;
  ros::param::get("/robot_description", urdf);
  const std::string old = "radius=\"0.1\"";
  urdf.replace(urdf.find(old), old.size(), "radius=\"" + radius + "\"");
  return urdf;
}

/// The services answer so at once, and the monitor after two cycles, with the ball at (0.5, 0, 0).
void expectDistance(double distance) {
  Inbox<Clearance> inbox(ros::NodeHandle(), kNode + "clearance");
  ASSERT_TRUE(inbox.next());
  inbox.clear();
  const ros::Time stamp = gantry().moveTo({0.5, 0.0, 0.0});
  EXPECT_NEAR(ask(between<MinimumDistanceRequest>("base", "ball", stamp)).pair.distance, distance, kTolerance);
  ASSERT_TRUE(inbox.next() && inbox.next());
  const auto message = inbox.next();
  ASSERT_TRUE(message);
  EXPECT_NEAR(message->minimum.distance, distance, kTolerance);
}

TEST(Reload, TakesTheNewModel) {
  const OtherRobot robot(gantryWith("0.15"));
  const auto reloaded = OtherRobot::reload();
  ASSERT_TRUE(reloaded.success) << reloaded.message;
  expectDistance(0.25);
}

TEST(Reload, OfABrokenModelKeepsTheOldOneAndSaysWhy) {
  const OtherRobot robot(gantryWith("-1"));
  const auto reloaded = OtherRobot::reload();
  EXPECT_FALSE(reloaded.success);
  EXPECT_NE(reloaded.message.find("ball"), std::string::npos) << reloaded.message;
  expectDistance(0.3);
}

TEST(Reload, AnnouncesTheModelToThoseWhoComeLater) {
  Inbox<ModelInfo> inbox(ros::NodeHandle(), kNode + "model_info");
  const auto info = inbox.next();
  ASSERT_TRUE(info);
  EXPECT_EQ(info->robot, "gantry");
  EXPECT_EQ(info->header.frame_id, "base");
  EXPECT_EQ(info->links.size(), 5u);
  EXPECT_EQ(info->pairs.size(), 3u);
  EXPECT_EQ(info->pairs_checked, 2u);
  for (const PairInfo& pair : info->pairs) {
    const bool neighbours = pair.link_a != "ball" && pair.link_b != "ball";
    EXPECT_EQ(pair.checked, !neighbours) << pair.link_a << " " << pair.link_b << ": " << pair.reason;
  }
}

}  // namespace proximity_server::node::services_test
