#include "tools/states/bag_states.h"

#include "sanitized.h"
#include "scene/example_robots.h"
#include "scene/files.h"
#include "tools/clearance/trajectory_run.h"
#include "tools/states/arm.h"

#include <gtest/gtest.h>
#include <rosbag/bag.h>
#include <sensor_msgs/JointState.h>
#include <sensor_msgs/Temperature.h>

namespace proximity_server::tools::bag_states_test {

using namespace scene;

sensor_msgs::JointState message(double stamp, const std::vector<std::string>& names,
                                const std::vector<double>& positions) {
  sensor_msgs::JointState state;
  state.header.stamp = ros::Time(stamp);
  state.name = names;
  state.position = positions;
  return state;
}

class BagStates : public ::testing::Test {
 protected:
  /// Three states of elbow and lift, at 1, 2 and 3 s, from two publishers; each was recorded a second later.
  std::string write(const std::string& name, rosbag::CompressionType compression = rosbag::compression::Uncompressed) {
    rosbag::Bag bag(files_.path(name), rosbag::bagmode::Write);
    bag.setCompression(compression);
    bag.write("/joint_states", ros::Time(2.0), message(1.0, {"elbow"}, {0.1}));
    bag.write("/joint_states", ros::Time(2.0), message(1.0, {"lift"}, {0.2}));
    bag.write("/joint_states", ros::Time(3.0), message(2.0, {"elbow"}, {0.3}));
    bag.write("/joint_states", ros::Time(4.0), message(3.0, {"lift"}, {0.4}));
    bag.write("/arm/joint_states", ros::Time(5.0), message(0.0, {"wheel"}, {0.5}));
    bag.write("/temperature", ros::Time(5.0), sensor_msgs::Temperature());
    bag.close();
    return files_.path(name);
  }

  std::unique_ptr<StateSource> open(const std::string& file, const std::string& topic = "/joint_states") {
    return openBag({file, topic, std::nullopt}, arm());
  }

  /// Without the folder.
  std::string errorIn(const std::string& file, const std::string& topic = "/joint_states") {
    const std::string error = errorOf([&] { open(file, topic); }), folder = files_.path("");
    return error.compare(0, folder.size(), folder) == 0 ? error.substr(folder.size()) : error;
  }

