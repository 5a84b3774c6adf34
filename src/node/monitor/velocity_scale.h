#pragma once

#include <ros/duration.h>

#include <memory>

#include "node/monitor/joint_velocities.h"
#include "node/monitor/lookahead.h"
#include "node/robot/robot.h"
#include "proximity_server/QueryStatus.h"
#include "proximity_server/scene/motion/moving_scene.h"
#include "proximity_server/scene/query/scene.h"

namespace proximity_server::node {

/// By how much the velocities must be scaled so that the robot can still stop in time.
struct StoppingScale {
  double scale = 0.0;        ///< of [0, 1]
  QueryStatus status;        ///< not OK: nothing is known, the scale is 0
  bool is_complete = false;  ///< false: the search ended before the largest was found
};

/// What a scale of one robot was searched for, to tell whether a state is the same as one before.
struct StoppingState {
  MonitorSettings settings;
  scene::BodyPoses poses;
  scene::FramePoses frames;
  VelocitySnapshot velocities;
  std::shared_ptr<const scene::Objects> objects;
  ros::Duration age;  ///< of the poses

  /// Whether a scale of this state is one of the other, too: all but the age is the same, and that is at most `later` longer.
  bool holdsFor(const StoppingState& other, const ros::Duration& later) const;
};

/// The largest scale of the joint velocities from which the robot still stops above the stop distances of the settings, with the
/// decelerations of its parameters. What leads away from a pair is not slowed, see scene::velocityScale(). Until the robot
/// begins to brake, `age` of the poses and MonitorSettings::stop_latency pass. `joints` are those that move a checked pair.
/// `scene` and `moving_scene` have the same objects, and `scene` has the poses of the start. The search ends with
/// endOfSearch(): then the scale is a smaller one, which is safe.
StoppingScale stoppingScale(const Robot& robot, scene::MovingScene& moving_scene, scene::Scene& scene,
                            const LookaheadStart& start, const VelocitySnapshot& velocities,
                            const std::vector<int>& joints, const ros::Duration& age, const MonitorSettings& settings);

}  // namespace proximity_server::node
