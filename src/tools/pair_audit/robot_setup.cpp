#include "tools/pair_audit/robot_setup.h"

#include "proximity_server/scene/files/file_value.h"
#include "proximity_server/scene/files/xml_declarations.h"
#include "system/whole_file.h"
#include "tools/robot/robot_files.h"
#include "tools/text/csv.h"

#include <tinyxml2.h>

#include <algorithm>
#include <filesystem>
#include <stdexcept>

namespace proximity_server::tools {
namespace {

namespace fs = std::filesystem;

struct SetupFile {
  const char* name;
  std::string text;
};

const char* const kLaunch = R"text(<launch>
  <!-- Starts the node with the thresholds of proximity.yaml. The joints of the robot must be in tf, as your driver and
       robot_state_publisher make them; or try it without a robot: simulate:=true. -->
  <arg name="description" default="true" doc="false: your own launch file sets robot_description and its SRDF"/>
  <arg name="simulate" default="false" doc="true: no robot is there; its joints stand as rest.yaml says"/>
  <arg name="config" default="$(dirname)/proximity.yaml" doc="its parameters"/>

  <group if="$(arg description)">
    <param name="robot_description" textfile="$(dirname)/robot.urdf"/>
    <param name="robot_description_semantic" textfile="$(dirname)/robot.srdf"/>
  </group>
  <include file="$(find proximity_server)/launch/proximity.launch">
    <arg name="config" value="$(arg config)"/>
  </include>
  <group if="$(arg simulate)">
    <node name="robot_state_publisher" pkg="robot_state_publisher" type="robot_state_publisher"/>
    <node name="rest" pkg="proximity_server" type="demo_motion">
      <rosparam command="load" file="$(dirname)/rest.yaml"/>
    </node>
  </group>
</launch>
)text";

const char* const kTest = R"text(<launch>
  <!-- The robot stands still as rest.yaml says, and the node must find it no worse than it was when this was written. -->
  <include file="$(dirname)/proximity.launch">
    <arg name="simulate" value="true"/>
  </include>
  <test test-name="robot_at_rest" pkg="proximity_server" type="clearancetest" time-limit="120">
    <param name="worst_level" value="LEVEL"/>
    <param name="duration" value="3"/>
    <param name="wait_time" value="90"/>
    <param name="max_invalid" value="0.5"/>
    <rosparam param="moving_joints">[]</rosparam>
  </test>
</launch>
)text";

const char* const kPackage = R"text(<?xml version="1.0"?>
<package format="2">
  <name>NAME</name>
  <version>0.0.0</version>
  <description>What proximity_server needs for one robot, as pair_audit has made it.</description>
  <maintainer email="nobody@example.org">nobody</maintainer>
  <license>as the robot description</license>
  <buildtool_depend>catkin</buildtool_depend>
  <exec_depend>proximity_server</exec_depend>
  <exec_depend>robot_state_publisher</exec_depend>
  <test_depend>rostest</test_depend>
</package>
)text";

const char* const kCMake = R"text(cmake_minimum_required(VERSION 3.0.2)
project(NAME)
find_package(catkin REQUIRED)
catkin_package()
install(FILES robot.urdf robot.srdf proximity.yaml rest.yaml proximity.launch DESTINATION ${CATKIN_PACKAGE_SHARE_DESTINATION})
if(CATKIN_ENABLE_TESTING)
  find_package(rostest REQUIRED)
  add_rostest(proximity.test)
endif()
)text";

std::string replaced(std::string text, const std::string& word, const std::string& by) {
  return text.replace(text.find(word), word.size(), by);
}

/// The name of the folder as the name of a package: lower case letters, digits and underscores.
std::string packageName(const fs::path& folder) {
  const fs::path whole = fs::absolute(folder).lexically_normal();
  std::string name = (whole.has_filename() ? whole : whole.parent_path()).filename();
  for (char& c : name) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
    if (!(c >= 'a' && c <= 'z') && !(c >= '0' && c <= '9')) c = '_';
  }
  return name.empty() || name[0] < 'a' ? "robot_" + name : name;
}

