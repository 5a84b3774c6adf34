#pragma once

#include "node/monitor/commanded_trajectories.h"
#include "node/robot/robot.h"
#include "node/tf/joint_velocities.h"
#include "node/tf/tf_poses.h"
#include "proximity_server/Lookahead.h"
#include "proximity_server/scene/answers/lookahead.h"
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

/// Writes the question about a lookahead from these poses on, of which knowsRoot() is true; moving objects rest. The
/// arguments must live until it is answered.
void assign(scene::LookaheadQuestion& question, const Robot& robot, scene::MotionSearch& search,
            const LookaheadStart& start, const VelocitySnapshot& velocities, const CommandedMotion& commanded,
            const MonitorSettings& settings);

/// Writes the answer into a message, which keeps its memory. If tf may move an object, the message of the status says that it is taken to rest.
void assign(Lookahead& message, const scene::ContactAhead& ahead, const Robot& robot, const LookaheadStart& start,
            const CommandedMotion& commanded, const MonitorSettings& settings);

}  // namespace proximity_server::node
