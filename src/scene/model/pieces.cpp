#include "scene/model/pieces.h"

#include "scene/mesh/input_limits.h"

#include <algorithm>
#include <sstream>
#include <stdexcept>

namespace proximity_server::scene {

using Eigen::Vector3d;

double reachFrom(const Vector3d& point, const Piece& piece) {
  const Vector3d in_piece = piece.body_T_piece.inverse(Eigen::Isometry) * point;
  if (piece.shape.kind() != narrowphase::Shape::Kind::Hull)
    return (in_piece - piece.shape.centre()).norm() + piece.shape.coreRadius() + piece.shape.margin();
  double reach = 0.0;
  for (const Vector3d& vertex : piece.shape.hull().vertices()) reach = std::max(reach, (vertex - in_piece).norm());
  return reach + piece.shape.margin();
}

void requireNear(const Piece& piece, const char* frame) {
  const double reach = reachFrom(Vector3d::Zero(), piece);
  if (reach <= kFarthest) return;
  std::ostringstream text;
  text << "it reaches " << reach << " m from the frame of " << frame << ", " << kTooFar;
  throw std::invalid_argument(text.str());
}

double RobotModel::reachOf(int link, const Vector3d& point) const {
  double reach = 0.0;
  for (const int collision : links[link].collisions) {
    for (const int piece : collisions[collision].pieces) reach = std::max(reach, reachFrom(point, pieces[piece]));
  }
  return reach;
}

}  // namespace proximity_server::scene
