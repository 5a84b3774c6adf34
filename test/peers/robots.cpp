#include "peers/robots.h"

#include "proximity_server/scene/loading/load_robot_model.h"
#include "scene/example_robots.h"

#include <algorithm>
#include <cmath>
#include <iostream>
#include <regex>
#include <sstream>

namespace proximity_server::peers {

using namespace scene;
namespace {

constexpr int kMaxBodiesOfArm = 5;
constexpr double kSpacing = 1.0;  // [m] of the arms, which lean out by 0.7 at most
constexpr double kLength = 0.2;   // [m] from joint to joint

const std::string kDemoFolder = PROXIMITY_SOURCE_DIR "/config/demo/";

std::shared_ptr<const SceneModel> load(const std::string& urdf_file, const std::string& srdf_file,
                                       const MeshResolver& resolve) {
  auto model = std::make_shared<SceneModel>();
  model->robot = loadRobotModel(readFile(urdf_file), resolve, quickLoading());
  model->pairs = filterPairs(model->robot, readFile(srdf_file));
  return model;
}

std::string mesh(const std::string& file) {
  return "<mesh filename=\"file://" + kDemoFolder + "meshes/" + file + "\"/>";
}

std::string collision(double height, const std::string& geometry) {
  return "<collision><origin xyz=\"0 0 " + std::to_string(height) + "\"/><geometry>" + geometry +
         "</geometry></collision>";
}

/// Returns the <collision> elements of a body at its `place` in the arm, along z from its joint.
std::string collisionsAt(int place) {
  switch (place) {
    case 0:
      return collision(0.1, "<cylinder radius=\"0.06\" length=\"0.14\"/>");
    case 1:
      return collision(0.1, "<cylinder radius=\"0.05\" length=\"0.06\"/>") +
             collision(0.07, "<sphere radius=\"0.05\"/>") + collision(0.13, "<sphere radius=\"0.05\"/>");
    case 2:
      return collision(0.1, "<box size=\"0.1 0.08 0.14\"/>");
    case 3:
      return collision(0.1, mesh("elbow.stl"));
    default:
      return collision(0.1, mesh("wrist.obj"));
  }
}

/// The first joint of an arm turns about z, on the spot of the grid that is the arm's.
std::string firstJoint(int arm, int arms_in_row) {
  const int column = arm % arms_in_row, row = arm / arms_in_row;
  std::ostringstream joint;
  joint << "<parent link=\"world\"/><origin xyz=\"" << kSpacing * column << " " << kSpacing * row
        << " 0\"/><axis xyz=\"0 0 1\"/><limit lower=\"-3\" upper=\"3\"";
  return joint.str();
}

/// The other joints bend the arm, about y and x by turns.
std::string nextJoint(int body, int place) {
  std::ostringstream joint;
  joint << "<parent link=\"b" << body - 1 << "\"/><origin xyz=\"0 0 " << kLength << "\"/><axis xyz=\""
        << (place % 2 == 1 ? "0 1 0" : "1 0 0") << "\"/><limit lower=\"-0.5\" upper=\"0.5\"";
  return joint.str();
}

std::string urdfOfArms(int bodies) {
  const int bodies_of_arm = std::min(kMaxBodiesOfArm, bodies - 1);
  const int arms = (bodies + bodies_of_arm - 1) / bodies_of_arm;
  const int arms_in_row = static_cast<int>(std::ceil(std::sqrt(arms)));
  std::ostringstream urdf;
  urdf << "<robot name=\"arms\"><link name=\"world\"/>\n";
  for (int body = 0; body < bodies; ++body) {
    const int arm = body / bodies_of_arm, place = body % bodies_of_arm;
    urdf << "<link name=\"b" << body << "\">" << collisionsAt(place) << "</link>\n<joint name=\"j" << body
         << "\" type=\"revolute\">" << (place == 0 ? firstJoint(arm, arms_in_row) : nextJoint(body, place))
         << " velocity=\"2\" effort=\"1\"/><child link=\"b" << body << "\"/></joint>\n";
  }
  urdf << "</robot>";
  return urdf.str();
}

/// Returns the content of <robot>, with a prefix before the names of links and joints.
std::string prefixed(const std::string& xml, const std::string& prefix) {
  const std::size_t begin = xml.find('>', xml.find("<robot")) + 1, end = xml.rfind("</robot>");
  const std::regex names("(<link\\s+name=|<joint\\s+name=|<mimic\\s+joint=|\\slink1?=|\\slink2=)\"([^\"]*)\"");
  return std::regex_replace(xml.substr(begin, end - begin), names, "$1\"" + prefix + "$2\"");
}

std::string rootOf(const std::string& prefix, const std::string& root, const std::string& origin) {
  return "<joint name=\"" + prefix + "mount\" type=\"fixed\"><parent link=\"world\"/><child link=\"" + prefix + root +
         "\"/><origin " + origin + "/></joint>";
}

}  // namespace

std::vector<const Piece*> piecesOfLink(const RobotModel& robot, int link) {
  std::vector<const Piece*> pieces;
  const int body = robot.links[link].body;
  for (const int index : robot.bodies[body].pieces) {
    const Piece& piece = robot.pieces[index];
    if (robot.collisions[piece.collision].link == link) pieces.push_back(&piece);
  }
  return pieces;
}

NamedRobot demoRobot() {
  // Its meshes are in this package.
  return {"Demo",
          load(kDemoFolder + "robot.urdf", kDemoFolder + "robot.srdf", packageResolver({PROXIMITY_SOURCE_DIR}))};
}

std::optional<NamedRobot> exampleRobot(const ExampleRobot& robot) {
  const MeshResolver resolve = exampleRobotsResolver();
  if (!findsExampleRobots(resolve)) return std::nullopt;
  return NamedRobot{robot.name,
                    load(exampleRobotFile(resolve, robot.urdf), exampleRobotFile(resolve, robot.srdf), resolve)};
}

std::vector<NamedRobot> exampleRobots() {
  std::vector<NamedRobot> robots;
  for (const ExampleRobot& robot : kExampleRobots)
    if (const std::optional<NamedRobot> loaded = exampleRobot(robot)) robots.push_back(*loaded);
  return robots;
}

std::vector<NamedRobot> robotsToMeasure() {
  std::vector<NamedRobot> robots = exampleRobots();
  if (robots.empty()) std::cout << kExampleRobotsMissing << " Panda, UR5 and PR2 are left out.\n";
  robots.push_back(demoRobot());
  return robots;
}

std::optional<NamedRobot> twoPandas() {
  const MeshResolver resolve = exampleRobotsResolver();
  if (!findsExampleRobots(resolve)) return std::nullopt;
  const std::string urdf = readFile(exampleRobotFile(resolve, kExampleRobots[0].urdf));
  const std::string srdf = readFile(exampleRobotFile(resolve, kExampleRobots[0].srdf));
  const std::string disabled = std::regex_replace(srdf, std::regex("<group[^]*</group_state>|<end_effector[^>]*>"), "");
  const std::string root = "panda_link0";
  auto model = std::make_shared<SceneModel>();
  model->robot = loadRobotModel("<robot name=\"two_pandas\"><link name=\"world\"/>" + prefixed(urdf, "left/") +
                                    prefixed(urdf, "right/") + rootOf("left/", root, "xyz=\"0 0 0\"") +
                                    rootOf("right/", root, "xyz=\"0.8 0 0\" rpy=\"0 0 3.14159265358979\"") + "</robot>",
                                resolve, cachedLoading());
  model->pairs = filterPairs(model->robot, "<robot name=\"two_pandas\">" + prefixed(disabled, "left/") +
                                               prefixed(disabled, "right/") + "</robot>");
  return NamedRobot{"Two Pandas", model};
}

NamedRobot rowsOfArms(int bodies) {
  auto model = std::make_shared<SceneModel>();
  model->robot = loadRobotModel(urdfOfArms(bodies), packageResolver({}), cachedLoading());
  model->pairs = filterPairs(model->robot, "");
  return {std::to_string(bodies) + " bodies", model};
}

}  // namespace proximity_server::peers
