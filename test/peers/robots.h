#pragma once

#include "proximity_server/scene/query/scene.h"

#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace proximity_server::scene {
struct ExampleRobot;
}

namespace proximity_server::peers {

using namespace scene;

/// Returns the pieces of a body that belong to one of its links.
std::vector<const Piece*> piecesOfLink(const RobotModel& robot, int link);

struct NamedRobot {
  std::string name;
  std::shared_ptr<const SceneModel> model;
};

/// Returns the robot of ./dev demo with the filter of its SRDF.
NamedRobot demoRobot();

/// Returns a robot with the filter of its SRDF; nullopt if the package example-robot-data is not found.
std::optional<NamedRobot> exampleRobot(const ExampleRobot& robot);

/// Returns Panda, UR5 and PR2 with the filters of their SRDFs; none if the package example-robot-data is not found.
std::vector<NamedRobot> exampleRobots();

/// Returns exampleRobots() and demoRobot(), for a benchmark; prints that robots are left out if they are.
std::vector<NamedRobot> robotsToMeasure();

/// Returns two Pandas face to face, their bases 0.8 m apart, with all pairs between them: their URDFs and SRDFs are
/// joined as text, with "left/" and "right/" before all names. Returns nullopt if the package example-robot-data is not
/// found.
std::optional<NamedRobot> twoPandas();

/// Returns arms of five bodies side by side on a square grid, 0.8 m apart, until there are so many `bodies`; the last
/// arm may be shorter. A cylinder, a capsule, a box, a concave and a convex mesh on top of each other, 1 m in all.
/// Every pair is a candidate but neighbours.
NamedRobot rowsOfArms(int bodies);

}  // namespace proximity_server::peers
