#pragma once

#include "node/robot/robot.h"
#include "node/tf/edge_transforms.h"
#include "node/tf/frame_health.h"
#include "node/tf/joint_frames.h"
#include "node/tf/joint_jumps.h"
#include "node/tf/stated_joints.h"
#include "node/tf/tf_tree.h"
#include "proximity_server/QueryStatus.h"
#include "proximity_server/scene/model/kinematics.h"
#include "proximity_server/scene/query/scene.h"

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

namespace proximity_server::node {

/// The transforms of a robot's joints at one time, with a status that says which are missing and why.
struct JointSnapshot {
  JointFrames joints;  ///< nullopt if unknown or not needed
  RootPoses roots;     ///< nullopt if unknown or not needed
  JointValues stated;  ///< [rad] positions with the turn that joint_states tell, see onStatedTurn()
  ros::Time stamp;     ///< the common time of all transforms; 0 if there is none
  ros::Duration age;   ///< now - stamp
  ros::Duration skew;  ///< stamp of the newest minus stamp of the oldest of the latest transforms
  QueryStatus status;  ///< OK, or the first transform that is missing, stale or not known at this time
};

/// The poses of a robot's bodies at one time, or the reason why there are none.
struct PoseSnapshot {
  scene::BodyPoses poses;  ///< in Robot::referenceFrame(); nullopt if unknown or not needed
  ros::Time stamp;         ///< the common time of all transforms; 0 if there is none
  ros::Duration age;       ///< now - stamp
  ros::Duration skew;      ///< stamp of the newest minus stamp of the oldest of the latest transforms
  QueryStatus
      status;  ///< OK, or the name of the first joint whose transform is missing, stale or not known at this time
  /// [rad] Positions at these poses with the turn that joint_states tell, see onStatedTurn(). For each of
  /// RobotModel::joints, or empty.
  JointValues stated;
  std::optional<JointBeyond> beyond;  ///< see farthestBeyond(); of TfPoses::lookUp() only
};

/// The poses of tf frames that carry objects, in Robot::referenceFrame().
struct FrameSnapshot {
  scene::FramePoses poses;  ///< nullopt if unknown or not needed
  QueryStatus status;       ///< OK, or the name of the first frame whose pose tf does not know, with the reason
  /// The needed frames that may move relative to the reference frame: they are not frames of links, and /tf_static does
  /// not connect the two.
  std::vector<int> may_move;
};

/// The tf frames that carry objects, and the ones among them whose poses are needed.
struct CarrierFrames {
  std::vector<std::string> names;
  std::vector<int> needed;  ///< indices into `names`
};

/// The bodies of the links that have one of the needed frames. Such a frame moves with the robot's joints.
std::vector<int> bodiesOf(const Robot& robot, const CarrierFrames& frames);

/// Sets the poses of the needed frames that are frames of links of the robot. The other poses stay as they are.
void placeFramesOfLinks(const Robot& robot, const CarrierFrames& frames, const scene::BodyPoses& poses,
                        scene::FramePoses& placed);

/// A question to tf about some edges of a robot, with the memory for its answers. If it is asked again, only tf2
/// allocates memory, during its look-ups. The robot must outlive it.
struct TfLookup {
  /// `edges` are indices into Robot::tfEdges(), see edgesTo().
  TfLookup(const Robot& robot, const std::vector<int>& edges);

  using Edge = LatestTransforms::Edge;

  const Robot* robot;
  std::vector<Edge> edges;
  JointSnapshot joint_snapshot;
  PoseSnapshot pose_snapshot;
};

/// Follows the bodies of a robot through tf.
///
/// It looks up the transform between the two links of every movable joint, all at one common time: the earliest of the
/// latest stamps of all joints, so that nothing is extrapolated. Fixed joints are taken from the URDF, so /tf_static is
/// not needed. If a transform is missing, is not finite or is no rotation, the poses of the bodies beyond it are
/// unknown. If the stamp of a transform is too far from the clock, all poses are unknown. If the clock jumps back, all
/// transforms are forgotten. The turns of joints, which transforms do not tell, come from joint_states, if it tells
/// them; it is never waited for. Thread-safe.
class TfPoses {
 public:
  /// Adds the transforms of a message of /tf or /tf_static from the node `publisher`, see TfListener.
  void add(const tf2_msgs::TFMessage& message, TfTree::Kind kind, const std::string& publisher);

