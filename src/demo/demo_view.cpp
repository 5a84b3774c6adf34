// Shows the robot of robot_description in RViz. It moves the camera in a view from a file so that the robot fills the
// window, whatever size the robot has, and then replaces itself by RViz. usage: demo_view FILE.rviz [options of rviz]
#include "node/log_fatal.h"
#include "proximity_server/scene/loading/load_robot_model.h"
#include "proximity_server/scene/model/kinematics.h"
#include "proximity_server/scene/model/names.h"
#include "proximity_server/scene/model/robot_box.h"

#include <ros/ros.h>
#include <unistd.h>
#include <Eigen/Geometry>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <regex>
#include <sstream>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace {

using proximity_server::scene::RobotModel;
using proximity_server::scene::shortest;

std::string descriptionOf(const ros::NodeHandle& nh) {
  std::string urdf;
  if (!nh.getParam("robot_description", urdf)) throw std::invalid_argument("there is no parameter robot_description");
  return urdf;
}

/// Returns whether a mesh file of the URDF is missing. Many packages have only the meshes of <collision> elements, and
/// RViz draws nothing for a missing mesh.
bool lacksMeshes(const std::string& urdf) {
  const auto resolve = proximity_server::scene::packageResolver(proximity_server::scene::rosPackagePath());
  const std::regex mesh("<mesh\\s[^>]*filename\\s*=\\s*[\"']([^\"']+)[\"']");
  const auto is_missing = [&](const std::smatch& match) {
    try {
      resolve(match[1]);
      return false;
    } catch (const std::invalid_argument&) {
      return true;
    }
  };
  return std::any_of(std::sregex_iterator(urdf.begin(), urdf.end(), mesh), std::sregex_iterator(), is_missing);
}

RobotModel loadRobot(const std::string& urdf) {
  proximity_server::scene::ModelOptions options;
  options.mesh_tolerance = 1.0;  // [m] large, because the hulls of meshes are enough for a view
  options.allow_missing_meshes = true;
  options.allow_broken_mimics = true;  // the node decides whether these are an error
  using namespace proximity_server::scene;
  return loadRobotModel(urdf, packageResolver(rosPackagePath()), options);
}

/// The box around the robot and the texts above it, in the frame of its root. It contains the robot with all joints at
/// 0 (or at the limit nearest to 0), and with all joints in the middle of their limits.
Eigen::AlignedBox3d boxOf(const RobotModel& robot) {
  std::vector<double> near_zero, middle;
  for (const auto& joint : robot.joints) {
    near_zero.push_back(std::max(joint.lower, std::min(0.0, joint.upper)));
    const bool limited = std::isfinite(joint.lower) && std::isfinite(joint.upper);
    middle.push_back(limited ? 0.5 * (joint.lower + joint.upper) : 0.0);
  }
  const proximity_server::scene::RobotBox of_robot(robot);
  Eigen::AlignedBox3d box = of_robot.at(forwardKinematics(robot, near_zero));
  box.extend(of_robot.at(forwardKinematics(robot, middle)));
  if (box.isEmpty()) box = Eigen::AlignedBox3d(Eigen::Vector3d::Constant(-0.5), Eigen::Vector3d::Constant(0.5));
  constexpr double kTexts = 0.2;  // height of the texts relative to the diagonal, see ClearanceMarkers
  box.max().z() += kTexts * box.diagonal().norm();
  return box;
}

/// The largest number not above `length` that is 1, 2 or 5 times a power of ten.
double roundLength(double length) {
  const double power = std::pow(10.0, std::floor(std::log10(length)));
  return power * (length >= 5.0 * power ? 5.0 : length >= 2.0 * power ? 2.0 : 1.0);
}

/// Replaces the value in each line "KEY: VALUE" of this key. Throws std::invalid_argument if there is no such line.
void replaceValue(std::vector<std::string>& lines, const std::string& key, const std::string& value) {
  bool found = false;
  for (std::string& line : lines) {
    const std::size_t begin = line.find_first_not_of(" -");
    if (begin == std::string::npos || line.compare(begin, key.size() + 1, key + ":") != 0) continue;
    line = line.substr(0, begin) + key + ": " + value;
    found = true;
  }
  if (!found) throw std::invalid_argument("the view has no line '" + key + ": ...'");
}

/// Returns the view of `file` with the camera at such a distance that a ball around the box fills the height of the
/// window.
std::string viewOf(const std::string& file, const std::string& urdf) {
  const RobotModel robot = loadRobot(urdf);
  std::ifstream stream(file);
  if (!stream) throw std::invalid_argument("cannot read " + file);
  std::vector<std::string> lines;
  for (std::string line; std::getline(stream, line);) lines.push_back(line);

  const Eigen::AlignedBox3d box = boxOf(robot);
  const double radius = 0.5 * box.diagonal().norm();
  const double half_of_view = M_PI / 8.0;  // cameras of RViz see 45 degrees
  const auto rounded = [](double number) { return shortest(std::round(1e3 * number) / 1e3 + 0.0); };  // 0.0 avoids "-0"
  const Eigen::Vector3d centre = box.center();
  const std::string& root = robot.links[robot.rootLink()].name;
  replaceValue(lines, "Distance", rounded(radius / std::sin(half_of_view)));
  replaceValue(lines, "Focal Point",
               "{X: " + rounded(centre.x()) + ", Y: " + rounded(centre.y()) + ", Z: " + rounded(centre.z()) + "}");
  replaceValue(lines, "Target Frame", "\"" + root + "\"");
  replaceValue(lines, "Fixed Frame", "\"" + root + "\"");
  if (lacksMeshes(urdf)) replaceValue(lines, "Collision Enabled", "true");
  replaceValue(lines, "Cell Size", shortest(roundLength(0.2 * radius)));
  std::string text;
  for (const std::string& line : lines) text += line + "\n";
  return text;
}

/// The folder in which nodes may write.
std::filesystem::path rosHome() {
  const char* const home = std::getenv("ROS_HOME");
  if (home && *home) return home;
  const char* const user = std::getenv("HOME");
  return std::filesystem::path(user ? user : "/tmp") / ".ros";
}

/// Writes the view of `file` for the robot into the folder of ROS; returns the path of the new file.
std::string writeView(const std::string& file) {
  const std::filesystem::path path = rosHome() / "proximity_server_demo.rviz";
  const std::string view = viewOf(file, descriptionOf(ros::NodeHandle()));
  std::filesystem::create_directories(path.parent_path());
  if (!(std::ofstream(path) << view).flush()) throw std::runtime_error("cannot write " + path.string());
  return path;
}

}  // namespace

int main(int argc, char** argv) {
  std::vector<std::string> rviz_arguments(argv + 1,
                                          argv + argc);  // ros::init() takes remappings off argv, but RViz needs them
  ros::init(argc, argv, "demo_view", ros::init_options::AnonymousName);
  try {
    if (argc < 2) throw std::invalid_argument("usage: demo_view FILE.rviz [options of rviz]");
    rviz_arguments.erase(rviz_arguments.begin());
    const std::string view = writeView(argv[1]);
    std::vector<std::string> words{"rviz", "-d", view};
    words.insert(words.end(), rviz_arguments.begin(), rviz_arguments.end());
    std::vector<char*> arguments;
    for (std::string& word : words) arguments.push_back(word.data());
    arguments.push_back(nullptr);
    execvp("rviz", arguments.data());
    throw std::runtime_error(std::string("cannot start rviz (") + std::strerror(errno) + ")");
  } catch (const std::exception& error) {
    proximity_server::node::logFatal(error.what());
    ros::shutdown();
    return 1;
  }
}
