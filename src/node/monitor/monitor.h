#pragma once

#include "node/answers/clearance_message.h"
#include "node/answers/sensed_message.h"
#include "node/monitor/constraints.h"
#include "node/monitor/lookahead.h"
#include "node/monitor/monitored_objects.h"
#include "node/monitor/separation.h"
#include "node/monitor/velocity_scale.h"
#include "node/robot/robot.h"
#include "node/tf/joint_velocities.h"
#include "node/tf/tf_poses.h"
#include "proximity_server/Clearance.h"
#include "proximity_server/scene/answers/assessment.h"

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

namespace proximity_server::node {

/// Monitors the checked pairs of a robot. Each cycle makes one Clearance. Not thread-safe.
class Monitor {
 public:
  /// Sets the robot, with its present objects.
  void follow(const std::shared_ptr<const Robot>& robot);

  /// Sets the objects of the robot. On return, `objects` are the previous ones.
  void use(MonitoredObjects& objects);

  /// The frames of moving objects, whose poses each cycle needs.
  const CarrierFrames& frames() const { return monitored_.frames; }

  /// The monitored robot, the bodies whose poses a cycle needs, and the joints whose velocities the lookahead needs.
  const std::shared_ptr<const Robot>& robot() const { return robot_; }
  const std::vector<int>& bodies() const { return monitored_.bodies; }
  const std::vector<int>& joints() const { return monitored_.motion_sources.joints; }

  /// The roots that have to stand still for the lookahead, see MotionSources.
  const std::vector<int>& roots() const { return monitored_.motion_sources.roots; }

  /// Computes the clearance at these poses, and the lookahead with these velocities or along what was commanded.
  /// `frames` are the poses of frames(); without them these poses are unknown. Never waits. The result is valid until the
  /// next cycle. Memory is allocated only in the first few cycles of a robot, after max_reported_pairs has grown, and for
  /// a lookahead as scene::Lookahead says.
  const Clearance& cycle(const PoseSnapshot& snapshot, const VelocitySnapshot& velocities,
                         const MonitorSettings& settings, const FrameSnapshot& frames = {},
                         const CommandedMotion& commanded = {});

  /// The constraint rows at the poses of the latest cycle, whose arguments have to be given again. The message is valid
  /// until the next call.
  const ConstraintRows& constraints(const PoseSnapshot& snapshot, const MonitorSettings& settings);

  /// The scale of the velocities in the latest cycle, whose arguments have to be given again, see StoppingScales.
  StoppingScale velocityScale(const PoseSnapshot& snapshot, const VelocitySnapshot& velocities,
                              const MonitorSettings& settings, const FrameSnapshot& frames = {});

  /// The separation from tracked sources in the latest cycle, whose arguments have to be given again, see separationOf().
  Separation separation(const PoseSnapshot& snapshot, const VelocitySnapshot& velocities,
                        const MonitorSettings& settings, const FrameSnapshot& frames,
                        const std::vector<std::optional<double>>& ages);

  /// The sensed sources in the latest cycle, with their latest clouds, see sensedSources().
  Sensed sensed(const std::vector<SensedCloud>& clouds);

  /// The inequality that the poses of the latest cycle break most; nullopt if they break none, or poses are missing.
  const std::optional<scene::BrokenInequality>& broken() const { return assessment_.broken; }

  /// For a replay: the level before the first cycle, by which hysteresis may hold it. INVALID: none.
  void assumeLevel(Clearance::_level_type level);

  /// For a replay: the time for the guaranteed distances of a cycle is over after so many steps, as it was in the record,
  /// whatever the clock says.
  void endTimeAfter(std::int64_t steps) { steps_to_deadline_ = steps; }

  /// The message of the latest cycle; its `cycle` is 0 before the first one.
  const Clearance& latest() const { return message_.latest(); }

 private:
  std::optional<scene::LevelDistances> debounced(const ros::Time& stamp, const MonitorSettings& settings);
  QueryStatus prepareGuaranteed(const PoseSnapshot& snapshot, const VelocitySnapshot& velocities,
                                const MonitorSettings& settings, const FrameSnapshot& frames);
  scene::GuaranteeLimits limits(const MonitorSettings& settings) const;

  /// nullptr if the robot is not uncertain.
  scene::GuaranteedDistances* guaranteed() const { return robot_->isUncertain() ? &scenes_->guaranteed() : nullptr; }

  std::shared_ptr<const Robot> robot_;
  ScenePool::Lease scenes_;  // declared after robot_, because it returns to its pool
  MonitoredObjects monitored_;
  std::optional<std::int64_t> steps_to_deadline_;     ///< of a replay, see endTimeAfter()
  scene::Uncertainty aged_;                           ///< that of the robot, with the motion since the poses
  scene::LevelThresholds thresholds_;                 ///< those of the robot, with the defaults of the latest settings
  scene::Assessment assessment_;                      ///< of the latest cycle
  std::optional<ros::Time> warn_since_, stop_since_;  ///< the level has been so or worse, if nothing is held back
  scene::Lookahead lookahead_;                        ///< its memory
  ClearanceMessage message_;                          ///< about it
  std::optional<Constraints> constraints_;            ///< for this robot; made when they are first needed
  StoppingScales scales_;
};

}  // namespace proximity_server::node
