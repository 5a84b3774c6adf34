#pragma once

#include "node/ticker.h"

#include <geometry_msgs/TransformStamped.h>
#include <ros/node_handle.h>

#include <functional>
#include <map>
#include <mutex>
#include <string>
#include <vector>

namespace proximity_server::node {

/// The faults that may happen between a robot and tf.
enum class TfFault {
  None,
  Silence,          ///< nothing comes any more
  FrozenStamp,      ///< every message repeats the stamp of the first
  StampsOfThePast,  ///< kFarTime behind
  StampsAhead,      ///< kFarTime ahead
  NoStamp,          ///< stamps of 0
  EndOfTime,        ///< the last stamp that there is
  OutOfOrder,       ///< of every two messages the later one comes first
  NanPosition,
  NanRotation,
  InfinitePosition,
  HugePosition,    ///< finite, but its square is not
  ZeroQuaternion,  ///< of length 0
  LongQuaternion,  ///< of length 2
  Loop,            ///< the frame hangs below a frame that hangs below it
  OtherTree,       ///< re-parented to a frame that belongs to nothing
  FrameBetween,    ///< re-parented to a new frame that hangs below the old parent: the same pose in two steps
  Renamed,         ///< child_frame_id is another one
  Jump,            ///< kDisplacement away from where it is
  TwoPublishers,   ///< a second one says kDisplacement in between the messages of the first
};

/// The effect of a fault on the answers.
enum class TfEffect {
  None,      ///< they stay right
  Blinds,    ///< there are none: INVALID, once the last good transforms are older than max_tf_age
  Misleads,  ///< they are about what tf says, which is not where the robot is
};

struct TfFaultKind {
  TfFault fault;
  std::string name;
  TfEffect effect;
};

/// Every fault but None.
const std::vector<TfFaultKind>& tfFaults();

constexpr double kFarTime = 5.0;       ///< [s] more than any max_tf_age in the tests, less than tf remembers
constexpr double kDisplacement = 0.5;  ///< [m] along x of the parent frame

/// Publishes the transforms of a robot, as robot_state_publisher does, and spoils them on demand. Thread-safe.
class FaultyTf {
 public:
  explicit FaultyTf(ros::NodeHandle nh, const std::string& topic = "/tf");

  /// Spoils the transform to `child_frame` from the next message on; "": all of them. None heals.
  void apply(TfFault fault, const std::string& child_frame = "");

  /// Publishes these healthy transforms, spoiled by the fault.
  void send(const std::vector<geometry_msgs::TransformStamped>& transforms);

 private:
  using Transforms = std::vector<geometry_msgs::TransformStamped>;
  Transforms spoiled(const geometry_msgs::TransformStamped& healthy);
  Transforms swapped(const geometry_msgs::TransformStamped& healthy);

  std::mutex mutex_;
  TfFault fault_ = TfFault::None;
  std::string victim_;
  std::map<std::string, geometry_msgs::TransformStamped> first_;  // since the fault began, by child frame
  std::map<std::string, geometry_msgs::TransformStamped> held_;   // back, by child frame
  ros::Publisher publisher_;
};

/// A FaultyTf that sends the transforms of the current time, at `rate` [Hz] of wall time.
class TfStream {
 public:
  using Source = std::function<std::vector<geometry_msgs::TransformStamped>(const ros::Time& now)>;

  TfStream(const ros::NodeHandle& nh, double rate, Source transforms, const std::string& topic = "/tf");

  void apply(TfFault fault, const std::string& child_frame = "") { tf_.apply(fault, child_frame); }

 private:
  FaultyTf tf_;
  Source transforms_;
  Ticker ticker_;  // last: it sends what is above
};

}  // namespace proximity_server::node
