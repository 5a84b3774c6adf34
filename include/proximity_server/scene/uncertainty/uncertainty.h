#pragma once

#include "proximity_server/scene/files/file_value.h"
#include "proximity_server/scene/model/robot_model.h"

#include <map>
#include <string>
#include <vector>

namespace proximity_server::scene {

/// How far a frame may be from where it is taken to be: it is displaced by at most `translation` [m] in any direction,
/// and turned by at most `angle` [rad] about any axis through its origin.
struct PoseUncertainty {
  double translation = 0.0;
  double angle = 0.0;

  bool isZero() const { return translation == 0.0 && angle == 0.0; }
};

/// The set of states that may be true, where a robot and its objects are not known exactly. All of its parts are
/// independent of each other, and all numbers are bounds. By default everything is exact.
struct Uncertainty {
  Uncertainty() = default;

  /// Nothing of this robot is uncertain.
  explicit Uncertainty(const RobotModel& robot);

  /// [rad] or [m] One for each of RobotModel::joints: its position is off by at most this, to either side. The entry of
  /// a mimic joint is ignored, because it follows its leader. It must be 0 for planar and floating joints, which have a
  /// frame only.
  std::vector<double> positions;
  /// One for each of RobotModel::joints: the place of the joint on its parent. So a link that is 3 mm longer displaces
  /// all that is behind it. The origin is the joint's; for planar and floating joints it is the child's.
  std::vector<PoseUncertainty> frames;
  /// One for each of RobotModel::robots: the pose of its root, relative to everything that it does not carry.
  std::vector<PoseUncertainty> bases;
  /// [m] One for each of RobotModel::links: its surface may be this far outside of its geometry.
  std::vector<double> swellings;
  /// The pose of each object on what carries it, without and with an entry of its own. The origin is the object's. An
  /// object with the id need not exist.
  PoseUncertainty objects;
  std::map<std::string, PoseUncertainty> own_objects;

  const PoseUncertainty& ofObject(const std::string& id) const;

  /// True if nothing is uncertain.
  bool isZero() const;

  /// Throws std::invalid_argument, naming the joint, robot, link or object, for a value that is negative or not finite,
  /// and for an entry of `positions` that must be 0; also for a list of the wrong length.
  void requireValidFor(const RobotModel& robot) const;
};

/// The position of every joint is off by at most a number of radians or metres; planar and floating joints and all else
/// are exact.
Uncertainty uncertaintyOfJoints(const RobotModel& robot, double position);

/// Reads YAML with the names of the node's parameters. A number alone is the joint_uncertainty. Each name is optional,
/// and what is not named is exact:
///
/// * joint_uncertainty: a number [rad] or [m] for every joint, or {joint: number}
/// * joint_frame_uncertainty: a pose for every joint, or {joint: pose}
/// * base_uncertainty: a pose for every robot, or {robot: pose}
/// * object_uncertainty: a pose for every object, or {object: pose}
/// * link_uncertainty: a number [m] for the surface of every link, or {link: number}
///
/// A pose is {translation: [m], angle: [rad]}, or the number of its translation. In a map "*" stands for all that it
/// does not name.
///
/// Failure: throws std::invalid_argument with `source`, the line, the field and the reason; also for a joint that mimics
///          another one, for what does not exist, and as requireValidFor() does. An object need not exist.
Uncertainty uncertaintyFrom(const std::string& yaml, const std::string& source, const RobotModel& robot);

/// Reads an uncertainty from a value of a file or parameter.
Uncertainty uncertaintyFrom(const FileValue& value, const std::string& source, const RobotModel& robot);

/// Largest speeds of frames by name, as translation [m/s] and angle [rad/s]; kOthers stands for all that have no entry.
using FrameSpeeds = std::map<std::string, PoseUncertainty>;
constexpr char kOthers[] = "*";

/// Reads speeds in the form of object_uncertainty: one pose for all, or {name: pose}; {} has no speeds.
/// Failure: throws std::invalid_argument with `source`, the field and the reason.
FrameSpeeds frameSpeedsFrom(const FileValue& value, const std::string& source);

/// nullptr if neither the name nor kOthers has a speed.
const PoseUncertainty* speedOf(const FrameSpeeds& speeds, const std::string& name);

}  // namespace proximity_server::scene
