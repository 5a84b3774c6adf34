#pragma once

#include <memory>
#include <string>

#include "proximity_server/scene/filter/scene_model.h"
#include "proximity_server/scene/loading/load_robot_model.h"

namespace proximity_server::scene {

// Links and joints of a robot with two arms of every kind of shape.

inline std::string tilted(const std::string& shape, const std::string& xyz) {
  return "<collision><origin xyz='" + xyz + "' rpy='0.3 -0.2 0.1'/><geometry>" + shape + "</geometry></collision>";
}

inline std::string link(const std::string& name, const std::string& collisions) {
  return "<link name='" + name + "'>" + collisions + "</link>";
}

inline std::string joint(const std::string& parent, const std::string& child, const std::string& type,
                         const std::string& xyz, const std::string& axis) {
  return "<joint name='to_" + child + "' type='" + type + "'><parent link='" + parent + "'/><child link='" + child +
         "'/><origin xyz='" + xyz + "'/><axis xyz='" + axis +
         "'/><limit lower='-2.5' upper='2.5' effort='1' velocity='1'/></joint>";
}

inline std::string arm(const std::string& side, const std::string& shoulder) {
  const std::string box = "<box size='0.1 0.08 0.3'/>", cylinder = "<cylinder radius='0.05' length='0.3'/>",
                    sphere = "<sphere radius='0.07'/>";
  return link(side + "upper", tilted(box, "0 0 0.15") + tilted(sphere, "0.02 0 0.3")) +
         link(side + "fore", tilted(cylinder, "0 0 0.2")) + link(side + "wrist", tilted(sphere, "0 0 0.05")) +
         link(side + "hand", tilted(box, "0.06 0 0.2") + tilted(box, "-0.06 0 0.2") +
                                 tilted("<cylinder radius='0.03' length='0.1'/>", "0 0 0.05")) +
         joint("torso", side + "upper", "revolute", shoulder, "0 0 1") +
         joint(side + "upper", side + "fore", "revolute", "0 0 0.35", "0 1 0") +
         joint(side + "fore", side + "wrist", "revolute", "0 0 0.45", "1 0 0") +
         joint(side + "wrist", side + "hand", "revolute", "0 0 0.15", "0 1 0");
}

inline std::string twoArms() {
  const std::string torso = link("torso", tilted("<cylinder radius='0.12' length='0.7'/>", "0 0 0.2") +
                                              tilted("<box size='0.3 0.5 0.1'/>", "0 0 0.4"));
  return torso + arm("left_", "0 0.4 0.4") + arm("right_", "0 -0.4 0.4");
}

inline std::shared_ptr<const SceneModel> modelOf(const std::string& links) {
  auto model = std::make_shared<SceneModel>();
  model->robot = loadRobotModel("<robot name='arms'>" + links + "</robot>", [](const std::string& uri) { return uri; });
  model->pairs = filterPairs(model->robot, "");
  return model;
}

}  // namespace proximity_server::scene
