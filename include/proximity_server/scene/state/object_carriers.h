#pragma once

#include "proximity_server/scene/objects/objects.h"

#include <vector>

namespace proximity_server::scene {

/// The bodies that carry the objects that no link holds, as indices into RobotModel::bodies. -1: no body carries them,
/// and they are at rest like the roots of the robots.
struct ObjectCarriers {
  int of_fixed = -1;  ///< carries the frame in which fixed objects stand: a body if that is the frame of a link
  std::vector<int> of_frames{};  ///< carries each of Objects::frames()
};

/// The carriers of objects whose frames are links, where the roots are at rest; see setPoses().
ObjectCarriers carriersOnLinks(const Objects& objects);

}  // namespace proximity_server::scene
