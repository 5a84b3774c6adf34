#pragma once

#include <vector>

namespace proximity_server::scene {

/// What the objects move with that no link holds, as indices into RobotModel::bodies; -1: nothing, they rest where the roots
/// of the robots do.
struct ObjectCarriers {
  int of_fixed = -1;             ///< of the frame in which fixed objects stand: a body if that is the frame of a link
  std::vector<int> of_frames{};  ///< of each of Objects::frames()
};

}  // namespace proximity_server::scene
