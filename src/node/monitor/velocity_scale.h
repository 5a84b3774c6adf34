#pragma once

#include <ros/duration.h>

#include <memory>
#include <optional>
#include <vector>

#include "node/monitor/joint_velocities.h"
#include "node/monitor/lookahead.h"
#include "node/robot/robot.h"
#include "proximity_server/QueryStatus.h"
#include "proximity_server/scene/motion/moving_scene.h"
#include "proximity_server/scene/query/pair_distances.h"
#include "proximity_server/scene/query/scene.h"

namespace proximity_server::node {

/// By how much the velocities must be scaled so that the robot can still stop in time.
struct StoppingScale {
  double scale = 0.0;        ///< of [0, 1]
  QueryStatus status;        ///< not OK: nothing is known, the scale is 0
  bool is_complete = false;  ///< false: the search ended before the largest was found
};

/// The state in which a scale was found, of one robot.
struct ScaledState {
  scene::BodyPoses poses;
  scene::FramePoses frames;
  std::vector<double> velocities;
  std::vector<std::optional<double>> positions;
  std::shared_ptr<const scene::Objects> objects;
  scene::PairDistances stop;
  double latency = 0.0;  ///< [s] with the age of the poses
};

/// Whether two states differ in nothing but the latency.
bool differInLatencyOnly(const ScaledState& p, const ScaledState& q);

/// The largest scale of the joint velocities from which the robot still stops above the stop distances, with the decelerations of its
/// parameters. What leads away from a pair is not slowed, see scene::velocityScale(). Until the robot
/// begins to brake, `age` of the poses and MonitorSettings::stop_latency pass. `joints` are those that move a checked pair.
/// `scene` and `moving_scene` have the same objects, and `scene` has the poses of the start. The search ends with
/// endOfSearch(): then the scale is a smaller one, which is safe, and not complete.
StoppingScale stoppingScale(const Robot& robot, scene::MovingScene& moving_scene, scene::Scene& scene,
                            const LookaheadStart& start, const VelocitySnapshot& velocities,
                            const std::vector<int>& joints, const scene::PairDistances& stop, const ros::Duration& age,
                            const MonitorSettings& settings);

/// [s] Until the robot begins to brake.
double stopLatency(const ros::Duration& age, const MonitorSettings& settings);

}  // namespace proximity_server::node
