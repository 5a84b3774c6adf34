#pragma once

#include "proximity_server/scene/model/joint_ranges.h"
#include "proximity_server/scene/model/kinematics.h"
#include "proximity_server/scene/motion/robot_motion.h"
#include "proximity_server/scene/objects/object_editor.h"
#include "proximity_server/scene/objects/objects.h"
#include "proximity_server/scene/state/state.h"

#include <Eigen/Geometry>

#include <memory>
#include <string>
#include <utility>

// Objects where there is no tf: their frames are links of the robot, whose poses follow from the robot's state. The
// root link of the first robot is the frame in which fixed objects stand.

namespace proximity_server::scene {

// Failure: each function throws std::invalid_argument for a frame that is not a link of the robot.

/// The frames for operations on objects, in one state of the robot.
class LinkFrames : public ObjectFrames {
 public:
  /// `poses` are needed only to change the frame of an object. The robot must outlive it.
  explicit LinkFrames(const RobotModel& robot, BodyPoses poses = {}) : robot_(robot), poses_(std::move(poses)) {}

  std::string named(const std::string& name) const override;
  std::string ofLink(const std::string& link) const override { return link; }
  Eigen::Isometry3d seenFrom(const std::string& frame, const std::string& other,
                             const Eigen::Isometry3d& pose) override;

 private:
  const RobotModel& robot_;
  BodyPoses poses_;
};

/// The empty set of objects of a robot. Its root link stands still, because it is the frame of all poses.
Objects noObjects(const std::shared_ptr<const SceneModel>& model,
                  ObjectRules::FreeObjects free_objects = ObjectRules::FreeObjects::NotChecked);

/// The link in whose frame an object stands or moves, or which holds it.
int carryingLink(const RobotModel& robot, const Object& object);

/// The pose of a link in the frame of the poses. The poses must contain the pose of the link's body.
Eigen::Isometry3d poseOfLink(const RobotModel& robot, int link, const BodyPoses& poses);

/// Sets the poses of a state, in the frame of the root link: the poses of all bodies, and with them of the frames.
void setPoses(State& state, const BodyPoses& poses);

/// Sets them to those at some positions of the joints.
void setPositions(State& state, const Positions& positions);

/// The frames of moving objects for a motion: each frame is at rest relative to its link.
RobotMotion::ObjectFrames framesOnLinks(const Objects& objects);

}  // namespace proximity_server::scene