  /// Sets the function that add() calls at its end.
  void onChange(std::function<void()> listener);

  /// The positions and velocities of joint_states, which TfListener reads.
  StatedJoints& stated() { return stated_; }

  /// Sets the robot whose joints jumps() reports.
  void watch(const Robot& robot) { jumps_.watch(robot); }

  /// See JointJumps::recent().
  std::vector<std::string> jumps() const { return jumps_.recent(); }

  /// See FrameHealth::warnings(), for the frames that place the bodies of the robot which may be checked.
  std::vector<std::string> warnings(const Robot& robot, double rate);

  /// The poses of the bodies that the edges of `lookup` carry, at `stamp`; if that is 0, at the latest common time.
  /// Never waits. The result is valid until `lookup` is used again.
  const PoseSnapshot& lookUp(TfLookup& lookup, const ros::Time& stamp = {});

  /// The poses of `bodies` and of the bodies that carry them, at `stamp`; if that is 0, at the latest common time.
  /// Waits for missing transforms, at most `timeout` [s] of wall time; nullopt: Config::tf_timeout.
  PoseSnapshot await(const Robot& robot, const std::vector<int>& bodies, const ros::Time& stamp,
                     std::optional<double> timeout = {});

  /// The poses of frames that belong to the poses of the robot; these were looked up at `stamp`. Never waits.
  ///
  /// The pose of a frame of a link follows from `robot_poses`, which must have the bodies of bodiesOf(). Any other
  /// frame is looked up in tf at the time of `robot_poses`. If tf does not know the frame at that time, and `stamp` is
  /// 0, its latest transform is taken, which must not be farther from the clock than Config::max_tf_age.
  FrameSnapshot lookUpFrames(const Robot& robot, const CarrierFrames& frames, const PoseSnapshot& robot_poses,
                             const ros::Time& stamp = {});

  /// Does the same as lookUpFrames(), but waits for missing transforms, as await() does. It does not wait if
  /// `robot_poses` has missing transforms itself.
  FrameSnapshot awaitFrames(const Robot& robot, const CarrierFrames& frames, const PoseSnapshot& robot_poses,
                            const ros::Time& stamp, std::optional<double> timeout = {});

  // lookUpJoints() and awaitJoints() return transforms of edges instead of poses of bodies. Edges are indices into
  // Robot::tfEdges().

  const JointSnapshot& lookUpJoints(TfLookup& lookup, const ros::Time& stamp = {});
  JointSnapshot awaitJoints(const Robot& robot, const std::vector<int>& edges, const ros::Time& stamp,
                            std::optional<double> timeout = {});

  /// An argument of standingStill(): it stands for a reference frame that is not the frame of a link.
  static constexpr int kReferenceFrame = -1;

  /// Returns whether the roots of these robots stand still relative to each other. `robots` are ascending indices into
  /// RobotModel::robots, or kReferenceFrame. The status is OK if static transforms of tf connect all of them. Otherwise
  /// it is NO_VELOCITY, and names the first robot whose root may move relative to the first one of the list.
  QueryStatus standingStill(const Robot& robot, const std::vector<int>& robots);

 private:
  /// Repeats `look_up`, which returns a snapshot, after every change of tf until its status is OK or the time is over.
  template <class LookUp>
  auto await(double timeout, LookUp look_up);

  ros::Time readClock();  ///< forgets all transforms if the clock jumped back

  /// Fills in the latest transforms of the edges, and returns the buffer that has them.
  std::shared_ptr<const tf2::BufferCore> latestOf(const Robot& robot, std::vector<TfLookup::Edge>& edges);

  std::mutex mutex_;
  std::condition_variable changed_;
  std::atomic<std::uint64_t> changes_{0};  // number of changes of tree_
  std::function<void()> listener_;
  ros::Time last_now_;
  LatestTransforms latest_;
  JointJumps jumps_;
  FrameHealth health_;
  StatedJoints stated_;
  TfTree tree_;
};

}  // namespace proximity_server::node
