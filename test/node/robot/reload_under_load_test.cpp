// Eight clients that ask everything at once, while the monitors run and the model is replaced again and again: every
// answer is that of one model or of the other. ./dev test --sanitize thread looks for races in the nodes meanwhile.
#include <proximity_server/Clearance.h>
#include <proximity_server/FirstContact.h>
#include <proximity_server/MinimumDistance.h>
#include <proximity_server/PenetrationDepth.h>
#include <proximity_server/QueryConfiguration.h>
#include <proximity_server/QueryPairs.h>
#include <proximity_server/QueryTrajectory.h>
#include <proximity_server/SeparationAxis.h>
#include "from_environment.h"
#include "node/answers.h"
#include "node/gantry.h"
#include "node/joint_states.h"
#include "node/settings.h"

#include <sensor_msgs/JointState.h>
#include <std_srvs/SetBool.h>
#include <std_srvs/Trigger.h>
#include <visualization_msgs/MarkerArray.h>

#include <array>
#include <atomic>
#include <cmath>
#include <thread>
#include <vector>

namespace proximity_server::node::reload_under_load_test {

constexpr int kClients = 8;
constexpr double kMotionTolerance = 1e-6;           // [m] of the searches: the default of the requests
constexpr std::array<double, 2> kRadii{0.1, 0.15};  // [m] of the ball, in the two models
const std::string kNode = "/proximity_server/";

/// With the ball at (x, 0, 0): from the cube of edge 0.2 at the origin.
double ballFromBase(double x, double radius) { return x - 0.1 - radius; }

void expectOneOf(double value, const std::array<double, 2>& expected, double tolerance) {
  const double off = std::min(std::abs(value - expected[0]), std::abs(value - expected[1]));
  EXPECT_LE(off, tolerance) << value << " is neither " << expected[0] << " nor " << expected[1];
}

void expectDistance(const Proximity& pair, double x) {
  expectOneOf(pair.distance, {ballFromBase(x, kRadii[0]), ballFromBase(x, kRadii[1])}, kTolerance);
  EXPECT_EQ(links(pair), (std::set<std::string>{"base", "ball"}));
}

/// The ball slides towards the base, from x, at this speed.
template <class Response>
void expectContact(const Response& response, double x, double speed) {
  ASSERT_TRUE(response.success) << response.status.message;
  ASSERT_TRUE(response.contact);
  expectOneOf(response.t_contact, {ballFromBase(x, kRadii[0]) / speed, ballFromBase(x, kRadii[1]) / speed},
              1.01 * kMotionTolerance / speed);
}

sensor_msgs::JointState xAxisAt(double x) {
  sensor_msgs::JointState state;
  state.name = {"x_axis"};
  state.position = {x};
  return state;
}

/// One call of each service; the ball stands at (0.5, 0, 0).
void askEverything() {
  const auto minimum = call<MinimumDistanceResponse>(kNode + "minimum_distance", MinimumDistanceRequest());
  ASSERT_TRUE(minimum.success) << minimum.status.message;
  expectDistance(minimum.pair, 0.5);

  const auto axis = call<SeparationAxisResponse>(kNode + "separation_axis", SeparationAxisRequest());
  ASSERT_TRUE(axis.success) << axis.status.message;
  EXPECT_TRUE(axis.separated);
  EXPECT_NEAR(std::abs(axis.axis.x), 1.0, 1e-6);

  const auto depth = call<PenetrationDepthResponse>(kNode + "penetration_depth", PenetrationDepthRequest());
  ASSERT_TRUE(depth.success) << depth.status.message;
  EXPECT_FALSE(depth.penetrating);

  QueryPairsRequest pairs;
  pairs.mode = QueryPairsRequest::PER_PAIR;
  const auto every = call<QueryPairsResponse>(kNode + "query_pairs", pairs);
  ASSERT_TRUE(every.success) << every.status.message;
  EXPECT_EQ(every.pairs.size(), 2u);
  expectDistance(every.minimum, 0.5);

  QueryConfigurationRequest states;
  states.states = {xAxisAt(0.4), xAxisAt(0.2)};
  const auto elsewhere = call<QueryConfigurationResponse>(kNode + "query_configuration", states);
  ASSERT_TRUE(elsewhere.success) << elsewhere.status.message;
  expectDistance(elsewhere.states[0].minimum, 0.4);
  expectDistance(elsewhere.states[1].minimum, 0.2);

  FirstContactRequest sliding;
  sliding.joints = xAxisAt(0.0);
  sliding.joints.velocity = {-0.5};
  sliding.horizon = 3.0;
  expectContact(call<FirstContactResponse>(kNode + "time_of_contact", sliding), 0.5, 0.5);

  QueryTrajectoryRequest trajectory;
  trajectory.trajectory.joint_names = {"x_axis"};
  trajectory.trajectory.points.resize(2);
  trajectory.trajectory.points[0].positions = {0.6};
  trajectory.trajectory.points[1].positions = {0.1};
  trajectory.trajectory.points[1].time_from_start = ros::Duration(1.0);
  expectContact(call<QueryTrajectoryResponse>(kNode + "query_trajectory", trajectory), 0.6, 0.5);
}

/// Loads the one and the other model in turn, in both nodes, so many times.
void replaceTheModel(std::int64_t times) {
  std::string urdf;
  ros::param::get("/robot_description", urdf);
  const std::string radius = "radius=\"0.1\"";
  std::string other = urdf;
  other.replace(other.find(radius), radius.size(), "radius=\"0.15\"");
  for (std::int64_t i = 0; i < times; ++i) {
    ros::param::set("/robot_description", i % 2 == 0 ? other : urdf);
    for (const std::string& node : {kNode, std::string("/on_tf/")}) {
      const auto reloaded = call<std_srvs::TriggerResponse>(node + "reload", std_srvs::TriggerRequest());
      EXPECT_TRUE(reloaded.success) << reloaded.message;
    }
  }
}

/// Changes the settings of the monitor again and again.
void changeTheMonitor(const std::atomic<bool>& done) {
  std_srvs::SetBoolRequest monitor;
  for (int i = 0; !done; ++i) {
    set(kNode, "rate", i % 2 == 0 ? 100.0 : 200.0);
    set(kNode, "lookahead", i % 3 == 0 ? 0.0 : 0.1);
    monitor.data = i % 4 != 0;
    EXPECT_TRUE(call<std_srvs::SetBoolResponse>(kNode + "enable_monitor", monitor).success);
    ros::WallDuration(0.02).sleep();
  }
}

/// Everything that a monitor publishes with a level must be right.
int checkClearances(Inbox<Clearance>& inbox, const std::atomic<bool>& done) {
  int valid = 0;
  while (!done) {
    const auto clearance = inbox.next();
    if (!clearance) return valid;
    if (clearance->level == Clearance::INVALID) continue;
    expectDistance(clearance->minimum, 0.5);
    EXPECT_NE(clearance->lookahead.state, Lookahead::CONTACT);
    ++valid;
  }
  return valid;
}

TEST(ReloadUnderLoad, EveryAnswerIsThatOfOneOfTheModels) {
  // Static: a callback that is under way at the end of the test still finds them.
  static Gantry gantry{ros::NodeHandle()};
  ASSERT_TRUE(gantry.awaitListeners(2));
  gantry.hold({0.5, 0.0, 0.0});
  static JointStates joint_states;
  joint_states.hold(slidingAt(0.0), positionsAt(0.5));
  static Inbox<visualization_msgs::MarkerArray> markers(ros::NodeHandle(), kNode + "markers");
  static Inbox<Clearance> timed(ros::NodeHandle(), kNode + "clearance"), on_tf(ros::NodeHandle(), "/on_tf/clearance");
  for (Inbox<Clearance>* inbox : {&timed, &on_tf}) {
    ASSERT_TRUE(inbox->next([](const Clearance& message) { return message.level != Clearance::INVALID; }));
  }

  std::atomic<bool> done{false};
  std::atomic<int> rounds{0};
  int valid_timed = 0, valid_on_tf = 0;
  std::vector<std::thread> threads;
  for (int i = 0; i < kClients; ++i) {
    threads.emplace_back([&] {
      for (; !done && !testing::Test::HasFatalFailure(); ++rounds) askEverything();
    });
  }
  threads.emplace_back([&] { changeTheMonitor(done); });
  threads.emplace_back([&] { valid_timed = checkClearances(timed, done); });
  threads.emplace_back([&] { valid_on_tf = checkClearances(on_tf, done); });
  replaceTheModel(fromEnvironment("PROXIMITY_RELOADS", 60));
  done = true;
  for (std::thread& thread : threads) thread.join();

  EXPECT_GT(rounds, kClients);
  EXPECT_GT(valid_timed, 10);
  EXPECT_GT(valid_on_tf, 10);
  EXPECT_GT(markers.clear(), 0u);
}

}  // namespace proximity_server::node::reload_under_load_test
