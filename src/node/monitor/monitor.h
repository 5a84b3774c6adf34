#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "node/answers/conversions.h"
#include "node/answers/gradients.h"
#include "node/monitor/constraints.h"
#include "node/monitor/joint_velocities.h"
#include "node/monitor/lookahead.h"
#include "node/monitor/velocity_scale.h"
#include "node/robot/robot.h"
#include "node/tf/tf_poses.h"
#include "proximity_server/Clearance.h"
#include "proximity_server/scene/levels/clearance_level.h"

namespace proximity_server::node {

/// Objects, with what the monitor has to know of them. It is made before the monitor takes them, so that no cycle waits
/// for that.
struct MonitoredObjects {
  MonitoredObjects() = default;
  MonitoredObjects(const Robot& robot, const RobotObjects& present);

  RobotObjects objects;
  std::vector<int> bodies;  ///< whose poses a cycle needs
  Movers movers;            ///< of which the lookahead needs the velocities
  AskedFrames frames;       ///< that moving objects need
  scene::ObjectCarriers carriers;
  std::size_t longest_name = 0;  ///< length of the longest name of a link, <collision> element or object
};

/// Monitors the checked pairs of a robot: each cycle gives one Clearance. Not thread-safe.
class Monitor {
 public:
  /// Monitors this robot from now on.
  void follow(const std::shared_ptr<const Robot>& robot);

  /// Checks these objects of the robot from now on, and gives back those of before. A robot that is followed brings its
  /// own.
  void use(MonitoredObjects& objects);

  /// The frames that moving objects need, and in each cycle their poses.
  const AskedFrames& frames() const { return monitored_.frames; }

  /// The monitored robot, the bodies whose poses a cycle needs, and the joints whose velocities the lookahead needs.
  const std::shared_ptr<const Robot>& robot() const { return robot_; }
  const std::vector<int>& bodies() const { return monitored_.bodies; }
  const std::vector<int>& joints() const { return monitored_.movers.joints; }

  /// The roots that have to rest for the lookahead, see Movers.
  const std::vector<int>& roots() const { return monitored_.movers.roots; }

  /// Computes the clearance in these poses, and the lookahead with these velocities. Never waits. The result is valid
  /// until the next cycle. Without a lookahead, memory is allocated only in the first few cycles of a robot and after
  /// max_reported_pairs has grown.
  /// `frames` are the poses of frames(); those that are left out are unknown.
  const Clearance& cycle(const PoseSnapshot& snapshot, const VelocitySnapshot& velocities,
                         const MonitorSettings& settings, const FrameSnapshot& frames = {});

  /// The constraint rows in the poses of the latest cycle, which `snapshot` are. The message is valid until the next call.
  const ConstraintRows& constraints(const PoseSnapshot& snapshot, const MonitorSettings& settings);

  /// The scale of the velocities in the latest cycle, in which `snapshot` and `frames` are the poses. A search that ran out of
  /// time does not lower what was found before in the same state, as long as the latency has grown by no more than the period
  /// of the cycles.
  StoppingScale velocityScale(const PoseSnapshot& snapshot, const VelocitySnapshot& velocities,
                              const MonitorSettings& settings, const FrameSnapshot& frames = {});

  /// The message of the latest cycle; its `cycle` is 0 before the first one.
  const Clearance& latest() const { return clearance_; }

 private:
  /// The input of one cycle.
  struct Cycle {
    const PoseSnapshot& snapshot;
    const FrameSnapshot& frames;
    const MonitorSettings& settings;
    scene::Question question;
  };
  void measure(Cycle cycle);
  void makeRoom(Proximity& message, const MonitorSettings& settings) const;
  /// Fills in a pair of this cycle.
  void say(Proximity& message, const Cycle& cycle, const scene::PairProximity& pair);
  void derive(const PoseSnapshot& snapshot);
  void nameJoints(const PoseSnapshot& snapshot, const MonitorSettings& settings);
  const scene::LevelThresholds& thresholds(const MonitorSettings& settings);
  void judge(const Cycle& cycle, const scene::PairProximity& minimum);
  std::optional<scene::DecidingPair> judgeKind(scene::PairKind kind, const Cycle& cycle,
                                               const scene::PairProximity& minimum);
  std::optional<scene::PairProximity> minimumOf(scene::PairKind kind, const scene::PairProximity& minimum,
                                                const scene::Question& question);
  const RobotObjects& objects() const { return monitored_.objects; }
  Named named() const { return {robot_->robotModel(), objects().all.get()}; }
  void report(const Cycle& cycle, const scene::PairsBelow& below);
  void lookAhead(const PoseSnapshot& snapshot, const VelocitySnapshot& velocities, const MonitorSettings& settings,
                 const FrameSnapshot& frames);
  scene::MovingScene& movingScene();
  void countPairs();

  std::shared_ptr<const Robot> robot_;
  ScenePool::Lease scene_;  // declared after robot_, whose pools it and the next return to
  MovingScenePool::Lease moving_scene_;
  MonitoredObjects monitored_;
  std::optional<Gradients> gradients_;      ///< of this robot and these objects; made when they are wanted first
  std::optional<Constraints> constraints_;  ///< the same
  scene::LevelThresholds thresholds_;       ///< of the robot, with the defaults of the latest settings
  std::optional<scene::ClearanceLevel> self_level_,
      object_level_;  ///< of pairs of links, and with an object; nullopt: INVALID
  Clearance clearance_;
  ScaledState scaled_;  ///< the state of the latest search for a scale of the velocities that had time enough
  double scale_ = 0.0;  ///< what it found
  std::vector<Proximity> unlisted_;  ///< allocated entries that Clearance::below_threshold does not need at present
};

}  // namespace proximity_server::node
