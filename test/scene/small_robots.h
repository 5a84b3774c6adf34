#pragma once

#include "chance.h"
#include "proximity_server/scene/filter/pair_filter.h"
#include "proximity_server/scene/loading/load_robot_model.h"
#include "proximity_server/scene/model/kinematics.h"
#include "proximity_server/scene/model/robot_model.h"
#include "proximity_server/scene/scene_model/scene_model.h"
#include "proximity_server/scene/scene_model/shape_ref.h"
#include "robots/urdf.h"

#include <Eigen/Geometry>

#include <map>
#include <memory>
#include <string>
#include <vector>

namespace proximity_server::scene {

inline Eigen::Isometry3d at(double x, double y, double z) { return Eigen::Isometry3d(Eigen::Translation3d(x, y, z)); }

/// A pose with its origin at `origin`, turned by `angle` [rad] about an axis that need not be of unit length.
inline Eigen::Isometry3d turned(double angle, const Eigen::Vector3d& axis,
                                const Eigen::Vector3d& origin = Eigen::Vector3d::Zero()) {
  return Eigen::Translation3d(origin) * Eigen::AngleAxisd(angle, axis.normalized());
}

using namespace robots;

// --- robots

/// A robot; the files of its meshes are named by their absolute paths.
inline RobotModel robotOf(const std::string& urdf, const ModelOptions& options = {}) {
  return loadRobotModel(urdf, packageResolver({}), options);
}

/// Links "0", "1", ... that float freely in the frame of the link "frame", which has no geometry.
inline RobotModel floatingLinks(const std::vector<std::string>& collisions_of_links, const ModelOptions& options = {}) {
  std::string parts = link("frame");
  for (std::size_t i = 0; i < collisions_of_links.size(); ++i) {
    const std::string name = std::to_string(i);
    parts += link(name, collisions_of_links[i]) + joint("joint" + name, "floating", "frame", name);
  }
  return robotOf(urdfOf(parts, "floating links"), options);
}

/// The robot with the pairs that the filter leaves without an SRDF.
inline std::shared_ptr<const SceneModel> modelOf(RobotModel robot, const PairFilterOptions& options = {}) {
  PairTable pairs = filterPairs(robot, std::vector<std::string>(robot.robots.size()), options);
  return std::make_shared<const SceneModel>(SceneModel{std::move(robot), std::move(pairs)});
}
inline std::shared_ptr<const SceneModel> modelOf(const std::string& urdf, const PairFilterOptions& options = {}) {
  return modelOf(robotOf(urdf), options);
}

inline ShapeRefPair pairOf(const SceneModel& model, const std::string& a, const std::string& b) {
  return {{model.robot.findLink(a)}, {model.robot.findLink(b)}};
}

/// One number for each joint, in their order, and 0 for those that are not named.
inline std::vector<double> byJoint(const RobotModel& robot, const std::map<std::string, double>& by_name) {
  std::vector<double> values;
  for (const Joint& joint : robot.joints) {
    const auto found = by_name.find(joint.name);
    values.push_back(found == by_name.end() ? 0.0 : found->second);
  }
  return values;
}

inline int bodyOf(const RobotModel& robot, const std::string& link) { return robot.links[robot.findLink(link)].body; }

/// The poses of a robot of floating links, in the order of their names; the frame stands at the origin.
inline BodyPoses posesOf(const RobotModel& robot, const std::vector<Eigen::Isometry3d>& poses_of_links) {
  BodyPoses poses(robot.bodies.size(), Eigen::Isometry3d::Identity());
  for (std::size_t i = 0; i < poses_of_links.size(); ++i) poses[bodyOf(robot, std::to_string(i))] = poses_of_links[i];
  return poses;
}

}  // namespace proximity_server::scene
