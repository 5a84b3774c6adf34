#pragma once

#include "node/gantry.h"

#include <cmath>
#include <string>
#include <vector>

namespace proximity_server::node {

/// Plays the robot of limits.urdf on /limits/tf: publishes what robot_state_publisher would.
class LimitedRobot {
 public:
  /// Publishes a hundred times a second with the current time, until release().
  void hold(double run, double turn) {
    ticker_.stop();
    run_ = run;
    turn_ = turn;
    ticker_.start();
  }
  void release() { ticker_.stop(); }

  bool awaitListeners(int nodes) { return tf_.awaitListeners(nodes); }

  static std::vector<geometry_msgs::TransformStamped> all(double run, double turn) {
    geometry_msgs::TransformStamped ball = child("ball"), echo = child("echo"), hand = child("hand");
    ball.transform.translation.x = run;
    echo.transform.translation.y = 2.0 * run;
    hand.transform.translation.z = 1.0;
    hand.transform.rotation.z = std::sin(0.5 * turn);
    hand.transform.rotation.w = std::cos(0.5 * turn);
    return {ball, echo, hand};
  }

 private:
  static geometry_msgs::TransformStamped child(const std::string& name) {
    geometry_msgs::TransformStamped transform;
    transform.header.frame_id = "wall";
    transform.child_frame_id = name;
    transform.transform.rotation.w = 1.0;
    return transform;
  }

  void publish() {
    const ros::Time stamp = ros::Time::now();
    for (const geometry_msgs::TransformStamped& transform : all(run_, turn_)) tf_.publish(transform, stamp);
  }

  Gantry tf_{ros::NodeHandle(), "/limits/tf"};
  double run_ = 1.0, turn_ = 0.0;
  Ticker ticker_{ros::NodeHandle(), 100.0, [this] { publish(); }};  // last: it uses tf_
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