  TemporaryFiles files_;
};

const std::vector<Positions> kStates{at(0.1, 0.2, 0.0), at(0.3, 0.2, 0.0), at(0.3, 0.4, 0.0)};

TEST_F(BagStates, AreThoseOfTheMessagesAtTheirStamps) {
  const std::unique_ptr<StateSource> states = open(write("a.bag"));
  EXPECT_TRUE(states->header().has(JointColumn::Quantity::Time));
  EXPECT_EQ(states->count(), 3U);
  scene::TrajectoryPoint state;
  for (int i = 0; i < 3; ++i) {
    ASSERT_TRUE(states->next(state));
    EXPECT_EQ(state.positions, kStates[i]);
    EXPECT_EQ(state.time, 1.0 + i);
  }
  EXPECT_FALSE(states->next(state));
}

TEST_F(BagStates, AreAtTheTimesOfRecordingIfThereAreNoStamps) {
  const std::unique_ptr<StateSource> states = open(write("a.bag"), "arm/joint_states");
  scene::TrajectoryPoint state;
  ASSERT_TRUE(states->next(state));
  EXPECT_EQ(state.positions, at(0.0, 0.0, 0.5));
  EXPECT_EQ(state.time, 5.0);
}

TEST_F(BagStates, AreTheWayPointsOfATrajectory) {
  const std::unique_ptr<StateSource> states = open(write("a.bag"));
  TrajectorySegments segments(*states);
  TrajectorySegment segment;
  for (int i = 0; i < 2; ++i) {
    ASSERT_TRUE(segments.next(segment));
    EXPECT_EQ(segment.begin, 1.0 + i);
    EXPECT_EQ(segment.end, 2.0 + i);
    EXPECT_EQ(segment.from, kStates[i]);
    EXPECT_EQ(segment.to, kStates[i + 1]);
  }
  EXPECT_FALSE(segments.next(segment));
}

TEST_F(BagStates, AreTakenAtARate) {
  const std::unique_ptr<StateSource> states = openBag({write("a.bag"), "/joint_states", 0.5}, arm());
  EXPECT_EQ(restOf(*states), (std::vector<Positions>{kStates[0], kStates[2]}));
}

TEST_F(BagStates, AreReadFromCompressedBags) {
  EXPECT_EQ(restOf(*open(write("bz2.bag", rosbag::compression::BZ2))), kStates);
  EXPECT_EQ(restOf(*open(write("lz4.bag", rosbag::compression::LZ4))), kStates);
  EXPECT_EQ(open(files_.path("bz2.bag"))->identity(), open(files_.path("lz4.bag"))->identity()) << "the same states";
}

TEST_F(BagStates, NeedATopicOfJointStates) {
  const std::string bag = write("a.bag");
  EXPECT_EQ(errorIn(bag, "/joints"),
            "a.bag: no topic /joints; there are /arm/joint_states (sensor_msgs/JointState), /joint_states "
            "(sensor_msgs/JointState), /temperature (sensor_msgs/Temperature)");
  EXPECT_EQ(errorIn(bag, "/temperature"),
            "a.bag: topic /temperature is of type sensor_msgs/Temperature, not sensor_msgs/JointState");
  rosbag::Bag(files_.path("empty.bag"), rosbag::bagmode::Write).close();
  EXPECT_EQ(errorIn(files_.path("empty.bag")), "empty.bag: no topic /joint_states; there are no topics");
}

TEST_F(BagStates, NameTheMessageThatIsWrong) {
  rosbag::Bag bag(files_.path("a.bag"), rosbag::bagmode::Write);
  bag.write("/joint_states", ros::Time(1.0), message(1.0, {"elbow"}, {0.1}));
  bag.write("/joint_states", ros::Time(2.0), message(2.0, {"elbow", "lift"}, {0.1}));
  bag.close();
  EXPECT_EQ(errorIn(files_.path("a.bag")), "a.bag: message 1 of /joint_states: 1 positions for 2 names");
}

TEST_F(BagStates, AreNotReadFromWhatIsNoWholeBag) {
  EXPECT_EQ(errorIn(files_.write("text.bag", "elbow\n1\n")), "text.bag: no bag of version 2.0");
  EXPECT_EQ(errorIn(files_.write("old.bag", "#ROSBAG V1.2\n")), "old.bag: no bag of version 2.0");
  EXPECT_EQ(errorIn(files_.path("nowhere.bag")), "nowhere.bag: cannot be read (No such file or directory)");
  rosbag::Bag bag(files_.path("recording.bag"), rosbag::bagmode::Write);
  bag.write("/joint_states", ros::Time(1.0), message(1.0, {"elbow"}, {0.1}));
  EXPECT_EQ(errorIn(files_.path("recording.bag")),
            "recording.bag: without an index, as its recording did not end: rosbag reindex makes one");
  bag.close();
  EXPECT_EQ(errorIn(files_.path("recording.bag")), "");
}

TEST_F(BagStates, AreNotReadFromABagThatIsCutOff) {
  const std::string whole = readFile(write("a.bag"));
  for (std::size_t size = 0; size < whole.size(); size += kIsSanitized ? 397 : 61) {
    const std::string error = errorIn(files_.write("cut.bag", whole.substr(0, size)));
    EXPECT_EQ(error.compare(0, 9, "cut.bag: "), 0) << size << " of " << whole.size() << ": " << error;
  }
}

// A field of the first record, which is filled up with blanks; the fill shrinks by as much as the field adds.
TEST_F(BagStates, AreNotReadFromAnEncryptedBag) {
  std::string bytes = readFile(write("a.bag"));
  const auto number = [](std::size_t value) {
    std::string text;
    for (int i = 0; i < 4; ++i) text += static_cast<char>(static_cast<unsigned char>(value >> 8 * i));
    return text;
  };
  const auto numberAt = [&](std::size_t place) {
    std::size_t value = 0;
    for (int i = 3; i >= 0; --i)
      value = value << 8 | static_cast<unsigned char>(bytes.at(place + static_cast<std::size_t>(i)));
    return value;
  };
  const std::string text = "encryptor=rosbag/AesCbcEncryptor", field = number(text.size()) + text;
  const std::size_t begin = 13, length = numberAt(begin), fill = begin + 4 + length;
  const std::size_t fill_length = numberAt(fill);
  ASSERT_EQ(length + fill_length, 4096U);
  bytes.replace(begin, 4, number(length + field.size()));
  bytes.replace(fill, 4 + fill_length,
                field + number(fill_length - field.size()) + std::string(fill_length - field.size(), ' '));
  EXPECT_EQ(errorIn(files_.write("e.bag", bytes)), "e.bag: encrypted; decrypt it first (rosbag decrypt)");
}

}  // namespace proximity_server::tools::bag_states_test
