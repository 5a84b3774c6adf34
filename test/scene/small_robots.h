#pragma once

#include <Eigen/Geometry>
#include <sstream>
#include <string>
#include <vector>

#include "chance.h"
#include "proximity_server/scene/loading/load_robot_model.h"
#include "proximity_server/scene/model/kinematics.h"
#include "proximity_server/scene/model/robot_model.h"

namespace proximity_server::scene {

inline Eigen::Isometry3d at(double x, double y, double z) { return Eigen::Isometry3d(Eigen::Translation3d(x, y, z)); }

/// A pose with its origin at `origin`, turned by `angle` [rad] about an axis that need not be of unit length.
inline Eigen::Isometry3d turned(double angle, const Eigen::Vector3d& axis,
                                const Eigen::Vector3d& origin = Eigen::Vector3d::Zero()) {
  return Eigen::Translation3d(origin) * Eigen::AngleAxisd(angle, axis.normalized());
}

// --- <collision> elements of a URDF

inline std::string collision(const std::string& geometry, const std::string& xyz, const std::string& rpy = "0 0 0") {
  return "<collision><origin xyz='" + xyz + "' rpy='" + rpy + "'/><geometry>" + geometry + "</geometry></collision>";
}
inline std::string ball(const std::string& radius, const std::string& xyz = "0 0 0") {
  return collision("<sphere radius='" + radius + "'/>", xyz);
}
inline std::string box(const std::string& size, const std::string& xyz = "0 0 0", const std::string& rpy = "0 0 0") {
  return collision("<box size='" + size + "'/>", xyz, rpy);
}
inline std::string cylinder(const std::string& radius, const std::string& length, const std::string& xyz = "0 0 0",
                            const std::string& rpy = "0 0 0") {
  return collision("<cylinder radius='" + radius + "' length='" + length + "'/>", xyz, rpy);
}

// --- robots

/// A robot without meshes.
inline RobotModel robotOf(const std::string& urdf) { return loadRobotModel(urdf, packageResolver({})); }

/// Links "0", "1", ... that float freely in the frame of the link "frame", which has no geometry.
inline RobotModel floatingLinks(const std::vector<std::string>& collisions_of_links) {
  std::ostringstream urdf;
  urdf << "<robot name='floating links'><link name='frame'/>";
  for (std::size_t i = 0; i < collisions_of_links.size(); ++i) {
    urdf << "<link name='" << i << "'>" << collisions_of_links[i] << "</link><joint name='joint" << i
         << "' type='floating'><parent link='frame'/><child link='" << i << "'/></joint>";
  }
  urdf << "</robot>";
  return robotOf(urdf.str());
}

inline int bodyOf(const RobotModel& robot, const std::string& link) { return robot.links[robot.findLink(link)].body; }

/// The poses of a robot of floating links, in the order of their names; the frame stands at the origin.
inline BodyPoses posesOf(const RobotModel& robot, const std::vector<Eigen::Isometry3d>& poses_of_links) {
  BodyPoses poses(robot.bodies.size(), Eigen::Isometry3d::Identity());
  for (std::size_t i = 0; i < poses_of_links.size(); ++i) poses[bodyOf(robot, std::to_string(i))] = poses_of_links[i];
  return poses;
}

}  // namespace proximity_server::scene
