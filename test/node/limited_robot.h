#pragma once

#include "node/gantry.h"

#include <tf2_msgs/TFMessage.h>

#include <cmath>

namespace proximity_server::node {

/// Plays the robot of limits.urdf on /limits/tf: publishes what robot_state_publisher would.
class LimitedRobot {
 public:
  /// Publishes once with a stamp of its own; the stamp.
  ros::Time moveTo(double run, double turn) {
    stamp_ = std::max(ros::Time::now(), stamp_ + ros::Duration(0.001));
    publish(run, turn, stamp_);
    return stamp_;
  }

  /// Publishes a hundred times a second with the current time, until release().
  void hold(double run, double turn) {
    ticker_.stop();
    run_ = run;
    turn_ = turn;
    ticker_.start();
  }
  void release() { ticker_.stop(); }

  bool awaitListeners(int nodes) { return tf_.awaitListeners(nodes); }

 private:
  static geometry_msgs::TransformStamped child(const std::string& name, const ros::Time& stamp) {
    geometry_msgs::TransformStamped transform;
    transform.header.frame_id = "wall";
    transform.header.stamp = stamp;
    transform.child_frame_id = name;
    transform.transform.rotation.w = 1.0;
    return transform;
  }

  void publish(double run, double turn, const ros::Time& stamp) {
    geometry_msgs::TransformStamped ball = child("ball", stamp), echo = child("echo", stamp),
                                    hand = child("hand", stamp);
    ball.transform.translation.x = run;
    echo.transform.translation.y = 2.0 * run;
    hand.transform.translation.z = 1.0;
    hand.transform.rotation.z = std::sin(0.5 * turn);
    hand.transform.rotation.w = std::cos(0.5 * turn);
    for (const geometry_msgs::TransformStamped& transform : {ball, echo, hand}) tf_.publish(transform, stamp);
  }

  Gantry tf_{ros::NodeHandle(), "/limits/tf"};
  ros::Time stamp_;
  double run_ = 1.0, turn_ = 0.0;
  Ticker ticker_{ros::NodeHandle(), 100.0, [this] { publish(run_, turn_, ros::Time::now()); }};  // last: it uses tf_
};

/// The robot of a test program. The first call makes it and waits until a node listens; later calls return the same
/// one.
inline LimitedRobot& connectedLimitedRobot() {
  static LimitedRobot robot;
  static const bool connected = robot.awaitListeners(1);
  EXPECT_TRUE(connected);
  return robot;
}

}  // namespace proximity_server::node
