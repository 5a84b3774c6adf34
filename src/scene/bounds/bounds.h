#pragma once

#include "proximity_server/scene/model/robot_model.h"

#include <Eigen/Geometry>

#include <limits>
#include <vector>

namespace proximity_server::scene {

/// The rounding error of a distance between pieces of two bodies, relative to the sum of three lengths: the reach of
/// each piece from the origin of its body, and the distance of these origins.
///
/// To first order in eps: the error of a rotation from a pose is 12 eps, and a product with a fixed rotation adds 5
/// eps. So the relative rotation of two of these has an error of 39 eps in all, which moves a point by the same
/// fraction of its reach. The sums and dot products of a bound add less than 10 eps.
constexpr double kPoseRounding = 64.0 * std::numeric_limits<double>::epsilon();

/// A sphere and a box with the same centre. Both contain some pieces of a body, and are enlarged by the rounding of the
/// pieces' reach.
/// Frame: that of the body. Metres.
struct Bounds {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  double radius = 0.0;
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();  ///< the axes of the box, unit columns
  Eigen::Vector3d half = Eigen::Vector3d::Zero();      ///< half of the edges of the box, along its axes
  double reach = 0.0;  ///< [m] the largest distance of a point of the pieces from the body's origin
};

Bounds boundsOf(const Piece& piece);

/// `each` are the bounds of the `pieces`.
Bounds boundsOf(const std::vector<const Piece*>& pieces, const std::vector<const Bounds*>& each);

/// The bounds of a box along the axes of its frame.
Bounds boundsOf(const Eigen::AlignedBox3d& box);

/// The pose of one body in the frame of another.
struct RelativePose {
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();
};

/// The centre of b minus the centre of a, in the frame of a.
inline Eigen::Vector3d centreOffset(const Bounds& a, const Bounds& b, const RelativePose& a_T_b) {
  return a_T_b.translation + (a_T_b.rotation * b.centre - a.centre);
}

/// [m] A lower bound of the signed distance between the contents of the spheres of two bodies.
inline double sphereGap(const Bounds& a, const Bounds& b, const RelativePose& a_T_b) {
  return (1.0 - kPoseRounding) * centreOffset(a, b, a_T_b).norm() - (a.radius + b.radius);
}

/// [m] A lower bound of the signed distance between the contents of the boxes of two bodies.
double boxGap(const Bounds& a, const Bounds& b, const RelativePose& a_T_b);

/// [m] A lower bound like that of the other boxGap(), for boxes whose axes are given in another frame. `between` is the
/// centre of b minus the centre of a, in that frame.
///
/// It is the largest of three bounds: the distance of box a from the bounding box of b along the axes of a, the
/// distance of box b from the bounding box of a along the axes of b, and the gap along the line of the centres.
double boxGap(const Eigen::Vector3d& between, const Bounds& a, const Eigen::Matrix3d& axes_a, const Bounds& b,
              const Eigen::Matrix3d& axes_b);

}  // namespace proximity_server::scene
