#include "tools/states/bag_states.h"

#include "tools/states/bytes.h"
#include "tools/states/recorded_states.h"
#include "tools/text/naming.h"

#include <rosbag/bag.h>
#include <rosbag/view.h>
#include <sensor_msgs/JointState.h>

#include <algorithm>
#include <exception>
#include <new>
#include <set>
#include <stdexcept>

namespace proximity_server::tools {
namespace {

const std::string kType = "sensor_msgs/JointState";

/// Throws std::invalid_argument if the record behind the first line of a bag names an encryptor. rosbag would load a
/// plugin.
/// Source: ROS wiki, Bags/Format/2.0.
void refuseEncrypted(const std::string& path) {
  FileBytes bytes(path);
  const std::string first_line = "#ROSBAG V2.0\n";
  std::string text(std::min<std::uint64_t>(bytes.size(), 4096),
                   '\0');  // both parts of the record together have so many
  bytes.read(0, text.data(), text.size());
  if (text.compare(0, first_line.size(), first_line) != 0) throw std::invalid_argument("no bag of version 2.0");
  const std::string field = "encryptor=";
  const std::size_t begin = text.find(field);
  const std::string length_of_empty{static_cast<char>(field.size()), '\0', '\0', '\0'};
  if (begin == std::string::npos || text.compare(begin - 4, 4, length_of_empty) == 0) return;
  throw std::invalid_argument("encrypted; decrypt it first (rosbag decrypt)");
}

std::string withSlash(const std::string& topic) { return topic.compare(0, 1, "/") == 0 ? topic : "/" + topic; }

/// The topics of a bag, each with its type, topics of joint states first.
std::string topicsText(rosbag::View& all) {
  std::set<std::string> wanted, others;
  for (const rosbag::ConnectionInfo* connection : all.getConnections())
    (connection->datatype == kType ? wanted : others).insert(connection->topic + " (" + connection->datatype + ")");
  std::string text;
  for (const auto* topics : {&wanted, &others})
    for (const std::string& topic : *topics) text += (text.empty() ? "" : ", ") + topic;
  return text.empty() ? "no topics" : text;
}

/// The name of the topic in the bag, with or without a slash before it.
std::string findTopic(const rosbag::Bag& bag, const std::string& asked) {
  rosbag::View all(bag);
  std::string found;
  for (const rosbag::ConnectionInfo* connection : all.getConnections()) {
    if (withSlash(connection->topic) != withSlash(asked)) continue;
    if (connection->datatype != kType)
      throw std::invalid_argument("topic " + asked + " is of type " + connection->datatype + ", not " + kType);
    found = connection->topic;
  }
  if (found.empty()) throw std::invalid_argument("no topic " + asked + "; there are " + topicsText(all));
  return found;
}

JointRecording recordingOf(const rosbag::Bag& bag, const std::string& topic, const scene::RobotModel& robot) {
  JointRecording recording(robot);
  rosbag::View view(bag, rosbag::TopicQuery(topic));
  std::uint64_t number = 0;
  for (const rosbag::MessageInstance& instance : view) {
    naming("message " + std::to_string(number++) + " of " + topic, [&] {
      const auto message = instance.instantiate<sensor_msgs::JointState>();
      if (!message) throw std::invalid_argument("its definition is not that of " + kType + " in this build");
      const ros::Time stamp = message->header.stamp.isZero() ? instance.getTime() : message->header.stamp;
      recording.add(stamp.toSec(), message->name, message->position);
    });
  }
  return recording;
}

JointRecording readBag(const BagOptions& options, const scene::RobotModel& robot) {
  refuseEncrypted(options.file);
  rosbag::Bag bag;
  try {
    bag.open(options.file, rosbag::bagmode::Read);
  } catch (const rosbag::BagUnindexedException&) {
    throw std::invalid_argument("without an index, as its recording did not end: rosbag reindex makes one");
  }
  return recordingOf(bag, findTopic(bag, options.topic), robot);
}

}  // namespace

std::unique_ptr<StateSource> openBag(const BagOptions& options, const scene::RobotModel& robot) {
  return naming(options.file, [&]() -> std::unique_ptr<StateSource> {
    try {
      return std::make_unique<RecordedStates>(options.file, readBag(options, robot), options.rate);
    } catch (const std::bad_alloc&) {
      throw;
    } catch (const std::exception& error) {  // rosbag has exceptions of its own
      throw std::invalid_argument(error.what());
    }
  });
}

}  // namespace proximity_server::tools
