#pragma once

#include "node/gantry.h"
#include "node/objects/apply_objects.h"
#include "node/objects/change_frames.h"
#include "node/objects/object_store.h"
#include "node/robot/robot.h"
#include "node/services/queries.h"
#include "node/tf/tf_poses.h"
#include "robots/robots.h"

#include <gtest/gtest.h>
#include <ros/time.h>
#include <tf2_msgs/TFMessage.h>

#include <memory>
#include <string>
#include <vector>

namespace proximity_server::node {

/// A robot with a tf of its own, and the answers of the services about it, without a ROS master. The clock stands still
/// where nothing else is said, and nothing waits for transforms.
class AskedRobot {
 public:
  using Transforms = std::vector<geometry_msgs::TransformStamped>;

  explicit AskedRobot(const RobotTexts& texts, const Config& config = {})
      : robot_(std::make_shared<const Robot>(texts.urdf, texts.srdf, withoutWaiting(config))) {
    ros::Time::init();
    wait(1.0);
  }

  /// The clock goes on by so many seconds; the new time.
  static ros::Time wait(double seconds) {
    static ros::Time now(1000.0);  // of all robots
    now += ros::Duration(seconds);
    ros::Time::setNow(now);
    return now;
  }

  void publish(const Transforms& transforms, const ros::Time& stamp, TfTree::Kind kind = TfTree::Kind::Moving,
               const std::string& publisher = "/robot") {
    tf2_msgs::TFMessage message;
    message.transforms = transforms;
    for (geometry_msgs::TransformStamped& transform : message.transforms) transform.header.stamp = stamp;
    tf_.add(message, kind, publisher);
  }

  /// Publishes with a time of its own; the time.
  ros::Time moveTo(const Transforms& transforms) {
    const ros::Time stamp = wait(0.01);
    publish(transforms, stamp);
    return stamp;
  }

  template <class Request>
  auto ask(const Request& request) {
    return answer(*robot_, tf_, request);
  }
  ApplyObjectsResponse ask(const ApplyObjectsRequest& request) { return answer(objects_, request); }

  const Robot& robot() const { return *robot_; }
  TfPoses& tf() { return tf_; }

 private:
  static Config withoutWaiting(Config config) {
    config.tf_timeout = 0.0;
    config.motion_time_budget = 20.0;  // the searches end far earlier, also on a busy machine
    return config;
  }

  std::shared_ptr<const Robot> robot_;
  TfPoses tf_;
  ObjectStore objects_{robot_, /*node_start=*/1, frameFinder(tf_)};
};

/// The robot of gantry.urdf.
class AskedGantry : public testing::Test {
 protected:
  explicit AskedGantry(const std::string& reference_frame = "", int max_batch = 10)
      : gantry_({robotText("gantry.urdf"), robotText("gantry.srdf")}, configOf(reference_frame, max_batch)) {}

  ros::Time moveTo(const GantryPosition& position) { return gantry_.moveTo(Gantry::all(position)); }

  template <class Request>
  auto ask(const Request& request) {
    return gantry_.ask(request);
  }

  AskedRobot gantry_;

 private:
  static Config configOf(const std::string& reference_frame, int max_batch) {
    Config config;
    config.reference_frame = reference_frame;
    config.max_batch = max_batch;
    return config;
  }
};

}  // namespace proximity_server::node
