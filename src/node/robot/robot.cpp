#include "node/robot/robot.h"

#include "node/robot/load_config.h"
#include "node/robot/tf_frames.h"
#include "proximity_server/scene/filter/links_of_groups.h"
#include "proximity_server/scene/inequalities/joint_inequalities.h"
#include "proximity_server/scene/levels/make_scene_model.h"
#include "proximity_server/scene/loading/joined_robots.h"
#include "proximity_server/scene/model/names.h"
#include "proximity_server/scene/state/degrees_of_freedom.h"
#include "system/number_text.h"

#include <ros/console.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>
#include <utility>
#include <variant>

namespace proximity_server::node {
namespace {

/// Reads the text of a parameter, which is searched upwards; returns "" if there is none.
std::string descriptionOf(const ros::NodeHandle& nh, const std::string& name) {
  std::string found, text;
  if (!nh.searchParam(name, found)) return {};
  if (!nh.getParam(found, text)) throw std::invalid_argument("parameter " + found + " must be a text");
  return text;
}

std::string urdfOf(const ros::NodeHandle& nh, const RobotSource& robot) {
  std::string urdf = descriptionOf(nh, robot.description);
  if (urdf.empty()) {
    const std::string named_by = robot.name.empty() ? "" : ", which robots/" + robot.name + "/description names,";
    throw std::invalid_argument("no robot: parameter '" + robot.description + "'" + named_by +
                                " is not set or empty, searched upwards from " + nh.getNamespace());
  }
  return urdf;
}

/// Reads the text of the SRDF. Returns "" if the parameter is not set, and throws if a user has named that parameter.
std::string srdfOf(const ros::NodeHandle& nh, const RobotSource& robot) {
  if (robot.semantic.empty()) return {};
  std::string found;
  if (robot.needs_semantic && !nh.searchParam(robot.semantic, found)) {
    const std::string named_by = robot.name.empty() ? "semantic_description" : "robots/" + robot.name + "/semantic";
    throw std::invalid_argument("no SRDF: parameter '" + robot.semantic + "', which " + named_by +
                                " names, is not set, searched upwards from " + nh.getNamespace());
  }
  return descriptionOf(nh, robot.semantic);
}

std::vector<RobotTexts> textsOf(const ros::NodeHandle& nh, const Config& config) {
  std::vector<RobotTexts> texts;
  for (const RobotSource& robot : robotSources(config)) texts.push_back({urdfOf(nh, robot), srdfOf(nh, robot)});
  return texts;
}

std::vector<std::string> srdfsOf(const std::vector<RobotTexts>& texts) {
  std::vector<std::string> srdfs;
  for (const RobotTexts& robot : texts) srdfs.push_back(robot.srdf);
  return srdfs;
}

scene::RobotModel loadModel(const std::vector<RobotTexts>& texts, const Config& config) {
  scene::ModelOptions options = config.model;
  options.progress = [](const std::string& what) { ROS_INFO_STREAM("Loading: " << what); };
  const std::vector<RobotSource> sources = robotSources(config);
  std::vector<scene::NamedUrdf> robots;
  for (std::size_t i = 0; i < texts.size(); ++i) robots.push_back({sources[i].name, texts[i].urdf});
  return scene::loadRobots(robots, config.meshResolver(),
                           withLinksOfGroups(std::move(options), robots, srdfsOf(texts)));
}

std::shared_ptr<const scene::SceneModel> loadSceneModel(const std::vector<RobotTexts>& texts, const Config& config) {
  const std::vector<std::string> srdfs = srdfsOf(texts);
  scene::SceneModel model = scene::makeSceneModel(loadModel(texts, config), srdfs, config.filter);
  scene::warnOfNearPairs(model, config.thresholdsOf(model.robot, srdfs, config.monitor));
  config.setInequalities(model.robot);  // after the random states, none of which may be within them
  return std::make_shared<const scene::SceneModel>(std::move(model));
}

/// The frames of the links in tf. Throws std::invalid_argument if links of two robots have the same frame.
std::vector<std::string> framesOf(const scene::RobotModel& robots, const std::vector<RobotSource>& sources) {
  std::vector<std::string> frames;
  std::map<std::string, int> robot_of;
  for (const scene::Link& link : robots.links) {
    const int robot = robots.bodies[link.body].robot;
    const RobotSource& source = sources[robot];
    frames.push_back(tfFrame(source.tf_prefix, robots.robots[robot].ownName(link.name)));
    const RobotSource& first = sources[robot_of.emplace(frames.back(), robot).first->second];
    if (first.name == source.name) continue;
    throw std::invalid_argument("parameter " + source.prefixParameter() + " is '" + source.tf_prefix +
                                "': the robots '" + first.name + "' and '" + source.name +
                                "' both have the tf frame '" + frames.back() + "'");
  }
  return frames;
}

/// The link that has this frame in tf, or this name; -1 if there is none.
int findFrame(const scene::RobotModel& robot, const std::vector<std::string>& frames, const std::string& frame) {
  const auto hit = std::find(frames.begin(), frames.end(), frame);
  return hit == frames.end() ? robot.findLink(frame) : static_cast<int>(hit - frames.begin());
}

/// The link that has the reference frame, or -1. The parameter may name the link, or its frame with the prefix.
int referenceLinkOf(const scene::RobotModel& robot, const std::vector<std::string>& frames, const Config& config) {
  if (config.reference_frame.empty()) return robot.rootLink();
  return findFrame(robot, frames, config.reference_frame);
}

/// Makes an empty set of objects. By its rules the robot's base stands still if the base carries the reference frame.
RobotObjects noObjects(const std::shared_ptr<const scene::SceneModel>& model, int reference_link,
                       scene::ObjectRules::FreeObjects free_objects) {
  scene::ObjectRules rules;
  rules.free_objects = free_objects;
  const bool on_base = reference_link >= 0 && model->robot.links[reference_link].body == 0;
  rules.base = on_base ? scene::ObjectRules::Base::StandsStill : scene::ObjectRules::Base::MayMove;
  return {std::make_shared<const scene::Objects>(scene::Objects(model).withRules(rules)), 0};
}

/// The name of an edge to a root in messages. The robot is not named if there is only one.
std::string nameOfRootEdge(const Robot& robot, int number, const std::string& parent, const std::string& root) {
  const std::string& name = robot.sources()[number].name;
  if (name.empty()) return "reference_frame '" + robot.referenceFrame() + "'";
  return "frame '" + root + "' of robot '" + name + "' in '" + parent + "'";
}

std::vector<TfEdge> edgesOf(const Robot& robot) {
  std::vector<TfEdge> edges;
  for (const scene::Joint& joint : robot.robotModel().joints) {
    edges.push_back({robot.frameOf(joint.parent_link), robot.frameOf(joint.child_link), "joint '" + joint.name + "'"});
  }
  const std::vector<int> roots = robot.robotModel().roots();
  const auto frameOfRoot = [&](int i) { return robot.frameOf(robot.robotModel().bodies[roots[i]].link); };
  const int own = robot.referenceRobot();
  const std::string parent = own < 0 ? robot.referenceFrame() : frameOfRoot(own);
  for (int i = 0; i < static_cast<int>(roots.size()); ++i) {
    if (i == own) continue;
    const std::string root = frameOfRoot(i);
    edges.push_back({parent, root, nameOfRootEdge(robot, i, parent, root)});
  }
  return edges;
}

/// Finds a movable joint. Throws std::invalid_argument if there is none of this name; the message begins with
/// `parameter`.
int movableJoint(const scene::RobotModel& robot, const std::string& name, const std::string& parameter) {
  const int joint = scene::findNamed(robot.joints, name);
  if (joint >= 0) return joint;
  throw std::invalid_argument(parameter + "the robot has no such movable joint" +
                              scene::didYouMean(name, scene::namesOf(robot.joints)));
}

/// Reads a limit of each joint from `parameter`. Throws std::invalid_argument naming a joint that does not exist or has
/// not one velocity.
std::vector<std::optional<double>> limitsOf(const scene::RobotModel& robot, const scene::JointLimits& known,
                                            const std::string& parameter) {
  std::vector<std::optional<double>> limits(robot.joints.size(), known.of_all);
  for (const auto& [name, limit] : known.of_joint) {
    const std::string whose = "parameter " + parameter + "/" + name + ": ";
    const int joint = movableJoint(robot, name, whose);
    if (!scene::hasOnePosition(robot.joints[joint]))
      throw std::invalid_argument(whose + "the joint is floating or planar, it has not one velocity");
    limits[joint] = limit;
  }
  return limits;
}

/// An obstacle must not vanish among the robot's own points before the robot stops.
/// Throws std::invalid_argument naming the source and the distances.
void requireSeenBefore(const TrackedSource& source, double stop_distance) {
  if (!source.sensing || source.isMap()) return;
  double padding = source.sensing->self_padding;
  for (const auto& [link, of_link] : source.sensing->link_padding) padding = std::max(padding, of_link);
  const double seen_from = padding + std::sqrt(3.0) * source.sensing->resolution;
  if (seen_from < stop_distance) return;
  std::string text = "sensed_stop_distance is " + scene::shortest(stop_distance) + ", not above ";
  system::appendRounded(text, seen_from, 3);
  throw std::invalid_argument(text + ", the self padding of " + source.text() + " plus the diagonal of its voxels");
}

/// Throws std::invalid_argument for a robot that does not exist.
scene::FrameSpeeds baseSpeedsOf(const scene::RobotModel& robot, const Config& config) {
  scene::FrameSpeeds speeds = scene::frameSpeedsFrom(config.base_speed, "parameter base_speed");
  for (const auto& [name, speed] : speeds)
    if (name != scene::kOthers && scene::findNamed(robot.robots, name) < 0)
      throw std::invalid_argument("parameter base_speed: there is no robot " +
                                  scene::unknownName(name, scene::namesOf(robot.robots)));
  return speeds;
}

/// The columns of the named joints; of all joints if none is named.
std::vector<int> constraintColumnsOf(const scene::RobotModel& robot, const std::vector<std::string>& joints) {
  const scene::DegreesOfFreedom all(robot);
  std::vector<bool> moves(static_cast<std::size_t>(all.size()), joints.empty());
  for (const std::string& name : joints) {
    const std::string parameter = "parameter constraint_joints: '" + name + "': ";
    const int joint = movableJoint(robot, name, parameter);
    if (robot.joints[joint].mimic)
      throw std::invalid_argument(parameter + "the joint follows '" + robot.joints[robot.leaderOf(joint).joint].name +
                                  "': name that one");
    const scene::DegreesOfFreedom::Columns& own = all.columnsOf(joint);
    std::fill_n(moves.begin() + own.first, own.count, true);
  }
  std::vector<int> columns;
  for (int column = 0; column < all.size(); ++column)
    if (moves[column]) columns.push_back(column);
  return columns;
}

/// Returns for each robot the index of the edge to its root, see Robot::tfEdges().
std::vector<int> rootEdgesOf(const Robot& robot) {
  std::vector<int> edges;
  int next = static_cast<int>(robot.robotModel().joints.size());
  for (int i = 0; i < static_cast<int>(robot.sources().size()); ++i)
    edges.push_back(i == robot.referenceRobot() ? -1 : next++);
  return edges;
}

}  // namespace

Robot::Robot(const ros::NodeHandle& nh, const Config& config) : Robot(textsOf(nh, config), config) {
  for (RobotSource& source : sources_) source.joint_states = nh.resolveName(source.joint_states);
}

Robot::Robot(const std::string& urdf, const std::string& srdf, const Config& config)
    : Robot({RobotTexts{urdf, srdf}}, config) {}

Robot::Robot(const std::vector<RobotTexts>& texts, const Config& config)
    : config_(config),
      sources_(robotSources(config)),
      texts_(texts),
      model_(loadSceneModel(texts, config)),
      frames_(framesOf(model_->robot, sources_)),
      candidates_(model_->pairs),
      candidate_bodies_(bodiesOf(model_->robot, candidates_.list())),
      reference_link_(referenceLinkOf(model_->robot, frames_, config)),
      reference_frame_(reference_link_ < 0 ? config.reference_frame : frameOf(reference_link_)),
      tf_edges_(std::make_shared<const std::vector<TfEdge>>(edgesOf(*this))),
      root_edges_(rootEdgesOf(*this)),
      max_decelerations_(limitsOf(model_->robot, config.max_deceleration, "max_deceleration")),
      max_accelerations_(limitsOf(model_->robot, config.max_acceleration, "max_acceleration")),
      tracking_errors_(limitsOf(model_->robot, config.tracking_error, "tracking_error")),
      tracking_velocity_errors_(limitsOf(model_->robot, config.tracking_velocity_error, "tracking_velocity_error")),
      uncertainty_(config.uncertaintyOf(model_->robot)),
      is_uncertain_(!uncertainty_.isZero() || config.pose_latency != PoseLatency::Off),
      base_speeds_(baseSpeedsOf(model_->robot, config)),
      object_speeds_(scene::frameSpeedsFrom(config.object_speed, "parameter object_speed")),
      constraint_columns_(constraintColumnsOf(model_->robot, config.constraint_joints)),
      thresholds_(std::make_shared<const Thresholds>(
          Thresholds{config.thresholdsOf(model_->robot, srdfsOf(texts), config.monitor), config.monitor})),
      objects_(std::make_unique<ObjectSlot>(noObjects(model_, reference_link_, config.free_objects))),
      scenes_(std::make_unique<ScenePool>(model_)) {
  useDefaults(config.monitor);
  for (const TrackedSource& source : config.tracked) {
    const std::string parameter = "parameter " + source.kind() + ": ";
    if (model_->robot.findLink(source.name) >= 0)
      throw std::invalid_argument(parameter + "name is " + scene::quoted(source.name) + ", that of a link");
    if (!source.sensing) continue;
    for (const auto& [link, padding] : source.sensing->link_padding)
      if (model_->robot.findLink(link) < 0)
        throw std::invalid_argument(parameter + "link_self_padding: there is no link " +
                                    scene::unknownName(link, scene::namesOf(model_->robot.links)));
  }
}

scene::LevelThresholds Robot::thresholdsWith(const scene::Objects& objects) const {
  const auto now = std::atomic_load(&thresholds_);
  scene::LevelThresholds thresholds = *now;
  assignTracked(config_.tracked, objects, now->usual, thresholds);
  return thresholds;
}

void Robot::useDefaults(const MonitorSettings& settings) const {
  const auto next = std::make_shared<Thresholds>(*std::atomic_load(&thresholds_));
  assignDefaults(*next, settings);
  next->usual = settings;
  const scene::RobotModel& model = robotModel();
  scene::requireOrder(model, *next);
  const auto require = [&](double stop, double by_default, const std::string& who) {
    if (stop != by_default && stop >= settings.influence_distance)
      throw std::invalid_argument("the stop distance of " + who + " is " + scene::shortest(stop) +
                                  ", not below influence_distance, which is " +
                                  scene::shortest(settings.influence_distance));
  };
  for (const scene::ShapeRefPair& pair : candidates_)
    require(next->stop.of(pair), next->stop.links, nameOf(pair.a, model) + " - " + nameOf(pair.b, model));
  for (int link = 0; link < static_cast<int>(model.links.size()); ++link)
    require(next->stop.of({{link}, scene::ShapeRef::ofObject(0)}), next->stop.objects,
            model.links[link].name + " and objects");
  for (const TrackedSource& source : config_.tracked) requireSeenBefore(source, settings.sensed_stop_distance);
  std::atomic_store(&thresholds_, std::shared_ptr<const Thresholds>(next));
}

int Robot::linkOfFrame(const std::string& frame) const { return findFrame(robotModel(), frames_, frame); }

int Robot::referenceRobot() const {
  return reference_link_ < 0 ? -1 : robotModel().bodies[robotModel().links[reference_link_].body].robot;
}

std::vector<scene::ShapeRefPair> Robot::pairsOfGroup(const std::string& group) const {
  scene::PairFilterOptions filter = config_.filter;
  filter.group = group;
  return scene::Candidates(scene::filterPairs(robotModel(), srdfsOf(texts_), filter)).list();
}

void assignTracked(const std::vector<TrackedSource>& tracked, const scene::Objects& objects,
                   const scene::LevelDistances& distances, scene::LevelThresholds& thresholds) {
  thresholds.stop.forgetObjects();
  thresholds.warn.forgetObjects();
  for (const TrackedSource& source : tracked) {
    const int number = objects.find(source.name);
    if (number < 0) continue;
    const bool is_sensed = source.sensing.has_value();
    thresholds.stop.setObject(number, is_sensed ? distances.sensed_stop_distance : distances.tracked_stop_distance);
    thresholds.warn.setObject(number, is_sensed ? distances.sensed_warn_distance : distances.tracked_warn_distance);
  }
}

std::vector<int> bodiesOf(const scene::RobotModel& robot, const std::vector<scene::ShapeRefPair>& pairs) {
  std::vector<bool> is_in_pairs(robot.bodies.size(), false);
  for (const scene::ShapeRefPair& pair : pairs) {
    for (const int link : {pair.a.link(), pair.b.link()})
      if (link >= 0) is_in_pairs[robot.links[link].body] = true;
  }
  std::vector<int> bodies;
  for (std::size_t body = 0; body < is_in_pairs.size(); ++body)
    if (is_in_pairs[body]) bodies.push_back(static_cast<int>(body));
  return bodies;
}

}  // namespace proximity_server::node
