#pragma once

#include <string>
#include <vector>

// The parts of a URDF, for the robots of tests. Robots that launch files load are the .urdf files beside this one.

namespace proximity_server::robots {

// --- <collision> elements

inline std::string collision(const std::string& geometry, const std::string& xyz = "0 0 0",
                             const std::string& rpy = "0 0 0") {
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
inline std::string mesh(const std::string& file, const std::string& xyz = "0 0 0") {
  return collision("<mesh filename='file://" + file + "'/>", xyz);
}

// --- links and joints

inline std::string link(const std::string& name, const std::string& collisions = "") {
  return "<link name='" + name + "'>" + collisions + "</link>";
}

/// `more`: the elements origin(), axis(), limits() and mimic(), as far as the joint has them.
inline std::string joint(const std::string& name, const std::string& type, const std::string& parent,
                         const std::string& child, const std::string& more = "") {
  return "<joint name='" + name + "' type='" + type + "'><parent link='" + parent + "'/><child link='" + child + "'/>" +
         more + "</joint>";
}
inline std::string origin(const std::string& xyz, const std::string& rpy = "0 0 0") {
  return "<origin xyz='" + xyz + "' rpy='" + rpy + "'/>";
}
inline std::string axis(const std::string& xyz) { return "<axis xyz='" + xyz + "'/>"; }
inline std::string limits(const std::string& lower, const std::string& upper, const std::string& velocity = "1") {
  return "<limit lower='" + lower + "' upper='" + upper + "' effort='1' velocity='" + velocity + "'/>";
}
inline std::string mimic(const std::string& leader, const std::string& multiplier = "1") {
  return "<mimic joint='" + leader + "' multiplier='" + multiplier + "'/>";
}

/// A prismatic joint from -9 m to 9 m.
inline std::string slider(const std::string& name, const std::string& parent, const std::string& child,
                          const std::string& xyz_of_axis, const std::string& xyz = "0 0 0") {
  return joint(name, "prismatic", parent, child, origin(xyz) + axis(xyz_of_axis) + limits("-9", "9"));
}
/// A joint that turns without limits.
inline std::string hinge(const std::string& name, const std::string& parent, const std::string& child,
                         const std::string& xyz_of_axis, const std::string& xyz = "0 0 0") {
  return joint(name, "continuous", parent, child, origin(xyz) + axis(xyz_of_axis));
}
inline std::string weld(const std::string& name, const std::string& parent, const std::string& child,
                        const std::string& xyz = "0 0 0") {
  return joint(name, "fixed", parent, child, origin(xyz));
}

// --- robots

inline std::string urdfOf(const std::string& links_and_joints, const std::string& name = "robot") {
  return "<robot name='" + name + "'>" + links_and_joints + "</robot>";
}

struct LinkOnRail {
  std::string name, collisions, start = "0 0 0";  ///< the start is its place on the rail where its joint is at 0
};

/// Links that slide along the x axis of the link "rail", each by the joint "to_" with its name. No two are neighbours.
inline std::string onRail(const std::vector<LinkOnRail>& links) {
  std::string parts = link("rail");
  for (const LinkOnRail& each : links)
    parts += link(each.name, each.collisions) + slider("to_" + each.name, "rail", each.name, "1 0 0", each.start);
  return urdfOf(parts, "sliders");
}

}  // namespace proximity_server::robots
