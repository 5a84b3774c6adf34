#pragma once

#include "node/answers/conversions.h"
#include "node/monitor/clearance_text.h"
#include "node/monitor/constraints.h"
#include "node/monitor/joint_velocities.h"
#include "node/monitor/lookahead.h"
#include "node/monitor/velocity_scale.h"
#include "node/robot/robot.h"
#include "node/tf/tf_poses.h"
#include "proximity_server/Clearance.h"
#include "proximity_server/scene/uncertainty/guaranteed_level.h"

#include <cstdint>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

namespace proximity_server::node {

/// Objects with the data that the monitor needs about them. The data are computed before the monitor gets the objects,
/// so that no cycle waits for that.
struct MonitoredObjects {
  MonitoredObjects() = default;
  MonitoredObjects(const Robot& robot, const RobotObjects& present);

  RobotObjects objects;
  std::vector<int> bodies;       ///< the bodies whose poses a cycle needs
  MotionSources motion_sources;  ///< the joints and roots whose velocities the lookahead needs
  CarrierFrames frames;          ///< the frames that carry moving objects
  scene::ObjectCarriers carriers;
  std::size_t longest_name = 0;  ///< [characters] of the longest name of a robot, link, <collision> element or object
};

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
  /// `frames` are the poses of frames(); without them these poses are unknown. Never waits. The result is valid until the next cycle. Without a
  /// lookahead, memory is allocated only in the first few cycles of a robot, and after max_reported_pairs has grown.
  const Clearance& cycle(const PoseSnapshot& snapshot, const VelocitySnapshot& velocities,
                         const MonitorSettings& settings, const FrameSnapshot& frames = {},
                         const CommandedMotion& commanded = {});

  /// The constraint rows at the poses of the latest cycle, whose `snapshot` has to be given again. The message is valid
  /// until the next call.
  const ConstraintRows& constraints(const PoseSnapshot& snapshot, const MonitorSettings& settings);

  /// The scale of the velocities in the latest cycle, whose `snapshot` and `frames` have to be given again. If the
  /// search ran out of time, a larger scale that was found before in the same state is returned, unless the latency has
  /// grown by more than a period of the cycles since then.
  StoppingScale velocityScale(const PoseSnapshot& snapshot, const VelocitySnapshot& velocities,
                              const MonitorSettings& settings, const FrameSnapshot& frames = {});

  /// The inequality that the poses of the latest cycle break most; nullopt if they break none, or poses are missing.
  const std::optional<BrokenInequality>& broken() const { return broken_; }

  /// For a replay: the level before the first cycle, by which hysteresis may hold it. INVALID: none.
  void assumeLevel(Clearance::_level_type level);

  /// For a replay: the time for the guaranteed distances of a cycle is over after so many steps, as it was in the record,
  /// whatever the clock says.
  void endTimeAfter(std::int64_t steps) { steps_to_deadline_ = steps; }

  /// The message of the latest cycle; its `cycle` is 0 before the first one.
  const Clearance& latest() const { return clearance_; }

 private:
  /// The input of one cycle.
  struct Cycle {
    const PoseSnapshot& snapshot;
    const FrameSnapshot& frames;
    const MonitorSettings& settings;
    scene::Question question{};
    QueryStatus age{};  ///< OK if guaranteed distances are known
  };
  QueryStatus prepareGuaranteed(const Cycle& cycle, const VelocitySnapshot& velocities);
  scene::GuaranteeLimits limits(const MonitorSettings& settings) const;
  void measurePairs(Cycle cycle, const VelocitySnapshot& velocities);
  void reserveMemory(Proximity& message, const MonitorSettings& settings) const;
  void assignPair(Proximity& message, const Cycle& cycle, const scene::PairProximity& pair);
  double guaranteedOf(const scene::PairProximity& pair, const MonitorSettings& settings);
  void assignJoints(const PoseSnapshot& snapshot, const MonitorSettings& settings);
  const scene::LevelThresholds& thresholds(const MonitorSettings& settings);
  void assignLevels(const Cycle& cycle, const scene::PairProximity& minimum);
  void explain(const scene::PairProximity& deciding, const PoseSnapshot& snapshot);
  void findBroken(const PoseSnapshot& snapshot);
  std::optional<scene::GuaranteedDecidingPair> levelOfKind(scene::PairKind kind, const Cycle& cycle,
                                                           const scene::PairProximity& minimum);
  bool isReached(const scene::GuaranteedDecidingPair& deciding);
  std::optional<scene::PairProximity> minimumOf(scene::PairKind kind, const scene::PairProximity& minimum,
                                                const scene::Question& question);
  const RobotObjects& objects() const { return monitored_.objects; }
  RobotAndObjects model() const { return {robot_->robotModel(), objects().all.get()}; }
  void listPairs(const Cycle& cycle, const scene::PairsBelow& below);
  double othersThan(const scene::PairsBelow& below, const Cycle& cycle) const;
  void lookAhead(const PoseSnapshot& snapshot, const VelocitySnapshot& velocities, const MonitorSettings& settings,
                 const FrameSnapshot& frames, const CommandedMotion& commanded);
  void countPairs();

  const scene::State& state() const { return scenes_->state; }
  /// nullptr if the robot is not uncertain.
  scene::GuaranteedDistances* guaranteed() const { return robot_->isUncertain() ? &scenes_->guaranteed() : nullptr; }

  std::shared_ptr<const Robot> robot_;
  ScenePool::Lease scenes_;  // declared after robot_, because it returns to its pool
  MonitoredObjects monitored_;
  std::optional<std::int64_t> steps_to_deadline_;      ///< of a replay, see endTimeAfter()
  std::vector<scene::PairProximity> near_;             ///< the closest pairs of this cycle, for the guarantees
  double others_ = 0.0;                                ///< [m] all other pairs are farther apart
  scene::Uncertainty aged_;                            ///< that of the robot, with the motion since the poses
  std::optional<ClearanceText> text_;                  ///< for this robot
  std::size_t text_capacity_ = 0;                      ///< [characters] of the longest text
  std::optional<BrokenInequality> broken_;             ///< of the robot, in the latest cycle
  Proximity explained_;                                ///< has the gradient of the pair that sets the level
  std::optional<Constraints> constraints_;             ///< for this robot; made when they are first needed
  scene::LevelThresholds thresholds_;                  ///< those of the robot, with the defaults of the latest settings
  std::optional<scene::ClearanceLevel> self_level_;    ///< level of the pairs of links; nullopt: INVALID
  std::optional<scene::ClearanceLevel> object_level_;  ///< level of the pairs with an object; nullopt: INVALID
  Clearance clearance_;
  ScaleInput scale_input_;           ///< input of the latest search for a scale that was complete
  double scale_ = 0.0;               ///< result of this search
  std::vector<Proximity> unlisted_;  ///< entries that below_threshold does not need now; they keep memory
};

}  // namespace proximity_server::node
