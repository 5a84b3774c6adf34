#include "node/replay/record_reader.h"

#include "node/objects/object_store.h"
#include "node/robot/load_config.h"
#include "proximity_server/scene/files/file_value.h"

#include <rosbag/bag.h>
#include <rosbag/view.h>
#include <std_msgs/String.h>

#include <filesystem>
#include <stdexcept>
#include <string>
#include <utility>

namespace proximity_server::node {
namespace {

bool endsWith(const std::string& text, const std::string& end) {
  return text.size() >= end.size() && text.compare(text.size() - end.size(), end.size(), end) == 0;
}

std::shared_ptr<const Robot> robotOf(const Record& record, const RobotVariant& variant) {
  XmlRpc::XmlRpcValue values;
  int offset = 0;
  if (!record.parameters.empty() && !values.fromXml(record.parameters, &offset))
    throw std::invalid_argument("its parameters cannot be read");
  Config config = configFrom(values, "record");
  if (variant.mesh_tolerance) {
    config.model.mesh_tolerance = *variant.mesh_tolerance;
    config.model.link_mesh_tolerance.clear();
  }
  if (!variant.has_padding) {
    config.model.default_padding = 0.0;
    config.model.link_padding.clear();
    config.filter.pair_padding.clear();
  }
  std::vector<RobotTexts> texts;
  for (std::size_t i = 0; i < record.robot_descriptions.size(); ++i)
    texts.push_back({record.robot_descriptions[i], record.semantic_descriptions.at(i)});
  if (texts.empty()) throw std::invalid_argument("it has no robot");
  return std::make_shared<const Robot>(texts, config);
}

template <class Message>
boost::shared_ptr<Message> instance(const rosbag::MessageInstance& message) {
  if (auto found = message.instantiate<Message>()) return found;
  throw std::invalid_argument(message.getTopic() + " has the definition of another version");
}

}  // namespace

void RecordReader::read(const OnCycle& on_cycle) {
  try {
    rosbag::Bag bag(file_, rosbag::bagmode::Read);
    rosbag::View view(bag);
    for (const rosbag::MessageInstance& message : view) take(message, on_cycle);
  } catch (const rosbag::BagException& error) {
    const bool is_there = std::filesystem::exists(file_);
    throw std::invalid_argument(file_ + (is_there ? ": it is no bag, or a damaged one: " : ": ") + error.what());
  } catch (const std::exception& error) {  // rosbag has exceptions of its own
    throw std::invalid_argument(file_ + ": " + error.what());
  }
  if (!robot) throw std::invalid_argument(file_ + ": no record of the node: there is no topic .../record/robot");
}

void RecordReader::take(const rosbag::MessageInstance& message, const OnCycle& on_cycle) {
  const std::string& topic = message.getTopic();
  if (endsWith(topic, "/record/robot")) {
    record = *instance<Record>(message);
    robot = robotOf(record, variant_);
    objects = {};
    cycle_.poses.clear();
    none_ = robot->objects().get();
    is_new = true;
  } else if (!robot) {
    return;
  } else if (endsWith(topic, "/record/objects")) {
    useObjects(instance<std_msgs::String>(message)->data);
  } else if (endsWith(topic, "/record/settings")) {
    cycle_.settings = monitorSettingsFrom(*instance<dynamic_reconfigure::Config>(message), "record");
  } else if (endsWith(topic, "/record/poses")) {
    placePoses(*instance<tf2_msgs::TFMessage>(message), *robot, objects.frames.names, cycle_);
  } else if (endsWith(topic, "/clearance")) {
    cycle_.clearance = *instance<Clearance>(message);
    if (!objects.objects.all || cycle_.poses.empty())
      throw std::invalid_argument("cycle " + std::to_string(cycle_.clearance.cycle) + " comes before its .../record/" +
                                  (objects.objects.all ? "poses" : "objects"));
    cycle_.time = message.getTime();
    on_cycle(cycle_);
    is_new = false;
  }
}

void RecordReader::useObjects(const std::string& text) {
  scene::ObjectFile file = scene::objectFileFrom(scene::readYaml(text, "its objects"), "its objects");
  if (!variant_.has_padding)
    for (scene::ObjectEdit& object : file.objects) object.padding = 0.0;
  robot->objects().set(none_);
  const FindFrame no_tf = [](const Robot&, const std::string& frame) -> Eigen::Isometry3d {
    throw std::invalid_argument("frame " + frame + " is not known");
  };
  const ObjectStore store(
      robot, 1, no_tf, [](const Robot&) {}, ObjectLimits(), file);
  objects = MonitoredObjects(*robot, robot->objects().get());
  objects_text = text;
  is_new = true;
}

}  // namespace proximity_server::node
