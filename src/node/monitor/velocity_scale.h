#pragma once

#include "node/monitor/lookahead.h"
#include "node/robot/robot.h"
#include "node/tf/joint_velocities.h"
#include "proximity_server/QueryStatus.h"
#include "proximity_server/scene/guaranteed/guaranteed_distances.h"
#include "proximity_server/scene/query/pair_distances.h"
#include "proximity_server/scene/velocity_scale.h"

#include <ros/duration.h>

#include <memory>
#include <vector>

namespace proximity_server::node {

/// OK if all is known that a stop of the robot needs: the decelerations of `joints`, and the velocities.
QueryStatus stopStatus(const Robot& robot, const std::vector<int>& joints, const VelocitySnapshot& velocities);

/// The latency and decelerations for scene::velocityScale(). `age` is that of the poses. With `pose_latency` the
/// uncertainty contains the motion during the age of the poses. A joint without a deceleration gets infinity: it does not
/// move, or it is a mimic joint and stops with its leader.
scene::Braking brakingOf(const Robot& robot, const ros::Duration& age, const MonitorSettings& settings);

/// How the robot moves from the state of `scenes`; the arguments are those of StoppingScales::find().
scene::MovingState movingState(const Robot& robot, PosedScenes& scenes, const LookaheadStart& start,
                               const VelocitySnapshot& velocities, const ros::Duration& age,
                               const scene::Braking& braking, scene::GuaranteedDistances* guaranteed);

/// The factor of the velocities with which the robot can still stop in time.
struct StoppingScale {
  double scale = 0.0;        ///< in [0, 1]
  QueryStatus status;        ///< if it is not OK, nothing is known, and the scale is 0
  bool is_complete = false;  ///< false if the search ended before it found the largest scale
};

/// The scales of one robot, cycle after cycle.
class StoppingScales {
 public:
  /// Searches for the largest scale of the joint velocities from which the robot can stop above the stop distances,
  /// with the decelerations in the parameters. Motions away from a near pair are not slowed, see scene::velocityScale().
  /// The robot begins to brake after the age of the poses, `age`, and MonitorSettings::stop_latency. With PoseLatency the
  /// uncertainty contains the motion during the age, which does not count as latency then. `joints` move a checked pair.
  /// The start is the state of `scenes`. `guaranteed` is given if its poses are not known exactly: then all pairs stay
  /// above their stop distances in every state within the uncertainty, else it is nullptr. If searchDeadline() ends the
  /// search, the scale is smaller than the largest one, which is safe, and is_complete is false; then a larger scale that
  /// was found before in the same state is returned, unless the latency has grown by more than a period of the cycles.
  StoppingScale find(const Robot& robot, PosedScenes& scenes, const LookaheadStart& start,
                     const VelocitySnapshot& velocities, const std::vector<int>& joints,
                     const scene::PairDistances& stop, const ros::Duration& age, const MonitorSettings& settings,
                     scene::GuaranteedDistances* guaranteed);

 private:
  /// The state of a robot for which a scale was found.
  struct Input {
    scene::BodyPoses poses;
    scene::FramePoses frames;
    std::vector<double> velocities;
    JointValues stated;
    std::shared_ptr<const scene::Objects> objects;
    scene::PairDistances stop;
    double latency = 0.0;  ///< [s] including the age of the poses
  };
  static bool differInLatencyOnly(const Input& p, const Input& q);

  Input input_;         ///< of the latest search that was complete
  double scale_ = 0.0;  ///< its result
};

}  // namespace proximity_server::node
