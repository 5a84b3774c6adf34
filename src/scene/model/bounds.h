#pragma once

#include <Eigen/Core>
#include <limits>
#include <vector>

#include "proximity_server/scene/model/robot_model.h"

namespace proximity_server::scene {

/// What rounding may add to or take from a distance between pieces of two bodies, relative to the sum of how far they
/// reach from their bodies' origins and of how far apart they are.
///
/// To first order in eps: a rotation is off by 12 eps when it comes from a pose, by 5 more in a product with a fixed
/// one, and the relative rotation of two such by 39 in all, which moves points by as much of their reach. The sums and
/// dot products of a bound add less than 10.
constexpr double kPoseRounding = 64.0 * std::numeric_limits<double>::epsilon();

/// A sphere and a box about one centre that hold some pieces of a body, enlarged by the rounding of their own reach.
/// Frame: the body's. Metres.
struct Bounds {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  double radius = 0.0;
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();  ///< of the box, unit columns
  Eigen::Vector3d half = Eigen::Vector3d::Zero();      ///< of the box, along its axes
  double reach = 0.0;                                  ///< at least how far the pieces reach from the body's origin
};

/// [m] Upper bound of the distance of any point of a piece from a point in the frame of its body.
double reachFrom(const Eigen::Vector3d& point, const Piece& piece);

Bounds boundsOf(const Piece& piece);

/// `each` are the bounds of the `pieces`.
Bounds boundsOf(const std::vector<const Piece*>& pieces, const std::vector<const Bounds*>& each);

/// A lower bound [m] of the signed distance between what the spheres hold; `between` leads from centre a to centre b.
double sphereGap(const Eigen::Vector3d& between, const Bounds& a, const Bounds& b);

/// The same for the boxes, whose axes are given in the frame of `between`.
///
/// It is the largest of three: the distance of box a from the box along its axes that holds b, the same the other way
/// round, and the gap along the line of the centres.
double boxGap(const Eigen::Vector3d& between, const Bounds& a, const Eigen::Matrix3d& axes_a, const Bounds& b,
              const Eigen::Matrix3d& axes_b);

}  // namespace proximity_server::scene
