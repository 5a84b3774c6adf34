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
#include "proximity_server/scene/query/scene.h"

namespace proximity_server::node {

/// The transforms of a robot's joints at one time, with a status that says which are missing and why.
struct JointSnapshot {
  JointFrames joints;  ///< nullopt if unknown or not asked for
  RootPoses roots;     ///< the same
  ros::Time stamp;     ///< the common time; 0 where there is none
  ros::Duration age;   ///< now - stamp
  ros::Duration skew;  ///< newest - oldest of the latest transforms
  QueryStatus status;  ///< OK, or what is missing, stale or out of reach
};

/// The poses of a robot's bodies at one time, or the reason why there are none.
struct PoseSnapshot {
  scene::BodyPoses poses;  ///< in Robot::referenceFrame(); nullopt if unknown or not asked for
  ros::Time stamp;         ///< the common time; 0 where there is none
  ros::Duration age;       ///< now - stamp
  ros::Duration skew;      ///< newest - oldest of the latest transforms
  QueryStatus status;      ///< OK, or what is missing, stale or out of reach, with the name of the joint
};

/// The poses of tf frames that carry objects, in Robot::referenceFrame().
struct FrameSnapshot {
  scene::FramePoses poses;  ///< nullopt if unknown or not asked for
  QueryStatus status;       ///< OK, or why the first one that tf does not know is not, with its name
  /// The first asked frame that may move against the reference frame, as it is no link, and /tf_static does not join the two.
  std::optional<int> may_move;
};

/// Frames that carry objects, and those of them that matter.
struct AskedFrames {
  std::vector<std::string> names;
  std::vector<int> asked;  ///< indices into `names`
};

/// The links that carry some of the frames: a frame of the robot itself moves with the robot's joints.
std::vector<int> bodiesOf(const Robot& robot, const AskedFrames& frames);

/// Fills in the asked frames that are those of links of the robot; the others stay as they are.
void placeFramesOfLinks(const Robot& robot, const AskedFrames& frames, const scene::BodyPoses& poses,
                        scene::FramePoses& placed);

/// A question to tf about some edges of a robot, with the memory for its answers: asked again, it allocates nothing
/// besides what tf2 allocates during a look-up. The robot must outlive it.
struct TfLookup {
  /// `edges` are indices into Robot::tfEdges(), see edgesTo().
  TfLookup(const Robot& robot, const std::vector<int>& edges);

  using Edge = LatestTransforms::Edge;

  const Robot* robot;
  std::vector<Edge> edges;
  JointSnapshot found;
  PoseSnapshot placed;
};

/// Follows the bodies of a robot through tf.
///
/// It looks up the transform between the two links of every movable joint, all at one common time: the earliest of the
/// latest stamps of all joints, so that nothing is extrapolated. Fixed joints come from the URDF, so /tf_static is not
/// needed. If a transform is missing, not finite or no rotation, the poses of the bodies beyond it are unknown; if one
/// is too far from the clock, all poses are unknown. If the clock jumps back, all transforms are forgotten.
/// Thread-safe; a thread of its own receives the transforms.
class TfPoses {
 public:
  /// For the priority of the listening thread see runInRealTime.
  explicit TfPoses(int realtime_priority = 0)
      : tree_(
            realtime_priority, [this](const auto& transform) { jumps_.add(transform); },
            [this] { transformsChanged(); }) {}
  TfPoses(const TfPoses&) = delete;
  TfPoses& operator=(const TfPoses&) = delete;

  /// Sets the function that the listening thread calls after every message of tf.
  void onChange(std::function<void()> listener);

  /// Chooses the robot whose joints `jumps` reports.
  void watch(const Robot& robot) { jumps_.watch(robot); }

  /// See JointJumps::recent().
  std::vector<std::string> jumps() const { return jumps_.recent(); }

  /// The poses, at `stamp` or at the latest common time if that is 0, of the bodies that the edges of `lookup` carry.
  /// Never waits. Valid until `lookup` is used again.
  const PoseSnapshot& lookUp(TfLookup& lookup, const ros::Time& stamp = {});

  /// The poses of `bodies` and of the bodies that carry them. Waits for missing transforms, at most Config::tf_timeout
  /// of wall time.
  PoseSnapshot await(const Robot& robot, const std::vector<int>& bodies, const ros::Time& stamp);

  /// The poses of frames for the poses `at` of the robot, which were asked for at `stamp`. Never waits.
  ///
  /// A frame of a link of the robot follows from `at`, which must have the bodies of bodiesOf(). Any other is taken from tf
  /// at the time of `at`. If `stamp` is 0 and tf does not have that time of it, it is taken from its latest transform, which
  /// must not be farther from the clock than Config::max_tf_age.
  FrameSnapshot lookUpFrames(const Robot& robot, const AskedFrames& frames, const PoseSnapshot& at,
                             const ros::Time& stamp = {});

  /// The same; waits for missing transforms, at most Config::tf_timeout of wall time, but not if `at` misses any itself.
  FrameSnapshot awaitFrames(const Robot& robot, const AskedFrames& frames, const PoseSnapshot& at,
                            const ros::Time& stamp);

  // The same for the transforms of chosen edges, as indices into Robot::tfEdges().

  const JointSnapshot& lookUpJoints(TfLookup& lookup, const ros::Time& stamp = {});
  JointSnapshot awaitJoints(const Robot& robot, const std::vector<int>& edges, const ros::Time& stamp);

  /// In standingStill(): the reference frame itself, which is no link.
  static constexpr int kReferenceFrame = -1;

  /// OK if tf knows by static transforms alone how the roots of these robots (ascending indices into RobotModel::robots, or
  /// kReferenceFrame) stand to each other; else NO_VELOCITY, naming the first robot whose root may move against the first.
  QueryStatus standingStill(const Robot& robot, const std::vector<int>& robots);

 private:
  void transformsChanged();

  /// Repeats `look_up`, which returns a snapshot, after every change of tf until its status is OK or the time is over.
  template <class LookUp>
  auto await(double timeout, LookUp look_up);

  ros::Time readClock();  ///< forgets all transforms if the clock jumped back

  /// Fills in the latest transforms, and returns the buffer that has them.
  std::shared_ptr<const tf2::BufferCore> latestOf(const Robot& robot, std::vector<TfLookup::Edge>& edges);

  std::mutex mutex_;
  std::condition_variable changed_;
  std::atomic<std::uint64_t> changes_{0};  // of the buffer
  std::function<void()> listener_;
  ros::Time last_now_;
  LatestTransforms latest_;
  JointJumps jumps_;
  TfTree tree_;  // destroyed first, as it calls transformsChanged()
};

}  // namespace proximity_server::node
