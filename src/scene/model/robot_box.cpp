#include "proximity_server/scene/model/robot_box.h"

#include "proximity_server/narrowphase/shape/support.h"
#include "proximity_server/scene/model/kinematics.h"

namespace proximity_server::scene {
namespace {

using Eigen::AlignedBox3d;
using Eigen::Vector3d;

/// The box of a piece in the frame of the body.
AlignedBox3d boxOf(const Piece& piece) {
  AlignedBox3d box;
  int vertex = 0;
  for (int axis = 0; axis < 3; ++axis) {
    for (const double side : {-1.0, 1.0}) {
      const Vector3d direction = side * piece.body_T_piece.linear().row(axis).transpose();
      box.extend(piece.body_T_piece * supportPoint(piece.shape, direction, vertex));
    }
  }
  const Vector3d margin = Vector3d::Constant(piece.shape.margin());
  return {box.min() - margin, box.max() + margin};
}

}  // namespace

RobotBox::RobotBox(const RobotModel& robot) {
  for (const Body& body : robot.bodies) {
    AlignedBox3d box;
    for (const int piece : body.pieces) box.extend(boxOf(robot.pieces[piece]));
    bodies_.push_back(box);
  }
}

AlignedBox3d RobotBox::at(const BodyPoses& poses) const {
  AlignedBox3d box;
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    if (bodies_[i].isEmpty() || !poses[i]) continue;
    const Vector3d centre = *poses[i] * bodies_[i].center();
    const Vector3d half = poses[i]->linear().cwiseAbs() * (0.5 * bodies_[i].sizes());
    box.extend(AlignedBox3d(centre - half, centre + half));
  }
  return box;
}

}  // namespace proximity_server::scene
