#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "proximity_server/scene/filter/scene_model.h"
#include "proximity_server/scene/objects/objects.h"
#include "proximity_server/scene/query/scene.h"
#include "scene/small_robots.h"

// The robots of ./dev stress free-motions and ./dev stress stops.

namespace proximity_server::scene {

/// A cell of a run in which a promise was broken.
struct CellFailure {
  std::int64_t number;  ///< of the cell in its family
  std::string sentence;
};

/// A family of cells: a robot with objects.
struct ControlFamily {
  std::string name;
  int rarity;  ///< see Rounds
  bool has_objects;
  /// The robot of all cells; nullptr: each has one of its own, of small random shapes.
  std::shared_ptr<const SceneModel> robot;
};

/// Those of small robots; Panda, UR5 and PR2 with meshes, if the package example-robot-data is found; the robot of the demo.
const std::vector<ControlFamily>& controlFamilies();

/// A random number generator that depends on these only.
Chance chanceOf(unsigned seed, std::size_t family, std::int64_t number);

/// Objects of all placements around the robot, and some that its links hold.
std::shared_ptr<const Objects> someObjects(const std::shared_ptr<const SceneModel>& model, Chance& chance);

/// Random poses of the frames of moving objects.
FramePoses someFrames(const Objects& objects, Chance& chance);

}  // namespace proximity_server::scene
