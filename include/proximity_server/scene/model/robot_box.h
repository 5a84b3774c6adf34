#pragma once

#include "proximity_server/scene/model/kinematics.h"
#include "proximity_server/scene/model/robot_model.h"

#include <Eigen/Geometry>

#include <vector>

namespace proximity_server::scene {

/// A bounding box of a robot's collision geometry.
class RobotBox {
 public:
  explicit RobotBox(const RobotModel& robot);

  /// The box along the axes of the frame of the poses [m] that contains the boxes of all bodies, each along the axes of
  /// its own frame. A body without a pose or without geometry does not count; the box isEmpty() if no body counts.
  Eigen::AlignedBox3d at(const BodyPoses& poses) const;

 private:
  std::vector<Eigen::AlignedBox3d> bodies_;  ///< the boxes of the bodies in their own frames
};

}  // namespace proximity_server::scene
