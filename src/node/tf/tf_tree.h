#pragma once

#include <ros/callback_queue.h>
#include <ros/node_handle.h>
#include <ros/spinner.h>
#include <tf2/buffer_core.h>
#include <tf2_msgs/TFMessage.h>

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <string>

namespace proximity_server::node {

/// The transforms of /tf and /tf_static, received by a thread of its own. Thread-safe.
///
/// Unlike with tf2_ros::TransformListener, a frame that was on /tf never counts as static. tf2 decides once for ever,
/// by the first transform of a frame: a joint that was once on /tf_static would look up to date even when nobody
/// publishes it any more. A transform on /tf without a stamp is ignored for the same reason.
class TfTree {
 public:
  using OnMoving = std::function<void(const geometry_msgs::TransformStamped&)>;

  /// The listening thread calls `on_moving` with each transform of /tf that has a stamp, and `on_change` after every
  /// message. It has the given priority, see runInRealTime().
  TfTree(int realtime_priority, OnMoving on_moving, std::function<void()> on_change);
  ~TfTree();
  TfTree(const TfTree&) = delete;
  TfTree& operator=(const TfTree&) = delete;

  /// The state between two messages. No message is applied while a view exists, so a view never has only a part of a
  /// message.
  struct View {
    std::unique_lock<std::mutex> lock;
    std::shared_ptr<const tf2::BufferCore> buffer;
    std::uint64_t changes;  ///< the number of changes of the buffer since the start
  };
  View view() const;

  /// Forgets all transforms except the static ones.
  void clear();

 private:
  using Message = tf2_msgs::TFMessage;
  enum class Kind { Moving, Static };
  void onMoving(const Message& message);
  void onStatic(const Message& message);
  void keepMoving(const geometry_msgs::TransformStamped& transform);
  void keepStatic(const geometry_msgs::TransformStamped& transform);
  void keep(const geometry_msgs::TransformStamped& transform, Kind kind);
  void forgetAllThatMoves();

  const OnMoving on_moving_;
  const std::function<void()> on_change_;
  mutable std::mutex mutex_;                                       // guards the members from here to the queue
  std::map<std::string, geometry_msgs::TransformStamped> static_;  // by child frame
  std::set<std::string> moving_;                                   // child frames
  std::shared_ptr<tf2::BufferCore> buffer_;                        // replaced by clear()
  std::uint64_t changes_ = 0;
  ros::CallbackQueue queue_;
  ros::NodeHandle nh_;
  ros::Subscriber moving_sub_;
  ros::Subscriber static_sub_;
  ros::AsyncSpinner spinner_;
};

}  // namespace proximity_server::node
