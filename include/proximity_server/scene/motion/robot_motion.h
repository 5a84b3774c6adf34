#pragma once

#include <vector>

#include "proximity_server/narrowphase/motion/motion.h"
#include "proximity_server/scene/model/kinematics.h"
#include "proximity_server/scene/model/robot_model.h"

namespace proximity_server::scene {

/// How all bodies of a robot move over the time [0, 1], from one set of poses on.
class RobotMotion {
 public:
  /// Every joint at constant velocity. `travel` [rad] or [m] has one entry for each of RobotModel::joints; the entry of
  /// a mimic joint is ignored, because it follows its leader. Floating and planar joints rest. A body whose pose is
  /// missing at the start has none later, nor have the bodies that it carries.
  /// Throws std::invalid_argument for a wrong number of poses or joints, and for a travel that is not finite.
  static RobotMotion ofJoints(const RobotModel& model, const BodyPoses& start, const std::vector<double>& travel);

  /// Linear in joint space from one state to another, see forwardKinematics.
  static RobotMotion ofJoints(const RobotModel& model, const std::vector<double>& from, const std::vector<double>& to);

  /// Each body on its own, at the constant velocities of its origin [m] and turn [rad] per unit of time, in the frame
  /// of the poses.
  struct Twist {
    Eigen::Vector3d linear = Eigen::Vector3d::Zero(), angular = Eigen::Vector3d::Zero();
  };
  static RobotMotion ofTwists(const BodyPoses& start, const std::vector<Twist>& twists);

  BodyPoses at(double time) const;

  /// A body in the frame of its parent; parent -1: in that of the poses.
  struct Segment {
    int parent = -1;
    bool is_known = false;
    narrowphase::ScrewMotion motion;
  };
  const std::vector<Segment>& segments() const { return segments_; }

 private:
  std::vector<Segment> segments_;
};

}  // namespace proximity_server::scene
