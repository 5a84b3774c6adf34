#pragma once

#include "node/tf/tf_poses.h"

#include <ros/callback_queue.h>
#include <ros/node_handle.h>
#include <ros/spinner.h>

namespace proximity_server::node {

/// Gives the messages of /tf and /tf_static to a TfPoses, which must outlive it, in a thread of its own.
class TfListener {
 public:
  /// The thread has the given priority, see runInRealTime().
  TfListener(TfPoses& tf, int realtime_priority);
  ~TfListener();
  TfListener(const TfListener&) = delete;
  TfListener& operator=(const TfListener&) = delete;

 private:
  ros::CallbackQueue queue_;
  ros::NodeHandle nh_;
  ros::Subscriber moving_sub_;
  ros::Subscriber static_sub_;
  ros::AsyncSpinner spinner_{1, &queue_};
};

}  // namespace proximity_server::node
