#pragma once

#include <proximity_server/ApplyObjects.h>
#include <proximity_server/Clearance.h>
#include "chance.h"
#include "node/faults/tf_faults.h"
#include "node/load/moving_robot.h"
#include "node/load/node_under_load.h"
#include "node/soak/answer_checks.h"
#include "node/soak/soak_record.h"
#include "proximity_server/scene/velocity_scale.h"

#include <std_msgs/Float64.h>

#include <condition_variable>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

namespace proximity_server::node {

using namespace scene;

/// Simulated time [s]: it runs at a speed, stands still or jumps. Thread-safe.
class SimulatedClock {
 public:
  double now() const;
  /// Is at `time` and goes on with `speed` [s of simulated time in a second of wall time].
  void set(double time, double speed);

 private:
  using Clock = std::chrono::steady_clock;
  mutable std::mutex mutex_;
  double time_ = 1000.0, speed_ = 1.0;
  Clock::time_point since_ = Clock::now();
};

/// A second node, which has simulated time, and whose robot moves in that time. All of its levels are checked, as
/// SoakMonitor does it.
class SimulatedNode {
 public:
  /// The robot has meshes with a tolerance of 0. All must outlive this. `rate` is the parameter of the node, `speed`
  /// that of its clock [s of simulated time in a second of wall time].
  /// Failure: throws std::runtime_error where the node does not start.
  SimulatedNode(const TestRobot& robot, SoakRecord& record, AnswerChecks::Levels levels, double rate, double speed);
  ~SimulatedNode();

  /// Stops the clock for a while; the transforms go on, with the stamp of that time. Whether the node is INVALID within
  /// the promised time, and says something at all after `seconds` more. A level that is not INVALID in between counts
  /// as wrong.
  bool staysInvalidWithoutTime(double seconds);

  /// Sets the clock ahead, or back where `seconds` is negative.
  void jump(double seconds) { clock_.set(clock_.now() + seconds, speed_); }
  double now() const { return clock_.now(); }

  /// Waits for a cycle that is right about poses from now on.
  bool awaitRightAnswer(double patience);

  /// The robot rests and states velocities, with which a link carries an object that overlaps another link by a
  /// constant depth. Whether the scale of the velocities becomes that of a robot that may touch it within `patience`
  /// [s]. To be called once.
  bool isNotSlowedByAnOverlapThatStays(Chance& chance, double patience);

 private:
  /// The state of the robot while it rests, and the objects then: a link holds one that overlaps another link, and one
  /// is ahead.
  struct Posture {
    sensor_msgs::JointState joints;
    std::vector<geometry_msgs::TransformStamped> transforms;
    ApplyObjectsRequest objects;
    double slowest, fastest;  ///< the scales for transforms as old as they may be, and for new ones
  };

  std::vector<geometry_msgs::TransformStamped> publish();
  void onClearance(const Clearance& message);
  void onScale(const std_msgs::Float64& message);
  std::optional<Posture> randomPosture(Chance& chance) const;
  bool setScales(const scene::BodyPoses& poses, const MovingState& state, const std::vector<Object>& added,
                 Posture& posture) const;

  const TestRobot& robot_;
  SoakRecord& record_;
  const AnswerChecks::Levels levels_;
  const double speed_;
  AnswerChecks checks_;
  MovingRobot motion_;
  SimulatedClock clock_;
  std::mutex mutex_;  // guards what follows, up to the publishers
  std::condition_variable arrived_;
  bool stands_still_ = false, said_so_ = false;  // the clock; the node, since then
  double last_right_ = 0.0;                      // [s] stamp
  std::uint64_t messages_ = 0;                   // of ~clearance
  std::optional<Posture> posture_;
  std::optional<double> scale_;  // the last one
  ros::Publisher clock_pub_, joints_pub_;
  std::unique_ptr<ChildProcess> node_;
  ros::Subscriber clearance_sub_;
  std::unique_ptr<TfStream> tf_;
};

}  // namespace proximity_server::node
