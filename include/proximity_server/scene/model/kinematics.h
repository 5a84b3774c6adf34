#pragma once

#include "proximity_server/scene/model/robot_model.h"

#include <Eigen/Geometry>

#include <initializer_list>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace proximity_server::scene {

/// The poses of the bodies in one common frame, indexed like RobotModel::bodies; nullopt if a pose is not known.
using BodyPoses = std::vector<std::optional<Eigen::Isometry3d>>;

/// The motion of a joint with one degree of freedom at `position` [rad] or [m]; the identity for floating and planar
/// joints.
/// Error: a few units in the last place; the same bits on every processor.
Eigen::Isometry3d jointMotion(const Joint& joint, double position);

/// Returns the position of a joint with one degree of freedom, [rad] in (-pi, pi] or [m], given the pose of its child
/// body in its parent body.
double jointPosition(const RobotModel& model, const Joint& joint, const Eigen::Isometry3d& parent_T_child);

/// The rotation about a unit vector by an angle [rad].
/// Error:  a few units in the last place; the same bits on every processor.
/// Source: Rodrigues, Des lois geometriques qui regissent les deplacements d'un systeme solide, 1840.
Eigen::Matrix3d rotationAbout(const Eigen::Vector3d& axis, double angle);

/// The shortest rotation that turns the z axis into a unit vector; half a turn about x for -z.
/// Error: a few units in the last place.
Eigen::Quaterniond turnFromZ(const Eigen::Vector3d& unit);

/// The poses of all bodies, each in the frame of the root link of its robot. `positions` [rad] or [m] has one entry for
/// each of RobotModel::joints; the entry of a mimic joint is ignored, because it follows its leader. Floating and
/// planar joints stay at the identity.
/// Throws std::invalid_argument if there is not one position for each joint.
BodyPoses forwardKinematics(const RobotModel& model, const std::vector<double>& positions);

/// Takes positions by name; joints that are not named are at 0. Throws std::invalid_argument for a name that is not the
/// name of a movable joint of the robot.
BodyPoses forwardKinematics(const RobotModel& model, const std::map<std::string, double>& positions);

/// Takes positions that are written out: forwardKinematics(model, {{"elbow", 0.5}}). With {} all joints are at 0.
BodyPoses forwardKinematics(const RobotModel& model,
                            std::initializer_list<std::pair<const std::string, double>> positions);

/// Transforms poses into a common frame, in which the root links of the robots have the poses `common_T_roots`, one for
/// each of RobotModel::robots. `in_roots` are the poses in the frames of these links. If the root of a robot has no
/// pose, its bodies have none either.
BodyPoses placedAt(const RobotModel& model, BodyPoses in_roots,
                   const std::vector<std::optional<Eigen::Isometry3d>>& common_T_roots);

}  // namespace proximity_server::scene
