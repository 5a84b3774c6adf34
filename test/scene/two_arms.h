#pragma once

#include "scene/small_robots.h"

#include <string>

namespace proximity_server::scene {

// The links and joints of a robot with two arms, which have every kind of shape.

inline std::string tilted(const std::string& shape, const std::string& xyz) {
  return collision(shape, xyz, "0.3 -0.2 0.1");
}

inline std::string jointOfArm(const std::string& parent, const std::string& child, const std::string& xyz,
                              const std::string& xyz_of_axis) {
  return joint("to_" + child, "revolute", parent, child, origin(xyz) + axis(xyz_of_axis) + limits("-2.5", "2.5"));
}

inline std::string arm(const std::string& side, const std::string& shoulder) {
  const std::string box = "<box size='0.1 0.08 0.3'/>", cylinder = "<cylinder radius='0.05' length='0.3'/>",
                    sphere = "<sphere radius='0.07'/>";
  return link(side + "upper", tilted(box, "0 0 0.15") + tilted(sphere, "0.02 0 0.3")) +
         link(side + "fore", tilted(cylinder, "0 0 0.2")) + link(side + "wrist", tilted(sphere, "0 0 0.05")) +
         link(side + "hand", tilted(box, "0.06 0 0.2") + tilted(box, "-0.06 0 0.2") +
                                 tilted("<cylinder radius='0.03' length='0.1'/>", "0 0 0.05")) +
         jointOfArm("torso", side + "upper", shoulder, "0 0 1") +
         jointOfArm(side + "upper", side + "fore", "0 0 0.35", "0 1 0") +
         jointOfArm(side + "fore", side + "wrist", "0 0 0.45", "1 0 0") +
         jointOfArm(side + "wrist", side + "hand", "0 0 0.15", "0 1 0");
}

inline std::string twoArms() {
  const std::string torso = link("torso", tilted("<cylinder radius='0.12' length='0.7'/>", "0 0 0.2") +
                                              tilted("<box size='0.3 0.5 0.1'/>", "0 0 0.4"));
  return torso + arm("left_", "0 0.4 0.4") + arm("right_", "0 -0.4 0.4");
}

}  // namespace proximity_server::scene
