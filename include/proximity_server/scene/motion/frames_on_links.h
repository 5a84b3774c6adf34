#pragma once

#include <Eigen/Geometry>
#include <string>
#include <variant>

#include "proximity_server/scene/model/kinematics.h"
#include "proximity_server/scene/motion/robot_motion.h"
#include "proximity_server/scene/object_files/object_file.h"
#include "proximity_server/scene/objects/objects.h"
#include "proximity_server/scene/query/scene.h"

// Objects where there is no tf: their frames are links of the robot, whose poses follow from its state. The root link of the first robot
// is the frame in which things stand still.

namespace proximity_server::scene {

// Failure: each function throws std::invalid_argument for a frame that is no link of the robot.

/// The placement of an object whose pose is given in the frame of a link. In that of the root link, or in none, it stands still.
std::variant<Fixed, Moving> standingIn(const RobotModel& robot, const std::string& frame,
                                       const Eigen::Isometry3d& pose);
Placement placementOf(const RobotModel& robot, const WrittenPlace& place);

/// The link in whose frame an object stands, moves or is held.
int carryingLink(const RobotModel& robot, const Object& object);

/// The pose of an object in the frame of its carrying link.
const Eigen::Isometry3d& poseInCarrier(const Object& object);

/// The pose of a link in the frame of the poses, among which must be that of its body.
Eigen::Isometry3d poseOfLink(const RobotModel& robot, int link, const BodyPoses& poses);

/// The pose of an object in the frame of a link. Among the poses must be those of both bodies.
Eigen::Isometry3d seenFrom(const RobotModel& robot, int link, const Object& object, const BodyPoses& poses);

/// The poses of the frames of moving objects, as Scene::update() takes them.
FramePoses framePoses(const Objects& objects, const BodyPoses& poses);

/// The same for a motion: each frame rests in its link.
RobotMotion::ObjectFrames framesOnLinks(const Objects& objects);

}  // namespace proximity_server::scene
