#pragma once

#include <vector>

#include "node/monitor/joint_velocities.h"
#include "node/robot/robot.h"
#include "node/tf/tf_poses.h"
#include "proximity_server/Lookahead.h"
#include "proximity_server/scene/model/kinematics.h"
#include "proximity_server/scene/motion/moving_scene.h"

namespace proximity_server::node {

/// The joints, as indices into RobotModel::joints, whose velocities move the two links of a pair relative to each
/// other. The leader stands for each mimic joint.
std::vector<int> jointsThatMatter(const scene::RobotModel& robot, const std::vector<scene::ShapeRefPair>& pairs);

/// The robots that have a pair with another one, as ascending indices into RobotModel::robots.
std::vector<int> robotsThatMeet(const scene::RobotModel& robots, const std::vector<scene::ShapeRefPair>& pairs);

/// A lookahead without a result: OFF if the settings switch it off, else UNKNOWN.
Lookahead noLookahead(const MonitorSettings& settings);

/// The first contact if the joints keep their velocities from the given poses on, which are known for all `pairs`. The
/// search takes at most a quarter of the monitor's period.
Lookahead contactAhead(const Robot& robot, scene::MovingScene& scene, const scene::Pairs& pairs,
                       const scene::BodyPoses& poses, const VelocitySnapshot& velocities,
                       const MonitorSettings& settings);

}  // namespace proximity_server::node
