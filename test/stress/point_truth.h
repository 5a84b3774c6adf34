#pragma once

#include "oracle/point_oracle.h"
#include "proximity_server/scene/model/kinematics.h"
#include "proximity_server/scene/model/robot_model.h"

#include <vector>

// The truth about points and rays around a robot, in long double, from the faces of its pieces.

namespace proximity_server::scene {

using narrowphase::DistanceBounds;
using narrowphase::LongPose;
using narrowphase::PointOracle;
using narrowphase::Vector3l;

/// A convex piece of a link.
struct OraclePiece {
  OraclePiece(const RobotModel& robot, const Piece& of_robot);
  /// A piece of what a link holds, with its pose in the body of the link; it must outlive this.
  OraclePiece(const Piece& of_held, int holder, int body_of_holder)
      : piece(of_held), link(holder), body(body_of_holder), oracle(of_held.shape) {}

  const Piece& piece;
  int link, body;
  PointOracle oracle;
};

/// All pieces of the links of a robot, which must outlive them.
std::vector<OraclePiece> oraclePiecesOf(const RobotModel& robot);

/// The pieces of a robot in their places. Points are in the frame of the poses, with metres.
class PointTruth {
 public:
  /// `pieces` must outlive this.
  PointTruth(const std::vector<OraclePiece>& pieces, const BodyPoses& poses);

  /// The signed distance of a point from all links, or from one of them: of the closest or deepest piece, or the depth in
  /// the inside of a closed mesh. Interior, which has tests of its own, knows that.
  struct Place {
    DistanceBounds distance;
    bool is_in_mesh = false;  ///< the inside of a mesh decides
  };
  static constexpr int kAllLinks = -1;
  Place placeOf(const Vector3l& point, int link = kAllLinks) const;

  /// [m] Where a ray meets the first piece; 0 if it begins inside of one, or of a closed mesh, and infinity if it meets none.
  /// `direction`: of unit length.
  long double firstHit(const Vector3l& origin, const Vector3l& direction) const;

  /// True if a line meets a piece that is within `reach` [m] of a point on it at a small angle, or misses that piece.
  bool grazes(const Vector3l& point, const Vector3l& direction, long double reach) const;

 private:
  struct Placed {
    const OraclePiece& of;
    LongPose piece_T_near;
    Eigen::Vector3d centre;  ///< of a ball about the piece, in the frame "near"
    double radius;           ///< [m] with the rounding of the centre
  };

  const Vector3l origin_;  ///< of the frame "near", whose axes are those of the poses, so that its numbers are small
  std::vector<Placed> pieces_;
};

}  // namespace proximity_server::scene
