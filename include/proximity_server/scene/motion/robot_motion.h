#pragma once

#include "proximity_server/narrowphase/motion/motion.h"
#include "proximity_server/scene/model/kinematics.h"
#include "proximity_server/scene/model/robot_model.h"

#include <optional>
#include <vector>

namespace proximity_server::scene {

/// The motion of all bodies of a robot, and of the frames that carry objects, over the time [0, 1].
class RobotMotion {
 public:
  /// The motion of a frame in the frame of its parent.
  struct Segment {
    int parent = -1;
    bool is_known = false;
    narrowphase::ScrewMotion motion;
  };

  /// Moves every joint at constant velocity. `travel` [rad] or [m] has one entry for each of RobotModel::joints; the
  /// entry of a mimic joint is ignored, because it follows its leader. Floating and planar joints rest. A body whose
  /// pose is missing at the start has no pose later, and neither have the bodies that it carries.
  /// Throws std::invalid_argument for a wrong number of poses or joints, and for a travel that is not finite.
  static RobotMotion ofTravel(const RobotModel& model, const BodyPoses& start, const std::vector<double>& travel);

  /// Becomes that motion, and keeps its memory and the frames of objects.
  void setTravel(const RobotModel& model, const BodyPoses& start, const std::vector<double>& travel);

  /// A motion that is linear in joint space, from one state to another, see forwardKinematics.
  static RobotMotion between(const RobotModel& model, const std::vector<double>& from, const std::vector<double>& to);

  /// The constant velocities of a body on its own: of its origin [m] and its turn [rad] per unit of time, in the
  /// frame of the poses.
  struct Twist {
    Eigen::Vector3d linear = Eigen::Vector3d::Zero(), angular = Eigen::Vector3d::Zero();
  };
  static RobotMotion ofTwists(const BodyPoses& start, const std::vector<Twist>& twists);

  /// Sets `motion` to the motion of the joints by `travel` from where they are after `before`; both as in ofTravel().
  /// The frames of objects stay as they are.
  /// Precondition: ofTravel() or between() made this motion, and the model exists.
  void after(const std::vector<double>& before, const std::vector<double>& travel, RobotMotion& motion) const;

  BodyPoses at(double time) const;
  void at(double time, BodyPoses& poses) const;

  /// One segment for each body. If its parent is -1, it is in the frame of the poses.
  const std::vector<Segment>& segments() const { return segments_; }

  /// The motion of the frames that carry objects. Attached objects have no frame: they move with the body of their
  /// link.
  ///
  /// The world is the frame in which fixed objects stand. Its parent is a body or, for -1, the frame of the poses. By
  /// default the world is the frame of the poses. The other frames are the ones of Objects::frames(), in this order.
  /// Their parent is a body or, for -1, the world. Without them no moving object has a pose.
  struct ObjectFrames {
    Segment world = {-1, true, {}};
    std::vector<Segment> moving;
  };

  /// A segment at rest in its parent. If the given pose is missing or not valid, the pose of the segment is unknown.
  /// For a moving object whose motion is not known, use this with its pose in the world: it is then taken to be at
  /// rest.
  static Segment atRest(const std::optional<Eigen::Isometry3d>& parent_T_frame, int parent = -1);

  /// A frame with a constant twist in the world.
  static Segment withTwist(const std::optional<Eigen::Isometry3d>& world_T_frame, const Twist& twist);

  /// Throws std::invalid_argument for a parent that is not a body, and for a velocity or pose that is not finite.
  void carryObjects(const ObjectFrames& frames);
  const ObjectFrames& objectFrames() const { return object_frames_; }

  /// The poses at one time in the world, as State::set() takes them: the poses of the bodies and of
  /// ObjectFrames::moving. All are missing if the pose of the world is missing.
  struct State {
    BodyPoses bodies;
    std::vector<std::optional<Eigen::Isometry3d>> frames;
  };
  State inWorld(double time) const;

  /// The pose of the world in the frame of the poses, if it is known; `bodies` are the poses at this time.
  std::optional<Eigen::Isometry3d> worldAt(double time, const BodyPoses& bodies) const;

 private:
  const RobotModel* model_ = nullptr;
  std::vector<Segment> segments_;
  ObjectFrames object_frames_;
};

/// True if a segment is always equal to its parent.
bool isIdentity(const RobotMotion::Segment& segment);

}  // namespace proximity_server::scene
