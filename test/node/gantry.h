#pragma once

#include "node/inbox.h"
#include "node/ticker.h"

#include <gtest/gtest.h>
#include <ros/ros.h>
#include <tf2_msgs/TFMessage.h>

#include <cmath>
#include <condition_variable>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

namespace proximity_server::node {

/// Joint positions of gantry.urdf [m].
struct GantryPosition {
  double x, y, z;
};

/// Plays the robot of gantry.urdf: publishes what robot_state_publisher would, with chosen stamps and never a static
/// transform.
class Gantry {
 public:
  explicit Gantry(ros::NodeHandle nh, const std::string& tf_topic = "/tf")
      : ticker_(nh, 100.0, [this] { publish(held_, ros::Time::now()); }) {
    const auto count = [listeners = listeners_](const ros::SingleSubscriberPublisher&) {
      const std::lock_guard<std::mutex> lock(listeners->mutex);
      ++listeners->count;
      listeners->connected.notify_all();
    };
    publisher_ = nh.advertise<tf2_msgs::TFMessage>(tf_topic, 100, count);
  }

  /// Waits until `nodes` others listen; false if they do not.
  bool awaitListeners(int nodes) {
    std::unique_lock<std::mutex> lock(listeners_->mutex);
    return listeners_->connected.wait_for(lock, kPatience, [&] { return listeners_->count >= nodes; });
  }

  static geometry_msgs::TransformStamped slide(const GantryPosition& position) {
    return transform("base", "slide", position.x, 0.0, 0.0);
  }
  static geometry_msgs::TransformStamped ball(const GantryPosition& position) {
    geometry_msgs::TransformStamped result = transform("slide", "ball", 0.0, position.y, 0.0);
    result.transform.rotation.w = result.transform.rotation.z = std::sqrt(0.5);
    return result;
  }
  static geometry_msgs::TransformStamped post(const GantryPosition& position) {
    return transform("base", "post", 0.0, 0.0, position.z);
  }
  static std::vector<geometry_msgs::TransformStamped> all(const GantryPosition& position) {
    return {slide(position), ball(position), post(position)};
  }

  /// A stamp ahead of now delays those of moveTo(): between the two tf would interpolate.
  void publish(geometry_msgs::TransformStamped transform, const ros::Time& stamp) {
    last_stamp_ = std::max(last_stamp_, stamp);
    tf2_msgs::TFMessage message;
    transform.header.stamp = stamp;
    message.transforms.push_back(transform);
    publisher_.publish(message);
  }

  void publish(const GantryPosition& position, const ros::Time& stamp) {
    tf2_msgs::TFMessage message;
    message.transforms = all(position);
    for (geometry_msgs::TransformStamped& transform : message.transforms) transform.header.stamp = stamp;
    publisher_.publish(message);
  }

  /// Publishes once, with a stamp of its own; the stamp.
  ros::Time moveTo(const GantryPosition& position) {
    last_stamp_ = std::max(ros::Time::now(), last_stamp_ + ros::Duration(0.001));
    publish(position, last_stamp_);
    return last_stamp_;
  }

  /// Publishes a hundred times a second with the current time, until release().
  void hold(const GantryPosition& position) {
    ticker_.stop();
    held_ = position;
    ticker_.start();
  }
  void release() { ticker_.stop(); }

 private:
  static geometry_msgs::TransformStamped transform(const std::string& parent, const std::string& child, double x,
                                                   double y, double z) {
    geometry_msgs::TransformStamped result;
    result.header.frame_id = parent;
    result.child_frame_id = child;
    result.transform.translation.x = x;
    result.transform.translation.y = y;
    result.transform.translation.z = z;
    result.transform.rotation.w = 1.0;
    return result;
  }

  struct Listeners {
    std::mutex mutex;
    std::condition_variable connected;
    int count = 0;
  };

  /// Shared with the callback: roscpp may still call it in a thread of a spinner when the publisher is gone.
  const std::shared_ptr<Listeners> listeners_ = std::make_shared<Listeners>();
  ros::Publisher publisher_;
  GantryPosition held_{};
  ros::Time last_stamp_;
  Ticker ticker_;  // last: it publishes what is above
};

/// The gantry of a test program. The first call makes it and waits until `nodes` others listen; later calls return the
/// same one.
inline Gantry& connectedGantry(int nodes) {
  static Gantry gantry{ros::NodeHandle()};
  static const bool connected = gantry.awaitListeners(nodes);
  EXPECT_TRUE(connected);
  return gantry;
}

/// Calls a service that exists; a call that fails fails the test.
///
/// Every thread keeps one connection per service: where two threads of a process open and close connections to one
/// service, roscpp itself loses about one call in a hundred on a busy machine, also with a server that does nothing.
template <class Response, class Request>
Response call(const std::string& service, const Request& request) {
  thread_local std::map<std::string, ros::ServiceClient> clients;
  ros::ServiceClient& client = clients[service];
  if (!client.isValid()) {
    EXPECT_TRUE(ros::service::waitForService(service, ros::Duration(-1.0))) << service;
    client = ros::NodeHandle().serviceClient<Request, Response>(service, /*persistent=*/true);
  }
  Request sent = request;
  Response response;
  EXPECT_TRUE(client.call(sent, response)) << service;
  return response;
}

}  // namespace proximity_server::node