/// Makes the URIs of meshes absolute that are relative to a folder. Returns whether there are any.
bool makeMeshesAbsolute(tinyxml2::XMLElement& element, const fs::path& folder) {
  bool changed = false;
  const char* file = std::string(element.Name()) == "mesh" ? element.Attribute("filename") : nullptr;
  if (file && std::string(file).find("://") == std::string::npos) {
    element.SetAttribute("filename", ("file://" + (folder / file).string()).c_str());
    changed = true;
  }
  for (auto* child = element.FirstChildElement(); child; child = child->NextSiblingElement()) {
    changed = makeMeshesAbsolute(*child, folder) || changed;
  }
  return changed;
}

/// The URDF with meshes that are found from anywhere: the node gets its text, and not its folder.
std::string urdfText(const std::string& path) {
  const std::string text = readTextFile(path);
  tinyxml2::XMLDocument document;
  document.Parse(scene::withoutLateDeclarations(text).c_str());
  tinyxml2::XMLElement* root = document.RootElement();
  if (!root || !makeMeshesAbsolute(*root, fs::absolute(path).parent_path())) return text;
  tinyxml2::XMLPrinter printer;
  document.Print(&printer);
  return printer.CStr();
}

std::string restText(const scene::RobotModel& robot, const RestState& rest) {
  std::string names, positions;
  for (const scene::JointRange& range : scene::jointRanges(robot)) {
    names += (names.empty() ? "" : ", ") + scene::yamlName(robot.joints[range.joint].name);
    positions += ", " + shortest(rest.positions[range.joint]);
  }
  return "# A state in which the level is " + std::string(toString(rest.level)) +
         ", for demo_motion: the same positions at two times [s].\njoints: [" + names + "]\nkeyframes:\n- [0" +
         positions + "]\n- [1" + positions + "]\n";
}

std::vector<SetupFile> setupFiles(const std::string& folder, const scene::RobotModel& robot, const RobotSetup& setup) {
  const std::string package = packageName(folder);
  // A test that demanded what nobody can have would be of no use.
  const scene::ClearanceLevel demanded = std::min(setup.rest.level, scene::ClearanceLevel::Stop);
  return {{"robot.urdf", urdfText(setup.urdf_path)},
          {"robot.srdf", setup.srdf},
          {"proximity.yaml", setup.parameters},
          {"rest.yaml", restText(robot, setup.rest)},
          {"proximity.launch", kLaunch},
          {"proximity.test", replaced(kTest, "LEVEL", toString(demanded))},
          {"package.xml", replaced(kPackage, "NAME", package)},
          {"CMakeLists.txt", replaced(kCMake, "NAME", package)}};
}

}  // namespace

RestState restState(const std::vector<scene::Positions>& states, const LevelShares& shares, Rest rest) {
  const std::vector<scene::ClearanceLevel>& levels = shares.of_states;
  const auto is_usable = [](scene::ClearanceLevel level) { return level <= scene::ClearanceLevel::Warn; };
  const auto usual = std::find_if(levels.begin(), levels.begin() + 2, is_usable);
  const auto found = usual != levels.begin() + 2 ? usual : std::min_element(levels.begin(), levels.end());
  const auto chosen = rest == Rest::Chosen ? levels.begin() : found;
  return {states[chosen - levels.begin()], *chosen};
}

void requireEmpty(const std::string& folder) {
  if (!fs::exists(folder)) return;
  if (!fs::is_directory(folder)) throw std::invalid_argument(folder + ": is not a folder");
  const fs::directory_iterator first(folder);
  if (first == fs::directory_iterator()) return;
  throw std::invalid_argument(first->path().string() + ": is there already, and --setup overwrites nothing");
}

void writeSetup(const std::string& folder, const scene::RobotModel& robot, const RobotSetup& setup) {
  requireEmpty(folder);
  std::error_code failed;
  fs::create_directories(folder, failed);
  if (failed) throw std::invalid_argument(folder + ": cannot be made (" + failed.message() + ")");
  for (const SetupFile& file : setupFiles(folder, robot, setup))
    system::replaceFile(fs::path(folder) / file.name, file.text);
}

}  // namespace proximity_server::tools
