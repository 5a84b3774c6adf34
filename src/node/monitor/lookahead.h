#pragma once

#include "node/monitor/commanded_trajectories.h"
#include "node/robot/robot.h"
#include "node/tf/joint_velocities.h"
#include "node/tf/tf_poses.h"
#include "proximity_server/Lookahead.h"
#include "proximity_server/scene/motion/motion_search.h"
#include "proximity_server/scene/state/state.h"

#include <chrono>
#include <vector>

namespace proximity_server::node {

/// A lookahead without a result: OFF if the settings switch it off, else UNKNOWN.
Lookahead noLookahead(const MonitorSettings& settings);

/// The state in which a lookahead, or a stop, begins. All poses that are needed are known.
struct LookaheadStart {
  const scene::State& state;
  const JointValues& stated;  ///< PoseSnapshot::stated
  const CarrierFrames& frames;
  const std::vector<int>& may_move;  ///< FrameSnapshot::may_move
};

/// [s] How long a search may take: a quarter of the monitor's period, so that the whole cycle ends in time. At rate 0
/// every new set of transforms starts a cycle; it then has a quarter of 10 ms, because few robots publish more than a
/// hundred sets per second.
double searchTime(const MonitorSettings& settings);

/// The deadline of a search that begins now.
std::chrono::steady_clock::time_point searchDeadline(const MonitorSettings& settings);

/// Searches for the first contact of the checked pairs, if joints follow the splines of commands, all others keep their
/// velocities, and moving objects rest. A contact of a pair is at its stop distance. The answer is proven for all
/// motions within the tracking errors of the followers. If tf may move an object, the message of the status says that it
/// is taken to rest. The search ends at searchDeadline().
Lookahead contactAhead(const CommandedMotion& commanded, const Robot& robot, scene::MotionSearch& scene,
                       const LookaheadStart& start, const VelocitySnapshot& velocities,
                       const scene::PairDistances& stop, const MonitorSettings& settings);

}  // namespace proximity_server::node
