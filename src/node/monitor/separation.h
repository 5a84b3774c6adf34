#pragma once

#include "node/monitor/velocity_scale.h"
#include "proximity_server/Separation.h"

#include <optional>
#include <vector>

namespace proximity_server::node {

/// The separation of the robot from tracked sources in the state of `scenes`, see scene::separation(). `ages` [s] of the
/// latest messages are in the order of Config::tracked; nullopt: the source has none. A source without an object sees
/// nobody. The search ends at searchDeadline(). All other arguments are as for StoppingScales::find().
Separation separationOf(const Robot& robot, PosedScenes& scenes, const LookaheadStart& start,
                        const VelocitySnapshot& velocities, const std::vector<int>& joints, const ros::Duration& age,
                        const std::vector<std::optional<double>>& ages, const MonitorSettings& settings,
                        scene::GuaranteedDistances* guaranteed);

/// A message without a result: the scale is 0.
Separation unknownSeparation(const QueryStatus& status);

}  // namespace proximity_server::node
