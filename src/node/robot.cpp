#include "robot.h"

#include <ros/console.h>

#include <stdexcept>
#include <utility>

namespace proximity_server {
namespace {

/// The text of a parameter, searched upwards; "" where there is none.
std::string descriptionOf(const ros::NodeHandle& nh, const std::string& name) {
  std::string found, text;
  if (!nh.searchParam(name, found)) return {};
  if (!nh.getParam(found, text)) throw std::invalid_argument("parameter " + found + " must be a text");
  return text;
}

std::string urdfOf(const ros::NodeHandle& nh, const std::string& name) {
  std::string urdf = descriptionOf(nh, name);
  if (urdf.empty()) {
    throw std::invalid_argument("no robot: parameter '" + name + "' is not set or empty, searched upwards from " +
                                nh.getNamespace());
  }
  return urdf;
}

std::shared_ptr<const SceneModel> sceneModel(const std::string& urdf, const std::string& srdf, const Config& config) {
  std::vector<std::string> roots = config.mesh_roots;
  for (std::string& root : rosPackagePath()) roots.push_back(std::move(root));
  ModelOptions options = config.model;
  options.progress = [](const std::string& what) { ROS_INFO_STREAM("Loading: " << what); };
  RobotModel robot = loadRobotModel(urdf, withinRoots(packageResolver(roots), config.allowed_mesh_roots), options);
  return std::make_shared<const SceneModel>(makeSceneModel(std::move(robot), srdf, config.filter));
}

const Link& rootLink(const RobotModel& robot) {
  return robot.links[static_cast<std::size_t>(robot.bodies.front().link)];
}

std::shared_ptr<const std::vector<TfEdge>> edgesOf(const RobotModel& robot, const std::string& reference_frame) {
  const auto name = [&](int link) { return robot.links[static_cast<std::size_t>(link)].name; };
  auto edges = std::make_shared<std::vector<TfEdge>>();
  for (const Joint& joint : robot.joints) {
    edges->push_back({name(joint.parent_link), name(joint.child_link), "joint '" + joint.name + "'"});
  }
  if (robot.findLink(reference_frame) < 0) {
    edges->push_back({reference_frame, rootLink(robot).name, "reference_frame '" + reference_frame + "'"});
  }
  return edges;
}

}  // namespace

Robot::Robot(const ros::NodeHandle& nh, const Config& config)
    : Robot(urdfOf(nh, config.robot_description), descriptionOf(nh, config.semantic_description), config) {}

Robot::Robot(const std::string& urdf, const std::string& srdf, const Config& config)
    : config_(config),
      srdf_(srdf),
      model_(sceneModel(urdf, srdf, config)),
      reference_frame_(config.reference_frame.empty() ? rootLink(model_->robot).name : config.reference_frame),
      reference_link_(model_->robot.findLink(reference_frame_)),
      tf_edges_(edgesOf(model_->robot, reference_frame_)),
      scenes_(std::make_unique<ScenePool>([first = std::make_shared<const Scene>(model_)] { return first->twin(); })),
      moving_scenes_(std::make_unique<MovingScenePool>(
          [first = std::make_shared<const MovingScene>(model_)] { return first->twin(); })) {}

std::vector<SubjectPair> Robot::pairsOfGroup(const std::string& group) const {
  PairFilterOptions filter = config_.filter;
  filter.group = group;
  return checkedPairs(filterPairs(links(), srdf_, filter));
}

std::vector<SubjectPair> checkedPairs(const PairTable& table) {
  std::vector<SubjectPair> pairs;
  for (const int index : table.checked) {
    const LinkPair& pair = table.pairs[static_cast<std::size_t>(index)];
    pairs.push_back({{pair.link_a}, {pair.link_b}});
  }
  return pairs;
}

}  // namespace proximity_server
