#pragma once

#include "proximity_server/scene/loading/load_robot_model.h"
#include "proximity_server/scene/model/joint_ranges.h"
#include "proximity_server/scene/motion/joint_spline.h"

#include <string>
#include <vector>

namespace proximity_server::tools {

/// "elbow" from -2 to 3 rad, "lift" from 0 to 0.5 m, "wheel" without limits, "finger" that follows the lift, "weld"
/// that is fixed, and "base" that floats.
inline const char* const kArm = R"(<robot name="arm">
  <link name="world"/><link name="a"/><link name="b"/><link name="c"/><link name="d"/><link name="e"/><link name="f"/>
  <joint name="base" type="floating"><parent link="world"/><child link="a"/></joint>
  <joint name="elbow" type="revolute"><parent link="a"/><child link="b"/>
    <limit lower="-2" upper="3" effort="1" velocity="1"/></joint>
  <joint name="lift" type="prismatic"><parent link="b"/><child link="c"/>
    <limit lower="0" upper="0.5" effort="1" velocity="1"/></joint>
  <joint name="wheel" type="continuous"><parent link="c"/><child link="d"/></joint>
  <joint name="finger" type="prismatic"><parent link="d"/><child link="e"/>
    <limit lower="0" upper="0.5" effort="1" velocity="1"/><mimic joint="lift"/></joint>
  <joint name="weld" type="fixed"><parent link="e"/><child link="f"/></joint>
</robot>)";

inline const scene::RobotModel& arm() {
  static const scene::RobotModel model = scene::loadRobotModel(kArm, scene::packageResolver({}));
  return model;
}

/// Index of a joint of the arm.
inline int joint(const std::string& name) {
  for (std::size_t i = 0; i < arm().joints.size(); ++i)
    if (arm().joints[i].name == name) return static_cast<int>(i);
  return -1;
}

/// A state of the arm.
inline scene::Positions at(double elbow, double lift, double wheel) {
  scene::Positions positions(arm().joints.size(), 0.0);
  positions[joint("elbow")] = elbow;
  positions[joint("lift")] = lift;
  positions[joint("wheel")] = wheel;
  return positions;
}

/// All states that are left.
template <typename Source>
std::vector<scene::Positions> restOf(Source&& source) {
  std::vector<scene::Positions> states;
  for (scene::TrajectoryPoint state; source.next(state);) states.push_back(state.positions);
  return states;
}

}  // namespace proximity_server::tools
