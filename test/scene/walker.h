#pragma once

#include "robots/urdf.h"
#include "scene/files.h"
#include "scene/solids.h"

#include <Eigen/Geometry>

#include <string>

namespace proximity_server::scene {

/// Two legs below a pelvis. Only the feet have <collision>; the five other links have a mesh as <visual>. Where all
/// joints are at 0 the thighs are 0.125 m apart, the shanks 0.1875 m and the feet 0.21875 m, and nothing else is nearer.
inline std::string walker(const TemporaryFiles& files) {
  using namespace robots;
  const auto visual = [&](const std::string& name, const Eigen::Vector3d& edges) {
    const Eigen::Vector3d low(-0.5 * edges.x(), -0.5 * edges.y(), -edges.z());
    return "<visual><geometry><mesh filename='file://" + files.write(name + ".stl", stlOf(boxMesh(low, edges))) +
           "'/></geometry></visual>";
  };
  const std::string pelvis = visual("pelvis", {0.25, 0.375, 0.25}), thigh = visual("thigh", {0.125, 0.125, 0.5}),
                    shank = visual("shank", {0.0625, 0.0625, 0.5});
  const auto turning = [](const std::string& name, const std::string& parent, const std::string& child,
                          const std::string& xyz) {
    return joint(name, "revolute", parent, child, origin(xyz) + axis("0 1 0") + limits("-1", "1"));
  };
  std::string parts = link("pelvis", pelvis);
  for (const auto& [side, y] : {std::pair("left_", "0.125"), std::pair("right_", "-0.125")}) {
    const std::string own = side;
    parts += link(own + "thigh", thigh) + link(own + "shank", shank) + link(own + "foot", box("0.2 0.03125 0.05"));
    parts += turning(own + "hip", "pelvis", own + "thigh", "0 " + std::string(y) + " -0.5") +
             turning(own + "knee", own + "thigh", own + "shank", "0 0 -0.75") +
             turning(own + "ankle", own + "shank", own + "foot", "0 0 -0.75");
  }
  return urdfOf(parts, "walker");
}

/// Its groups, one of which has the name of a link.
const std::string kWalkerGroups =
    "<robot name='walker'><group name='left_leg'><chain base_link='pelvis' tip_link='left_foot'/></group>"
    "<group name='right_leg'><chain base_link='pelvis' tip_link='right_foot'/></group>"
    "<group name='legs'><group name='left_leg'/><group name='right_leg'/></group>"
    "<group name='left_thigh'><group name='legs'/></group></robot>";

}  // namespace proximity_server::scene
