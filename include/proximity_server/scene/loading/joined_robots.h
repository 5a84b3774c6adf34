#pragma once

#include "proximity_server/scene/loading/load_robot_model.h"
#include "proximity_server/scene/mesh/mesh_resolver.h"
#include "proximity_server/scene/model/robot_model.h"

#include <string>
#include <vector>

namespace proximity_server::scene {

struct NamedRobot {
  std::string name;
  RobotModel model;
};

/// Makes one model of several robots, robot by robot in their order. Its links and joints have names like "left/elbow";
/// everything else is as in the models of the robots. The robots are not joined to each other: each has its own root,
/// see placedAt().
///
/// Failure: throws std::invalid_argument for a name that is empty, has a slash, or is used for two robots, for an empty
///          list of robots, and for a model that consists of several robots itself.
RobotModel joined(const std::vector<NamedRobot>& robots);

struct NamedUrdf {
  std::string name;
  std::string urdf_xml;
};

/// Reads several URDFs and joins the robots. In the options, links have names like "left/elbow". A single robot may have
/// no name; then its model is the same as by loadRobotModel().
///
/// Failure: throws as loadRobotModel() and joined() do, naming the robot.
RobotModel loadRobots(const std::vector<NamedUrdf>& robots, const MeshResolver& resolve,
                      const ModelOptions& options = {});

}  // namespace proximity_server::scene
