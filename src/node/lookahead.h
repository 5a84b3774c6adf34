#pragma once

#include <vector>

#include "joint_velocities.h"
#include "proximity_server/Lookahead.h"
#include "proximity_server/scene/moving_scene.h"
#include "robot.h"
#include "tf_poses.h"

namespace proximity_server {

/// The joints, as indices into RobotModel::joints, whose velocities move the two links of some pair against each other;
/// for one that follows, its leader.
std::vector<int> jointsThatMatter(const RobotModel& robot, const std::vector<SubjectPair>& pairs);

/// Nothing is known, or nothing was asked: Lookahead::UNKNOWN or OFF, as the settings say.
Lookahead noLookahead(const MonitorSettings& settings);

/// What the velocities lead to, from poses on of which all that `pairs` need are known. Takes no longer than a part of
/// the monitor's period.
Lookahead contactAhead(const Robot& robot, MovingScene& scene, const std::vector<SubjectPair>& pairs,
                       const BodyPoses& poses, const VelocitySnapshot& velocities, const MonitorSettings& settings);

}  // namespace proximity_server
