#pragma once

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

/// What is not known exactly of a robot and its objects: the set of states that may be true. All of its parts are
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
  /// all that is behind it. The origin is that of the joint; for planar and floating joints it is that of the child.
  std::vector<PoseUncertainty> frames;
  /// One for each of RobotModel::robots: the pose of its root, relative to everything that it does not carry.
  std::vector<PoseUncertainty> bases;
  /// [m] One for each of RobotModel::links: its surface may be this far outside of its geometry.
  std::vector<double> swellings;
  /// The pose of each object on what carries it, without and with an entry of its own. The origin is that of the
  /// object. An id may be that of an object that does not exist.
  PoseUncertainty objects;
  std::map<std::string, PoseUncertainty> own_objects;

  const PoseUncertainty& ofObject(const std::string& id) const;

  /// Throws std::invalid_argument, naming the joint, robot, link or object, for a value that is negative or not finite,
  /// and for an entry of `positions` that must be 0; also for a list of the wrong length.
  void requireValidFor(const RobotModel& robot) const;
};

}  // namespace proximity_server::scene
