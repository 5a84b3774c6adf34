#include "proximity_server/scene/loading/joined_robots.h"

#include "proximity_server/scene/model/names.h"
#include "scene/loading/link_geometry.h"

#include <map>
#include <set>
#include <stdexcept>
#include <utility>

namespace proximity_server::scene {
namespace {

void requireName(const std::string& name, std::set<std::string>& names) {
  if (name.empty()) throw std::invalid_argument("a robot has an empty name");
  if (name.find('/') != std::string::npos) {
    throw std::invalid_argument("the name of the robot " + quoted(name) + " has a slash");
  }
  if (!names.insert(name).second) throw std::invalid_argument("two robots have the name " + quoted(name));
}

/// Converts an index in a robot's own model to an index in the whole model, in which `before` elements come first. -1
/// stays -1.
int shifted(int index, std::size_t before) { return index < 0 ? index : index + static_cast<int>(before); }

void shift(std::vector<int>& indices, std::size_t before) {
  for (int& index : indices) index = shifted(index, before);
}

/// Adds a robot after the robots that the model already has.
class Addition {
 public:
  Addition(RobotModel& whole, const NamedRobot& robot) : whole_(whole), robot_(robot.model) {
    member_ = {robot.name, robot.model.name};
    links_ = whole.links.size();
    joints_ = whole.joints.size();
    bodies_ = whole.bodies.size();
    collisions_ = whole.collisions.size();
    pieces_ = whole.pieces.size();
  }

  void addAll() {
    for (const Link& link : robot_.links) add(link);
    for (const Joint& joint : robot_.joints) add(joint);
    for (const Body& body : robot_.bodies) add(body);
    for (const Collision& collision : robot_.collisions) add(collision);
    for (Piece piece : robot_.pieces) {
      piece.collision = shifted(piece.collision, collisions_);
      whole_.pieces.push_back(std::move(piece));
    }
    for (const std::string& joint : robot_.fixed_joints) whole_.fixed_joints.push_back(member_.nameInModel(joint));
    for (const std::string& warning : robot_.warnings) whole_.warnings.push_back(member_.sentence(warning));
    whole_.name += (whole_.name.empty() ? "" : ", ") + member_.name + " (" + member_.urdf_name + ")";
    whole_.robots.push_back(member_);
  }

 private:
  void add(Link link) {
    link.name = member_.nameInModel(link.name);
    link.body = shifted(link.body, bodies_);
    link.parent = shifted(link.parent, links_);
    shift(link.collisions, collisions_);
    whole_.links.push_back(std::move(link));
  }

  void add(Joint joint) {
    joint.name = member_.nameInModel(joint.name);
    joint.parent_link = shifted(joint.parent_link, links_);
    joint.child_link = shifted(joint.child_link, links_);
    if (joint.mimic) joint.mimic->joint = shifted(joint.mimic->joint, joints_);
    whole_.joints.push_back(std::move(joint));
  }

  void add(Body body) {
    body.link = shifted(body.link, links_);
    body.joint = shifted(body.joint, joints_);
    body.parent = shifted(body.parent, bodies_);
    shift(body.links, links_);
    shift(body.pieces, pieces_);
    body.robot = static_cast<int>(whole_.robots.size());
    whole_.bodies.push_back(std::move(body));
  }

  void add(Collision collision) {
    collision.link = shifted(collision.link, links_);
    shift(collision.pieces, pieces_);
    whole_.collisions.push_back(std::move(collision));
  }

  RobotModel& whole_;
  const RobotModel& robot_;
  Member member_;
  /// the numbers of elements of the model before the addition
  std::size_t links_, joints_, bodies_, collisions_, pieces_;
};

/// The values of one robot's own links, by the names of its URDF.
std::map<std::string, double> ofRobot(const Member& robot, const std::map<std::string, double>& by_link) {
  std::map<std::string, double> own;
  const std::string begin = robot.nameInModel("");
  for (const auto& [link, value] : by_link) {
    if (link.compare(0, begin.size(), begin) == 0) own[robot.ownName(link)] = value;
  }
  return own;
}

/// The links of a list that are this robot's, by their own names.
std::vector<std::string> ofRobot(const Member& robot, const std::vector<std::string>& links) {
  std::vector<std::string> own;
  const std::string begin = robot.nameInModel("");
  for (const std::string& link : links) {
    if (link == kAllLinks) own.push_back(link);
    if (link.compare(0, begin.size(), begin) == 0) own.push_back(robot.ownName(link));
  }
  return own;
}

RobotModel loadOne(const NamedUrdf& robot, const MeshResolver& resolve, const ModelOptions& options) {
  const Member member{robot.name, ""};
  ModelOptions own = options;
  own.link_padding = ofRobot(member, options.link_padding);
  own.link_mesh_tolerance = ofRobot(member, options.link_mesh_tolerance);
  own.collision_from_visual = ofRobot(member, options.collision_from_visual);
  if (options.progress) own.progress = [&](const std::string& step) { options.progress(member.sentence(step)); };
  try {
    return loadRobotModel(robot.urdf_xml, resolve, own);
  } catch (const std::invalid_argument& error) {
    throw std::invalid_argument(member.sentence(error.what()));
  }
}

}  // namespace

RobotModel joined(const std::vector<NamedRobot>& robots) {
  if (robots.empty()) throw std::invalid_argument("there is no robot to join");
  std::set<std::string> names;
  for (const NamedRobot& robot : robots) {
    requireName(robot.name, names);
    if (robot.model.robots.size() != 1) throw std::invalid_argument(quoted(robot.name) + " are several robots");
  }
  RobotModel whole;
  whole.robots.clear();
  for (const NamedRobot& robot : robots) Addition(whole, robot).addAll();
  return whole;
}

RobotModel loadRobots(const std::vector<NamedUrdf>& robots, const MeshResolver& resolve, const ModelOptions& options) {
  if (robots.size() == 1 && robots.front().name.empty())
    return loadRobotModel(robots.front().urdf_xml, resolve, options);
  std::set<std::string> names;
  for (const NamedUrdf& robot : robots) requireName(robot.name, names);
  std::vector<NamedRobot> loaded;
  for (const NamedUrdf& robot : robots) loaded.push_back({robot.name, loadOne(robot, resolve, options)});
  RobotModel whole = joined(loaded);
  requireLinks(options, whole);
  return whole;
}

}  // namespace proximity_server::scene
