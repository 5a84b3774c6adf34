#pragma once

#include "node/objects/object_store.h"
#include "node/objects/tracked_ages.h"
#include "node/tf/tf_poses.h"

#include <ros/callback_queue.h>
#include <ros/node_handle.h>
#include <ros/spinner.h>
#include <std_msgs/Header.h>
#include <Eigen/Core>

#include <memory>
#include <vector>

namespace proximity_server::node {

/// Follows the tracked sources: each message replaces the object of its source, see ObjectStore::track(). Each source
/// has a thread, which waits for transforms at the time of the message, at most TrackedSource::max_age; meanwhile only
/// the newest message is kept.
class TrackedSources {
 public:
  /// Topics are in the namespace of `nh`. All arguments must outlive it.
  TrackedSources(const ros::NodeHandle& nh, TfPoses& tf, ObjectStore& store, TrackedAges& ages)
      : nh_(nh), tf_(tf), store_(store), ages_(ages) {}

  /// Subscribes to the sources of a robot. The store must have it, and the ages must follow it.
  void follow(const Robot& robot);

 private:
  struct Subscription {
    TrackedSource source;
    ros::CallbackQueue queue;
    ros::AsyncSpinner spinner{1, &queue};
    ros::Subscriber subscriber;  // its end waits for the callback that runs
  };

  template <class Message>
  void subscribe(Subscription& subscription);
  template <class Message>
  void take(const TrackedSource& source, const Message& message);
  void place(const TrackedSource& source, const std_msgs::Header& header, std::vector<Eigen::Vector3d> points);

  ros::NodeHandle nh_;
  TfPoses& tf_;
  ObjectStore& store_;
  TrackedAges& ages_;
  std::vector<std::unique_ptr<Subscription>> subscriptions_;
};

}  // namespace proximity_server::node
