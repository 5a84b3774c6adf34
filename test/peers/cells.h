#pragma once

#include "peers/robots.h"
#include "proximity_server/scene/objects/objects.h"

#include <memory>
#include <string>
#include <vector>

namespace proximity_server::peers {

using namespace scene;

/// A robot with fixed objects.
struct NamedCell {
  std::string name;
  std::shared_ptr<const SceneModel> model;
  std::shared_ptr<const Objects> objects;
};

/// Returns Panda with objects around it, 0.75 to 2.5 m from its shoulder, the same on every run: 100 meshes (those of
/// its own links), 1000 boxes of 2 to 20 cm, and 10,000 boxes of 4 cm on walls and boards, as from a map, once as a
/// single object and once as an object each. `panda` is that of exampleRobots().
std::vector<NamedCell> pandaCells(const NamedRobot& panda);

/// Returns the box of 10 cm with a number, at a random place as those of the 1000 boxes.
Object boxOfCell(int number);

}  // namespace proximity_server::peers
