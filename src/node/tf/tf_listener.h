#pragma once

#include "node/tf/tf_poses.h"

#include <ros/callback_queue.h>
#include <ros/node_handle.h>
#include <ros/spinner.h>

#include <map>
#include <string>

namespace proximity_server::node {

/// Gives the messages of /tf, /tf_static and joint_states to a TfPoses, which must outlive it, in a thread of its own.
class TfListener {
 public:
  /// The thread has the priority of the robot's parameters, see runInRealTime().
  TfListener(TfPoses& tf, const Robot& robot);
  ~TfListener();
  TfListener(const TfListener&) = delete;
  TfListener& operator=(const TfListener&) = delete;

  /// Subscribes to the joint_states of this robot, and to no others.
  void follow(const Robot& robot);

 private:
  TfPoses& tf_;
  ros::CallbackQueue queue_;
  ros::NodeHandle nh_;
  ros::Subscriber moving_sub_;
  ros::Subscriber static_sub_;
  std::map<std::string, ros::Subscriber> joint_state_subs_;  // by full name of the topic
  ros::AsyncSpinner spinner_{1, &queue_};
};

}  // namespace proximity_server::node
