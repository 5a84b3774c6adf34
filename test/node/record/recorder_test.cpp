// Records of the monitor, read as any tool reads bags.
#include "node/record/bag_file.h"
#include "node/record/recorded_sliders.h"
#include "node/robot/load_config.h"
#include "robots/urdf.h"

#include <gtest/gtest.h>
#include <rosbag/bag.h>
#include <rosbag/view.h>
#include <std_msgs/String.h>

#include <chrono>
#include <map>
#include <thread>

namespace proximity_server::node::recorder_test {

template <class Message>
std::vector<Message> messagesOf(const std::string& file, const std::string& topic) {
  rosbag::Bag bag(file);
  std::vector<Message> messages;
  for (const rosbag::MessageInstance& instance : rosbag::View(bag, rosbag::TopicQuery(topic)))
    messages.push_back(*instance.instantiate<Message>());
  return messages;
}

std::string bytesOf(const Clearance& message) {
  std::string bytes(ros::serialization::serializationLength(message), '\0');
  ros::serialization::OStream stream(reinterpret_cast<std::uint8_t*>(bytes.data()),
                                     static_cast<std::uint32_t>(bytes.size()));
  ros::serialization::serialize(stream, message);
  return bytes;
}

const std::string kNode = "/cell/proximity_server";

TEST_F(RecordedSliders, HaveWhatTheMonitorSawAndAnswered) {
  start();
  add(ballAt(standingAt(0.0, 1.0, 0.0)));
  know();
  for (int i = 0; i < 10; ++i) cycleAt(0.5 - 0.01 * i);
  settings_.warn_distance = 0.06;
  const Clearance last = cycleAt(0.21);
  const Recorder::Outcome outcome = stop();
  EXPECT_EQ(outcome.problem, "");
  EXPECT_EQ(outcome.lost, 0u);
  EXPECT_NE(outcome.file.find("cell_proximity_server_20"), std::string::npos) << outcome.file;

  const auto clearances = messagesOf<Clearance>(outcome.file, kNode + "/clearance");
  ASSERT_EQ(clearances.size(), 11u);
  EXPECT_EQ(bytesOf(clearances.back()), bytesOf(last));
  const auto states = messagesOf<sensor_msgs::JointState>(outcome.file, "/joint_states");
  ASSERT_EQ(states.size(), 11u);
  EXPECT_EQ(states[1].name, (std::vector<std::string>{"to_left", "to_middle", "to_right"}));
  EXPECT_NEAR(states[1].position[2], 0.49, 1e-12);
  EXPECT_TRUE(states[0].velocity.empty());
  ASSERT_EQ(states[1].velocity.size(), 3u);
  EXPECT_NEAR(states[1].velocity[2], -0.5, 1e-6) << "0.01 m in 20 ms";
  EXPECT_EQ(messagesOf<tf2_msgs::TFMessage>(outcome.file, kNode + "/record/poses").size(), 11u);
  EXPECT_EQ(messagesOf<dynamic_reconfigure::Config>(outcome.file, kNode + "/record/settings").size(), 2u);
  const auto objects = messagesOf<std_msgs::String>(outcome.file, kNode + "/record/objects");
  ASSERT_EQ(objects.size(), 1u);
  EXPECT_NE(objects[0].data.find("ball"), std::string::npos);
  const auto robots = messagesOf<Record>(outcome.file, kNode + "/record/robot");
  ASSERT_EQ(robots.size(), 1u);
  EXPECT_EQ(robots[0].event, "stop");
  EXPECT_EQ(robots[0].robot_descriptions, std::vector<std::string>{kSliders});
}

TEST_F(RecordedSliders, BeginAtTheChangeToALevelThatIsAskedFor) {
  config_.record_on = {"collision"};
  start();
  cycleAt(0.15);
  for (const double right : {0.5, 0.21, 0.5}) cycleAt(right);
  std::this_thread::sleep_for(std::chrono::milliseconds(200));
  EXPECT_TRUE(files().empty()) << "a level at the start is no change, and STOP is not asked for";
  cycleAt(0.15);
  const std::string file = stop().file;
  EXPECT_NE(file.find("_collision.bag"), std::string::npos) << file;
}

TEST_F(RecordedSliders, AreWrittenByTheServiceOnlyIfThereIsNoFolder) {
  config_.record_directory = "";
  setenv("ROS_HOME", files_.path("home").c_str(), 1);
  start();
  unsetenv("ROS_HOME");
  cycleAt(0.5);
  cycleAt(0.15);
  const std::string file = stop().file;
  EXPECT_EQ(file.find(files_.path("home") + "/proximity_server/cell_proximity_server_"), 0u) << file;
  EXPECT_NE(file.find("_service.bag"), std::string::npos) << file;
}

TEST_F(RecordedSliders, LeaveOutWhatIsOlder) {
  config_.record_seconds = 0.2;
  start();
  for (int i = 0; i < 5; ++i) cycleAt(0.5);
  std::this_thread::sleep_for(std::chrono::milliseconds(400));
  for (int i = 0; i < 3; ++i) cycleAt(0.5);
  EXPECT_EQ(messagesOf<Clearance>(stop().file, kNode + "/clearance").size(), 3u);
}

TEST_F(RecordedSliders, HaveTheLatestCyclesIfTheMemoryIsSmall) {
  config_.record_memory = 0.1;
  start();
  for (int i = 0; i < 1000; ++i) cycleAt(0.5);
  const auto clearances = messagesOf<Clearance>(stop().file, kNode + "/clearance");
  ASSERT_GT(clearances.size(), 20u);
  ASSERT_LT(clearances.size(), 200u);
  for (std::size_t i = 0; i < clearances.size(); ++i)
    EXPECT_EQ(clearances[i].cycle, 1000 - clearances.size() + 1 + i) << i;
}

TEST_F(RecordedSliders, TellTheObjectsOfEachMoment) {
  start();
  cycleAt(0.5);
  add(ballAt(standingAt(0.0, 1.0, 0.0), "first"));
  know();
  cycleAt(0.5);
  add(ballAt(standingAt(0.0, 2.0, 0.0), "second"));
  know();
  cycleAt(0.5);
  const auto objects = messagesOf<std_msgs::String>(stop().file, kNode + "/record/objects");
  ASSERT_EQ(objects.size(), 3u);
  EXPECT_EQ(objects[1].data.find("second"), std::string::npos);
  EXPECT_NE(objects[2].data.find("second"), std::string::npos);
}

// Regression: it was noticed after the first stop, whose record was lost.
TEST_F(RecordedSliders, NeedAFolderFromTheStart) {
  const auto errorWith = [&](const std::string& folder) {
    config_.record_directory = folder;
    return scene::errorOf([&] { Recorder(config_, "/cell/proximity_server"); });
  };
  const std::string gone = files_.path("gone"), file = files_.write("file", "");
  EXPECT_EQ(errorWith(gone), "record_directory: " + gone + " cannot be written into (No such file or directory)");
  EXPECT_EQ(errorWith(file), "record_directory: " + file + " cannot be written into (Not a directory)");
  config_.record_seconds = 0.0;
  EXPECT_EQ(errorWith(gone), "") << "nothing is recorded";
}

TEST_F(RecordedSliders, AreAProblemOnlyWhereTheFolderIsGone) {
  config_.record_directory = files_.path("gone");
  std::filesystem::create_directory(config_.record_directory);
  start();
  std::filesystem::remove(config_.record_directory);
  cycleAt(0.5);
  const Recorder::Outcome outcome = stop();
  EXPECT_EQ(outcome.file, "");
  EXPECT_NE(outcome.problem.find("gone"), std::string::npos) << outcome.problem;
}

TEST_F(RecordedSliders, AreNotMoreThanTheirCountAndTheOldestGo) {
  config_.record_count = 2;
  for (const char* old :
       {"cell_proximity_server_2020-01-01T00-00-00.000_stop.bag",
        "cell_proximity_server_2021-01-01T00-00-00.000_stop.bag", "mine.bag", "cell_proximity_server_notes.bag"})
    files_.write(old, "");
  start();
  cycleAt(0.5);
  const std::string file = std::filesystem::path(stop().file).filename();
  EXPECT_EQ(files(), (std::set<std::string>{"cell_proximity_server_2021-01-01T00-00-00.000_stop.bag", file, "mine.bag",
                                            "cell_proximity_server_notes.bag"}));
}

TEST_F(RecordedSliders, AreNotKeptIfTheSecondsAreZero) {
  config_.record_seconds = 0.0;
  start();
  cycleAt(0.5);
  cycleAt(0.15);
  EXPECT_FALSE(recorder_->beginSaving());
  EXPECT_TRUE(files().empty());
}

// rosbag::Bag ends the process here.
TEST(RecordMessages, HaveAllSettings) {
  MonitorSettings settings;
  settings.rate = 7.0;
  settings.max_reported_pairs = 3;
  settings.markers = false;
  settings.gradients = true;
  EXPECT_EQ(differences(settings, monitorSettingsFrom(toMessage(settings), "record")), "");
}

TEST(RecordMessages, HaveTheRateOfAJointThatPassesHalfATurn) {
  using namespace robots;
  const Robot robot(urdfOf(link("base") + link("rim") + hinge("axle", "base", "rim", "0 0 1")), "", Config());
  const auto jointsAt = [&](double angle, double time, const sensor_msgs::JointState& before) {
    RecordedCycle cycle;
    cycle.poses.assign(2, Eigen::Isometry3d::Identity());
    cycle.poses[1]->rotate(Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitZ()));
    cycle.clearance.header.stamp = ros::Time(time);
    return jointsOf(robot, cycle, before);
  };
  constexpr double kHalfATurn = 3.14159265358979323846;
  const sensor_msgs::JointState state = jointsAt(kHalfATurn + 0.02, 1000.5, jointsAt(kHalfATurn - 0.03, 1000.0, {}));
  ASSERT_EQ(state.velocity.size(), 1u);
  EXPECT_NEAR(state.velocity[0], 0.1, 1e-9);
}

