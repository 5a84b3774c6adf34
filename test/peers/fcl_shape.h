#pragma once

#include <fcl/geometry/collision_geometry.h>

#include <memory>

#include "proximity_server/narrowphase/shape/shape.h"

namespace proximity_server::peers {

using namespace narrowphase;

/// A convex shape as FCL 0.7 describes it, in the same frame.
///
/// Failure: throws std::invalid_argument for what FCL has no shape for: a margin about anything but a point or a
///          segment, and a hull that is no solid.
std::shared_ptr<fcl::CollisionGeometryd> fclShape(const Shape& shape);

}  // namespace proximity_server::peers
