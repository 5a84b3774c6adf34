#include "node/tf/tf_listener.h"

#include "node/threads/real_time.h"
#include "node/threads/request_queue.h"

#include <tf2_msgs/TFMessage.h>

#include <cstdint>
#include <string>

namespace proximity_server::node {

TfListener::TfListener(TfPoses& tf, int realtime_priority) {
  nh_.setCallbackQueue(&queue_);
  const auto subscribe = [&](const std::string& topic, TfTree::Kind kind) {
    constexpr std::uint32_t kQueueSize = 100;  // [messages] as in tf2_ros
    // Without this option the publisher's kernel delays small messages by tens of milliseconds (Nagle's algorithm).
    const ros::TransportHints at_once = ros::TransportHints().tcpNoDelay();
    return nh_.subscribe<tf2_msgs::TFMessage>(
        topic, kQueueSize, [&tf, kind](const tf2_msgs::TFMessage::ConstPtr& message) { tf.add(*message, kind); },
        ros::VoidConstPtr(), at_once);
  };
  moving_sub_ = subscribe("/tf", TfTree::Kind::Moving);
  static_sub_ = subscribe("/tf_static", TfTree::Kind::Static);
  queue_.addCallback(callbackOf([realtime_priority] { runInRealTime(realtime_priority); }));
  spinner_.start();
}

TfListener::~TfListener() {
  queue_.disable();
  spinner_.stop();
}

}  // namespace proximity_server::node
