#pragma once

#include "node/objects/object_store.h"
#include "node/sources/cloud_boxes.h"
#include "node/sources/tracked_ages.h"
#include "node/tf/tf_poses.h"

#include <ros/callback_queue.h>
#include <ros/node_handle.h>
#include <ros/publisher.h>
#include <ros/spinner.h>
#include <sensor_msgs/PointCloud2.h>
#include <std_msgs/Header.h>
#include <Eigen/Core>

#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace proximity_server::node {

struct OctomapMessage;

/// Follows the tracked and the sensed sources: each message replaces the object of its source, see ObjectStore::track().
/// Each source has a thread, which waits for transforms at the time of the message, at most TrackedSource::max_age;
/// meanwhile only the newest message is kept. The points of sensed sources that are not on the robot are published on
/// ~sensed_points, while that has subscribers.
class TrackedSources {
 public:
  /// Topics are in the namespace of `nh`, ~sensed_points in that of `private_nh`. The others must outlive it.
  TrackedSources(const ros::NodeHandle& nh, const ros::NodeHandle& private_nh, TfPoses& tf, ObjectStore& store,
                 TrackedAges& ages);

  /// Subscribes to the sources of a robot. The store must have it, and the ages must follow it.
  void follow(const Robot& robot);

 private:
  struct Subscription {
    TrackedSource source;
    std::optional<CloudBoxes> boxes;  ///< of a sensed source
    ros::CallbackQueue queue;
    ros::AsyncSpinner spinner{1, &queue};
    ros::Subscriber subscriber;  // its end waits for the callback that runs
  };

  template <class Message>
  void subscribe(Subscription& subscription);
  template <class Message>
  void take(Subscription& subscription, const Message& message);
  void place(const TrackedSource& source, const std_msgs::Header& header, std::vector<Eigen::Vector3d> points);
  void placeCloud(Subscription& subscription, const sensor_msgs::PointCloud2& message);
  void placeMap(const TrackedSource& source, const OctomapMessage& message);
  Eigen::Isometry3d poseOf(const Robot& robot, const TrackedSource& source, const std_msgs::Header& header);
  void publish(const std::shared_ptr<const Robot>& robot, const std::string& source, const std_msgs::Header& header,
               const CloudBoxes::Moment& at, const std::vector<Eigen::Vector3d>& points);

  ros::NodeHandle nh_;
  TfPoses& tf_;
  ObjectStore& store_;
  TrackedAges& ages_;
  ros::Publisher points_pub_;
  std::vector<std::unique_ptr<Subscription>> subscriptions_;
};

}  // namespace proximity_server::node
