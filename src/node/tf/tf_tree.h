#pragma once

#include <tf2/buffer_core.h>
#include <tf2_msgs/TFMessage.h>

#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <string>

namespace proximity_server::node {

/// The transforms of /tf and /tf_static. Thread-safe.
///
/// Unlike with tf2_ros::TransformListener, a frame that was on /tf never counts as static. tf2 decides once for ever,
/// by the first transform of a frame: a joint that was once on /tf_static would look up to date even when nobody
/// publishes it any more. A transform on /tf without a stamp is ignored for the same reason.
class TfTree {
 public:
  /// The topic of a message: /tf or /tf_static.
  enum class Kind { Moving, Static };
  void add(const tf2_msgs::TFMessage& message, Kind kind);

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
  void keepMoving(const geometry_msgs::TransformStamped& transform);
  void keepStatic(const geometry_msgs::TransformStamped& transform);
  void keep(const geometry_msgs::TransformStamped& transform, Kind kind);
  void forgetAllThatMoves();

  mutable std::mutex mutex_;                                                       // guards the members below
  std::map<std::string, geometry_msgs::TransformStamped> static_;                  // by child frame
  std::set<std::string> moving_;                                                   // child frames
  std::shared_ptr<tf2::BufferCore> buffer_ = std::make_shared<tf2::BufferCore>();  // replaced by clear()
  std::uint64_t changes_ = 0;
};

}  // namespace proximity_server::node
