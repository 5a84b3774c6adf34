#pragma once

#include <cstdint>

#include "node/robot/config.h"

namespace proximity_server::node {

/// The level of a clearance of `distance` [m]: one of Clearance::CLEAR, WARN, STOP, COLLISION.
///
/// A level starts at or below its threshold (0 for COLLISION). It is left only when the distance exceeds the threshold
/// by more than the hysteresis. `previous` is the level of the previous cycle; after Clearance::INVALID there is no
/// hysteresis.
std::uint8_t clearanceLevel(double distance, std::uint8_t previous, const MonitorSettings& settings);

/// The settings with warn_distance and stop_distance of pairs with objects.
MonitorSettings ofObjects(MonitorSettings settings);

}  // namespace proximity_server::node
