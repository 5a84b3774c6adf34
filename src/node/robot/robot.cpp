#include "node/robot/robot.h"

#include <ros/console.h>

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "node/robot/tf_frames.h"
#include "proximity_server/scene/model/load_robot_model.h"
#include "proximity_server/scene/query/make_scene_model.h"

namespace proximity_server::node {
namespace {

/// The text of a parameter, searched upwards; "" if there is none.
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

/// The text of the SRDF; "" if the parameter is not set, which is an error only if a user named the parameter.
std::string srdfOf(const ros::NodeHandle& nh, const std::string& name) {
  if (name.empty()) return {};
  std::string found;
  if (name != Config().semantic_description && !nh.searchParam(name, found)) {
    throw std::invalid_argument("no SRDF: parameter '" + name + "', which semantic_description names, is not set, " +
                                "searched upwards from " + nh.getNamespace());
  }
  return descriptionOf(nh, name);
}

std::shared_ptr<const scene::SceneModel> loadSceneModel(const std::string& urdf, const std::string& srdf,
                                                        const Config& config) {
  scene::ModelOptions options = config.model;
  options.progress = [](const std::string& what) { ROS_INFO_STREAM("Loading: " << what); };
  scene::RobotModel robot = scene::loadRobotModel(urdf, meshResolver(config), options);
  return std::make_shared<const scene::SceneModel>(scene::makeSceneModel(std::move(robot), srdf, config.filter));
}

int findFrame(const scene::RobotModel& robot, const Config& config, const std::string& frame) {
  const int link = robot.findLink(frame);
  if (link >= 0) return link;
  const auto hasFrame = [&](const scene::Link& l) { return tfFrame(config.tf_prefix, l.name) == frame; };
  const auto hit = std::find_if(robot.links.begin(), robot.links.end(), hasFrame);
  return hit == robot.links.end() ? -1 : static_cast<int>(hit - robot.links.begin());
}

/// The link of the reference frame, or -1. The parameter may name the link, or its frame with the prefix.
int referenceLinkOf(const scene::RobotModel& robot, const Config& config) {
  if (config.reference_frame.empty()) return robot.bodies.front().link;
  return findFrame(robot, config, config.reference_frame);
}

/// No objects, and rules for a robot whose base stands still if it carries the reference frame.
RobotObjects noObjects(const std::shared_ptr<const scene::SceneModel>& model, int reference_link,
                       scene::ObjectRules::FreeObjects free_objects) {
  scene::ObjectRules rules;
  rules.free_objects = free_objects;
  const bool on_base = reference_link >= 0 && model->robot.links[reference_link].body == 0;
  rules.base = on_base ? scene::ObjectRules::Base::StandsStill : scene::ObjectRules::Base::MayMove;
  return {std::make_shared<const scene::Objects>(scene::Objects(model).withRules(rules)), 0};
}

std::shared_ptr<const std::vector<TfEdge>> edgesOf(const scene::RobotModel& robot, const Config& config) {
  const auto frame = [&](int link) { return tfFrame(config.tf_prefix, robot.links[link].name); };
  auto edges = std::make_shared<std::vector<TfEdge>>();
  for (const scene::Joint& joint : robot.joints) {
    edges->push_back({frame(joint.parent_link), frame(joint.child_link), "joint '" + joint.name + "'"});
  }
  if (referenceLinkOf(robot, config) < 0) {
    edges->push_back(
        {config.reference_frame, frame(robot.bodies.front().link), "reference_frame '" + config.reference_frame + "'"});
  }
  return edges;
}

}  // namespace

Robot::Robot(const ros::NodeHandle& nh, const Config& config)
    : Robot(urdfOf(nh, config.robot_description), srdfOf(nh, config.semantic_description), config) {}

Robot::Robot(const std::string& urdf, const std::string& srdf, const Config& config)
    : config_(config),
      srdf_(srdf),
      model_(loadSceneModel(urdf, srdf, config)),
      candidates_(model_->pairs),
      candidate_bodies_(bodiesOf(model_->robot, candidates_.list())),
      reference_link_(referenceLinkOf(model_->robot, config)),
      reference_frame_(reference_link_ < 0 ? config.reference_frame : frameOf(reference_link_)),
      tf_edges_(edgesOf(model_->robot, config)),
      objects_(std::make_unique<ObjectSlot>(noObjects(model_, reference_link_, config.free_objects))),
      scenes_(std::make_unique<ScenePool>(
          [first = std::make_shared<const scene::Scene>(model_)] { return first->twin(); })),
      moving_scenes_(std::make_unique<MovingScenePool>(
          [first = std::make_shared<const scene::MovingScene>(model_)] { return first->twin(); })) {}

std::string Robot::frameOf(int link) const { return tfFrame(config_.tf_prefix, robotModel().links[link].name); }

int Robot::linkOfFrame(const std::string& frame) const { return findFrame(robotModel(), config_, frame); }

std::vector<scene::ShapeRefPair> Robot::pairsOfGroup(const std::string& group) const {
  scene::PairFilterOptions filter = config_.filter;
  filter.group = group;
  return scene::Candidates(scene::filterPairs(robotModel(), srdf_, filter)).list();
}

scene::MeshResolver meshResolver(const Config& config) {
  std::vector<std::string> roots = config.mesh_roots;
  for (std::string& root : scene::rosPackagePath()) roots.push_back(std::move(root));
  return scene::withinRoots(scene::packageResolver(roots), config.allowed_mesh_roots);
}

std::vector<int> bodiesOf(const scene::RobotModel& robot, const std::vector<scene::ShapeRefPair>& pairs) {
  std::vector<bool> is_asked(robot.bodies.size(), false);
  for (const scene::ShapeRefPair& pair : pairs) {
    for (const int link : {pair.a.link, pair.b.link})
      if (link >= 0) is_asked[robot.links[link].body] = true;
  }
  std::vector<int> bodies;
  for (std::size_t body = 0; body < is_asked.size(); ++body)
    if (is_asked[body]) bodies.push_back(static_cast<int>(body));
  return bodies;
}

}  // namespace proximity_server::node
