#pragma once

#include "proximity_server/scene/model/joint_ranges.h"
#include "proximity_server/scene/model/kinematics.h"
#include "proximity_server/scene/model/robot_model.h"
#include "proximity_server/scene/objects/objects.h"
#include "proximity_server/scene/query/question.h"

#include <Eigen/Geometry>

#include <vector>

namespace proximity_server::tools {

/// A convex piece at its place.
struct PlacedPiece {
  const scene::Piece* piece;
  Eigen::Isometry3d world_T_piece;
};

/// The pieces of a whole link or object, in the frame of the poses.
struct PlacedPieces {
  std::vector<PlacedPiece> pieces;
  bool has_half_space = false;  ///< then the pieces are not all
  bool has_interior = false;    ///< a closed mesh: what lies wholly inside overlaps it, and touches none of its pieces
};

/// `objects` is nullptr if there are none. The pieces refer to the robot and the objects.
PlacedPieces placedPieces(const scene::ShapeRef& ref, const scene::RobotModel& robot, const scene::Objects* objects,
                          const scene::BodyPoses& poses);

}  // namespace proximity_server::tools
