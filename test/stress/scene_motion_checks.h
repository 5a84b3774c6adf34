#pragma once

#include "proximity_server/scene/motion/moving_scene.h"
#include "stress/scene_checks.h"

namespace proximity_server::scene {

/// Asks for the smallest distance and the first contact of a random motion of a cell, with any contact distances, and holds
/// both against the signed distances of all pairs of convex parts at some times. Leaves the cell where it was.
void observeMotion(SceneCell& cell, MovingScene& scene, SceneObservation& seen);

}  // namespace proximity_server::scene
