#include <proximity_server/ModelInfo.h>
#include "node/faults/running_node.h"
#include "node/gantry.h"

#include <dynamic_reconfigure/Config.h>

#include <csignal>
#include <map>

// The launch files change no parameter of a user's. The numbers are those of launch_files.test and launch_files.yaml.

namespace proximity_server::node::launch_files_test {

/// The settings that a node works with; none if it does not tell.
std::map<std::string, double> settingsOf(const std::string& node) {
  Inbox<dynamic_reconfigure::Config> inbox(ros::NodeHandle(), node + "/parameter_updates");
  std::map<std::string, double> settings;
  const auto message = inbox.next();
  EXPECT_TRUE(message) << node;
  if (!message) return settings;
  for (const auto& number : message->doubles) settings[number.name] = number.value;
  return settings;
}

TEST(ProximityLaunch, KeepsWhatWasSetBefore) {
  auto settings = settingsOf("/set_before/proximity_server");
  EXPECT_EQ(settings["rate"], 20.0);
  EXPECT_EQ(settings["threshold"], 0.7);
  EXPECT_EQ(settings["stop_distance"], 0.04);
  EXPECT_EQ(settings["warn_distance"], 0.05);  // the node's default
  Inbox<ModelInfo> inbox(ros::NodeHandle(), "/set_before/proximity_server/model_info");
  const auto info = inbox.next();
  ASSERT_TRUE(info);
  EXPECT_EQ(info->robot, "followers");
}

TEST(ProximityLaunch, TakesAFileOfTheUsersAndItsArgumentsGoBeforeIt) {
  auto settings = settingsOf("/from_file/proximity_server");
  EXPECT_EQ(settings["rate"], 25.0);
  EXPECT_EQ(settings["threshold"], 0.4);
  EXPECT_EQ(settings["hysteresis"], 0.003);
}

TEST(ProximityLaunch, LeavesTheDefaultsToTheNode) {
  auto settings = settingsOf("/untouched/proximity_server");
  EXPECT_EQ(settings["rate"], 50.0);
  EXPECT_EQ(settings["threshold"], 0.3);
}

TEST(ProximityLaunch, StartsANodeThatHasEndedAgainWhereThatIsAsked) {
  const std::string node = "/respawned/proximity_server";
  EXPECT_EQ(settingsOf(node)["rate"], 50.0);  // it runs
  const pid_t first = processOf(node);
  ASSERT_GT(first, 0);
  ASSERT_EQ(kill(first, SIGKILL), 0);
  const auto is_another = [&] { return processOf(node) > 0 && processOf(node) != first; };
  EXPECT_TRUE(holdsWithin(kPatience, is_another));
}

TEST(DemoLaunch, TakesAFileOfTheUsersAndKeepsWhatWasSetBefore) {
  auto settings = settingsOf("/demo/proximity_server");
  EXPECT_EQ(settings["threshold"], 0.6);
  EXPECT_EQ(settings["stop_distance"], 0.04);
}

TEST(DemoLaunch, GivesNoObjectsToARobotOfTheUsers) {
  EXPECT_FALSE(ros::param::has("/demo/demo_motion/boxes"));  // demo_objects_test sees it with the robot of the demo
}

}  // namespace proximity_server::node::launch_files_test