TEST(BagFile, ThrowsOnAFullDisk) {
  std_msgs::String message;
  message.data.assign(4 << 20, 'x');
  const auto write = [&] {
    BagFile bag("/dev/full");
    bag.write("/topic", ros::Time(1.0), message);
    bag.complete();
  };
  EXPECT_THROW(write(), std::invalid_argument);
}

TEST(BagFile, HasNoNameBeforeItIsComplete) {
  scene::TemporaryFiles files;
  std_msgs::String message;
  const std::string path = files.path("record.bag");
  {
    BagFile bag(path);
    bag.write("/topic", ros::Time(1.0), message);
    EXPECT_FALSE(std::filesystem::exists(path));
  }
  EXPECT_TRUE(std::filesystem::is_empty(files.path("")));
}

TEST(BagFile, IsReadInTheOrderOfTimeAcrossChunks) {
  scene::TemporaryFiles files;
  const std::string path = files.path("record.bag");
  BagFile bag(path);
  std::map<std::string, int> written;
  for (int i = 0; i < 300; ++i) {
    std_msgs::String message;
    message.data = std::to_string(i) + std::string(10000, ' ');
    const std::string topic = i % 3 == 0 ? "/third" : "/other";
    bag.write(topic, i == 0 ? ros::Time() : ros::Time(100.0 + i), message);
    ++written[topic];
  }
  bag.complete();
  for (const auto& [topic, count] : written) {
    const auto messages = messagesOf<std_msgs::String>(path, topic);
    ASSERT_EQ(messages.size(), static_cast<std::size_t>(count));
    for (std::size_t i = 1; i < messages.size(); ++i)
      EXPECT_LT(std::stoi(messages[i - 1].data), std::stoi(messages[i].data));
  }
}

}  // namespace proximity_server::node::recorder_test
