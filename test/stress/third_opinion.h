#pragma once

#include "proximity_server/narrowphase/shape/shape.h"

#include <Eigen/Geometry>

#include <vector>

namespace proximity_server::narrowphase {

/// The distances [m] that other libraries find of two shapes that lie apart: FCL with the solver that it uses by
/// default, and Bullet where its two ways agree within what float can tell. None where they have no such shapes, or no
/// answer. Waits for other threads, because FCL's assertions have to be survived one at a time.
std::vector<double> distancesByOthers(const Shape& a, const Shape& b, const Eigen::Isometry3d& a_T_b);

}  // namespace proximity_server::narrowphase
