#pragma once

#include "proximity_server/scene/model/robot_model.h"
#include "proximity_server/scene/scene_model/pair_table.h"

namespace proximity_server::scene {

/// A robot with its pairs. It never changes, and scenes share it, so that requests run in parallel.
struct SceneModel {
  RobotModel robot;
  PairTable pairs;
};

}  // namespace proximity_server::scene
