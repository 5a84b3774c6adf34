#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <vector>

#include "proximity_server/scene/model/robot_model.h"
#include "scene/bounds/bounds.h"

namespace proximity_server::scene {

/// A ball. Frame: the body's. Metres.
struct Ball {
  Eigen::Vector3d centre;
  double radius;
};

constexpr std::size_t kFewCorners = 24;
constexpr int kInnerBalls = 24;  ///< at most, of a link

/// What a link is contained in, and what it contains, without paddings of pairs.
struct LinkOutline {
  Bounds bounds;  ///< sphere and box

  /// The link, and what is inside of its closed meshes, is in the hull of these balls, the corners of its pieces with their
  /// margins; or sticks out of it by no more than `uncovered` [m]. A cylinder has the corners of a prism about it.
  std::vector<Ball> corners;
  double uncovered = 0.0;

  /// The same of the first `few` of the corners, which are spread.
  std::size_t few = 0;
  double uncovered_by_few = 0.0;

  bool is_exact = false;                             ///< the link is the hull of the corners
  Eigen::Vector3d inside = Eigen::Vector3d::Zero();  ///< in the hull of the centres

  /// Each lies inside of one of the pieces, the ball of the largest radius first.
  std::vector<Ball> inner;
};

/// The outline of a link that has geometry, with these bounds.
///
/// Inner balls: take the point of the surface that is farthest from all balls so far, and the ball that touches the surface
/// there, as large as the depth of its centre, which is proven by the planes of the surface, allows. A capsule has balls along
/// its axis.
LinkOutline outlineOf(const RobotModel& model, int link, const Bounds& bounds);

/// [m] A lower bound of the depth of a point in a piece, both in the body's frame; negative if it may be outside.
double depthIn(const Piece& piece, const Eigen::Vector3d& point);

}  // namespace proximity_server::scene
