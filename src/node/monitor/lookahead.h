#pragma once

#include <chrono>
#include <vector>

#include "node/monitor/joint_velocities.h"
#include "node/robot/robot.h"
#include "node/tf/tf_poses.h"
#include "proximity_server/Lookahead.h"
#include "proximity_server/scene/model/kinematics.h"
#include "proximity_server/scene/motion/moving_scene.h"

namespace proximity_server::node {

/// What moves the two of a checked pair relative to each other: links, and objects with the link or frame that carries
/// them.
struct Movers {
  std::vector<int> joints;  ///< indices into RobotModel::joints, ascending; the leader stands for each mimic joint
  std::vector<int> roots;   ///< as TfPoses::standingStill() takes them: of nothing else than tf says how they move
};
Movers moversOf(const Robot& robot, const scene::Objects& objects);

/// A lookahead without a result: OFF if the settings switch it off, else UNKNOWN.
Lookahead noLookahead(const MonitorSettings& settings);

/// Where the robot and the frames of moving objects are when a lookahead, or a stop, begins; all that is needed is known.
struct LookaheadStart {
  const scene::BodyPoses& poses;
  const AskedFrames& frames;
  const FrameSnapshot& placed;  ///< of `frames`
};

/// The end of a search that begins now: a quarter of the monitor's period, so that the rest of the cycle is in time. At rate 0
/// every new set of transforms starts a cycle; few robots publish more than a hundred sets per second.
std::chrono::steady_clock::time_point endOfSearch(const MonitorSettings& settings);

/// The first contact of a checked pair if the joints keep their velocities, and moving objects rest, which the status says
/// where tf may move them: of each pair at its stop distance. The search takes at most a quarter of the monitor's period.
Lookahead contactAhead(const Robot& robot, scene::MovingScene& scene, const LookaheadStart& start,
                       const VelocitySnapshot& velocities, const scene::PairDistances& stop,
                       const MonitorSettings& settings);

}  // namespace proximity_server::node
