#include "node/tf/tf_listener.h"

#include "node/threads/real_time.h"
#include "node/threads/request_queue.h"

#include <ros/message_event.h>
#include <sensor_msgs/JointState.h>
#include <tf2_msgs/TFMessage.h>

#include <cstdint>
#include <string>
#include <utility>

namespace proximity_server::node {
namespace {

/// Without this option the publisher's kernel delays small messages by tens of milliseconds (Nagle's algorithm).
ros::TransportHints atOnce() { return ros::TransportHints().tcpNoDelay(); }

using Event = ros::MessageEvent<const tf2_msgs::TFMessage>;

}  // namespace

TfListener::TfListener(TfPoses& tf, const Robot& robot) : tf_(tf) {
  nh_.setCallbackQueue(&queue_);
  const auto subscribe = [&](const std::string& topic, TfTree::Kind kind) {
    constexpr std::uint32_t kQueueSize = 100;  // [messages] as in tf2_ros
    const boost::function<void(const Event&)> add = [&tf, kind](const Event& event) {
      tf.add(*event.getConstMessage(), kind, event.getPublisherName());
    };
    return nh_.subscribe<tf2_msgs::TFMessage>(topic, kQueueSize, add, ros::VoidConstPtr(), atOnce());
  };
  moving_sub_ = subscribe("/tf", TfTree::Kind::Moving);
  static_sub_ = subscribe("/tf_static", TfTree::Kind::Static);
  follow(robot);
  queue_.addCallback(callbackOf([priority = robot.config().realtime_priority] { runInRealTime(priority); }));
  spinner_.start();
}

void TfListener::follow(const Robot& robot) {
  tf_.stated().follow(robot);
  std::map<std::string, ros::Subscriber> subscribers;
  for (const RobotSource& source : robot.sources()) {
    const std::string& topic = source.joint_states;
    const auto add = [&stated = tf_.stated(), topic](const sensor_msgs::JointState::ConstPtr& state) {
      stated.add(*state, topic);
    };
    if (const auto known = joint_state_subs_.find(topic); known != joint_state_subs_.end())
      subscribers[topic] = known->second;
    else if (!subscribers.count(topic))
      subscribers[topic] = nh_.subscribe<sensor_msgs::JointState>(topic, 10, add, ros::VoidConstPtr(), atOnce());
  }
  joint_state_subs_ = std::move(subscribers);
}

TfListener::~TfListener() {
  queue_.disable();
  spinner_.stop();
}

}  // namespace proximity_server::node
