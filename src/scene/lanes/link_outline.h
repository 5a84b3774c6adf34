#pragma once

#include "proximity_server/scene/model/robot_model.h"
#include "scene/bounds/bounds.h"

#include <Eigen/Core>

#include <array>
#include <cstddef>
#include <vector>

namespace proximity_server::scene {

/// A ball in the frame of the body. Metres.
struct Ball {
  Eigen::Vector3d centre;
  double radius;
};

constexpr std::size_t kCoarseCorners = 24;
constexpr int kInnerBalls = 24;  ///< the largest number for a link

/// The hull of points around the core of one convex piece, and its margin. Frame: the body.
struct PieceOutline {
  std::vector<Eigen::Vector3d> corners;  ///< the core is in their hull, or sticks out of it by the rounding of the link
  double margin = 0.0;                   ///< [m] around the core
  bool is_exact = false;                 ///< the core is their hull
};

/// Shapes that contain a link and shapes that it contains, without the paddings of pairs.
struct LinkOutline {
  Bounds bounds;  ///< sphere and box

  /// These balls are the corners of the pieces of the link, with their margins. The link, with the space inside of its
  /// closed meshes, is in the hull of the balls, or sticks out of it by at most `uncovered` [m]. A cylinder has the
  /// corners of a prism around it.
  std::vector<Ball> corners;
  double uncovered = 0.0;

  /// The first `coarse_corners` corners are far apart. The link sticks out of their hull by at most `coarse_uncovered`
  /// [m].
  std::size_t coarse_corners = 0;
  double coarse_uncovered = 0.0;

  bool is_exact = false;                             ///< the hull of the corners is exactly the link
  Eigen::Vector3d inside = Eigen::Vector3d::Zero();  ///< a point in the hull of the centres

  /// Each ball lies inside of one of the pieces. The largest ball comes first.
  std::vector<Ball> inner;

  std::vector<PieceOutline> pieces;

  /// Each interior of a closed mesh is in the hull of the corners of its box.
  std::vector<PieceOutline> interiors;

  /// The ball of each piece that may be inside of an interior of another link, see PieceSearch.
  std::vector<Ball> representatives;
};

/// Makes the outline of a link that has geometry; `bounds` contain the link.
///
/// Inner balls: take the surface point that is farthest from all balls so far. Add the ball that touches the surface
/// there and whose radius is the depth of its centre, which is proven by the planes of the surface. A capsule has balls
/// along its axis.
LinkOutline outlineOf(const RobotModel& model, int link, const Bounds& bounds);

/// [m] A lower bound of the depth of a point in a piece, both in the body's frame; negative if the point may be
/// outside.
double depthIn(const Piece& piece, const Eigen::Vector3d& point);

}  // namespace proximity_server::scene
