#pragma once

#include <ros/duration.h>
#include <ros/time.h>

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "node/robot/robot.h"
#include "node/tf/edge_transforms.h"
#include "node/tf/joint_frames.h"
#include "node/tf/joint_jumps.h"
#include "node/tf/tf_tree.h"
#include "proximity_server/QueryStatus.h"
#include "proximity_server/scene/model/kinematics.h"

namespace proximity_server::node {

/// The transforms of a robot's joints at one time, with a status that says which are missing and why.
struct JointSnapshot {
  JointFrames joints;                                 ///< nullopt if unknown or not asked for
  std::optional<Eigen::Isometry3d> reference_T_root;  ///< of a reference frame that is no link of the robot
  ros::Time stamp;                                    ///< the common time; 0 where there is none
  ros::Duration age;                                  ///< now - stamp
  ros::Duration skew;                                 ///< newest - oldest of the latest transforms
  QueryStatus status;                                 ///< OK, or what is missing, stale or out of reach
};

/// Poses of a robot's bodies at one time, or why there are none.
struct PoseSnapshot {
  scene::BodyPoses poses;  ///< in Robot::referenceFrame(); nullopt if unknown or not asked for
  ros::Time stamp;         ///< the common time; 0 where there is none
  ros::Duration age;       ///< now - stamp
  ros::Duration skew;      ///< newest - oldest of the latest transforms
  QueryStatus status;      ///< OK, or what is missing, stale or out of reach: names the joint
};

/// A question to tf about some joints of a robot, with room for the answers: the same one asked again takes no memory
/// beyond what tf2 takes while it looks. The robot must outlive it.
struct TfLookup {
  TfLookup(const Robot& robot, std::vector<int> joints);

  using Edge = LatestTransforms::Edge;

  const Robot* robot;
  std::vector<int> joints;
  std::vector<Edge> edges;  ///< one for each of `joints`, then one to a reference frame that is foreign
  JointSnapshot found;
  PoseSnapshot placed;
};

/// Follows the bodies of a robot through tf.
///
/// For every movable joint the transform between its two links is looked up, all at one common time: the earliest of
/// their latest ones, so that nothing is extrapolated. Fixed joints come from the URDF, so /tf_static is not needed.
/// A transform that is missing, not finite or no rotation makes the bodies beyond it unknown; one that is too far from
/// the clock makes all of them unknown. When the clock jumps back everything is forgotten.
/// Thread-safe: a thread of its own listens.
class TfPoses {
 public:
  /// See runInRealTime.
  explicit TfPoses(int realtime_priority = 0)
      : tree_(
            realtime_priority, [this](const auto& transform) { jumps_.look(transform); },
            [this] { transformsChanged(); }) {}
  TfPoses(const TfPoses&) = delete;
  TfPoses& operator=(const TfPoses&) = delete;

  /// Called after every message of tf, from the listening thread. Set it once, before transforms matter.
  void onChange(std::function<void()> listener);

  /// Chooses the robot whose joints `jumps` reports.
  void watch(const Robot& robot) { jumps_.watch(robot); }

  /// See JointJumps::recent().
  std::vector<std::string> jumps() const { return jumps_.recent(); }

  /// Poses of the bodies that the joints of `lookup` carry at `stamp`, or at the latest common time if that is 0. Never
  /// waits. Valid until the next question to `lookup`.
  const PoseSnapshot& lookUp(TfLookup& lookup, const ros::Time& stamp = {});

  /// Poses of `bodies` and of what carries them, but waits for what is still missing, at most Config::tf_timeout of
  /// wall time.
  PoseSnapshot await(const Robot& robot, const std::vector<int>& bodies, const ros::Time& stamp);

  // The same for chosen joints only, and the reference frame where that is no link of the robot.

  const JointSnapshot& lookUpJoints(TfLookup& lookup, const ros::Time& stamp = {});
  JointSnapshot awaitJoints(const Robot& robot, const std::vector<int>& joints, const ros::Time& stamp);

 private:
  void transformsChanged();
  ros::Time readClock();  ///< forgets everything where the clock jumped back

  /// The latest transforms, and the buffer that has them.
  std::shared_ptr<const tf2::BufferCore> latestOf(const Robot& robot, std::vector<TfLookup::Edge>& edges);

  std::mutex mutex_;
  std::condition_variable changed_;
  std::atomic<std::uint64_t> changes_{0};  // of the buffer
  std::function<void()> listener_;
  ros::Time last_now_;
  LatestTransforms latest_;
  JointJumps jumps_;
  TfTree tree_;  // last: it calls transformsChanged()
};

}  // namespace proximity_server::node
