#pragma once

#include "proximity_server/scene/model/robot_model.h"
#include "scene/bounds/bounds.h"
#include "scene/motion/moving_bodies.h"

#include <vector>

namespace proximity_server::scene {

/// How far the joint that carries a body may be off its motion; all 0 for a body without a joint that moves.
struct JointDeviation {
  bool turns = false;
  Eigen::Vector3d axis = Eigen::Vector3d::Zero();  ///< unit, in the frame of the body, through its origin
  double most = 0.0;                               ///< [rad] or [m] off the motion, at any time
  double half_travel = 0.0;                        ///< [rad] or [m] from the middle of the motion to either end
};

/// One for each of RobotModel::bodies; empty: every joint is where its motion says.
using JointDeviations = std::vector<JointDeviation>;

/// Sets the deviations. Per joint [rad] or [m]: how far it travels during the motion, and how far it may be off. Mimic
/// joints follow.
void setDeviations(const RobotModel& robot, const std::vector<double>& travel, const std::vector<double>& most,
                   JointDeviations& deviations);

/// A geometry that a frame of PosesInTime carries.
struct Carried {
  int frame;
  const Bounds& bounds;
};

/// [m] An upper bound of how much the distance of two geometries can differ, at any time, from the distance in the
/// motion.
///
/// 1. See FreeMotion: seen from one frame on the path between the two, each joint between this frame and a geometry
///    moves the points of the geometry by at most its deviation times their largest distance from the axis. The
///    distances are taken along the motion, and nothing is linearised.
/// 2. The distances from an axis are computed in the middle of the motion. Until its ends they grow by no more than the
///    joints behind the axis move the points by their own motion.
/// 3. The frame is free to choose. A joint near geometry a is seen to move a, and a joint near b to move b: the frame
///    with the smallest sum counts.
///
/// Error:        rounded up. Bounding volumes stand for the geometry.
/// Precondition: the poses of both frames are known.
///               `on_a` is working memory.
double distanceDeviation(const JointDeviations& deviations, const Carried& a, const Carried& b, PosesInTime& poses,
                         std::vector<double>& on_a);

}  // namespace proximity_server::scene
