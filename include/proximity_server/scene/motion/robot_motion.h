#pragma once

#include <optional>
#include <vector>

#include "proximity_server/narrowphase/motion/motion.h"
#include "proximity_server/scene/model/kinematics.h"
#include "proximity_server/scene/model/robot_model.h"

namespace proximity_server::scene {

/// How all bodies of a robot, and the frames that carry objects, move over the time [0, 1], from one set of poses on.
class RobotMotion {
 public:
  /// A frame in the one of its parent.
  struct Segment {
    int parent = -1;
    bool is_known = false;
    narrowphase::ScrewMotion motion;
  };

  /// Every joint at constant velocity. `travel` [rad] or [m] has one entry for each of RobotModel::joints; the entry of
  /// a mimic joint is ignored, because it follows its leader. Floating and planar joints rest. A body whose pose is
  /// missing at the start has none later, nor have the bodies that it carries.
  /// Throws std::invalid_argument for a wrong number of poses or joints, and for a travel that is not finite.
  static RobotMotion ofTravel(const RobotModel& model, const BodyPoses& start, const std::vector<double>& travel);

  /// Linear in joint space from one state to another, see forwardKinematics.
  static RobotMotion between(const RobotModel& model, const std::vector<double>& from, const std::vector<double>& to);

  /// Each body on its own, at the constant velocities of its origin [m] and turn [rad] per unit of time, in the frame
  /// of the poses.
  struct Twist {
    Eigen::Vector3d linear = Eigen::Vector3d::Zero(), angular = Eigen::Vector3d::Zero();
  };
  static RobotMotion ofTwists(const BodyPoses& start, const std::vector<Twist>& twists);

  BodyPoses at(double time) const;

  /// The bodies; parent -1: the frame of the poses.
  const std::vector<Segment>& segments() const { return segments_; }

  /// How what carries objects moves. Attached objects are not meant: they move with the body of their link.
  ///
  /// The world is the frame in which fixed objects stand. Its parent is a body or, for -1, the frame of the poses, which it
  /// is by default. The other frames are those of Objects::frames(), in this order. Their parent is a body or, for -1, the
  /// world; without them no moving object has a pose.
  struct ObjectFrames {
    Segment world = {-1, true, {}};
    std::vector<Segment> moving;
  };

  /// A segment that rests in its parent; its pose is unknown if this one is missing or no pose. A moving object whose
  /// motion is not known is given one: it is taken to be at rest in the world.
  static Segment atRest(const std::optional<Eigen::Isometry3d>& parent_T_frame, int parent = -1);

  /// A frame with a constant twist, seen in the world.
  static Segment withTwist(const std::optional<Eigen::Isometry3d>& world_T_frame, const Twist& twist);

  /// Throws std::invalid_argument for a parent that is no body, and for a velocity or pose that is not finite.
  void carryObjects(ObjectFrames frames);
  const ObjectFrames& objectFrames() const { return object_frames_; }

  /// The poses at a time as Scene::update() takes them: those of the bodies, and of ObjectFrames::moving, in the world.
  /// All are missing if that of the world is.
  struct State {
    BodyPoses bodies;
    std::vector<std::optional<Eigen::Isometry3d>> frames;
  };
  State inWorld(double time) const;

 private:
  std::vector<Segment> segments_;
  ObjectFrames object_frames_;
};

/// Whether a segment is its parent.
bool isIdentity(const RobotMotion::Segment& segment);

}  // namespace proximity_server::scene
