#pragma once

#include "proximity_server/scene/motion/joint_spline.h"

#include <memory>
#include <vector>

// The motion that controllers were commanded, and what is not known of it.

namespace proximity_server::scene {

/// Splines of joints, at least one, in the order of their times [s]. Each begins when the one before ends, or later.
/// Before the first, between two and after the last, the joints rest.
struct JointSplines {
  std::vector<SplineSegment> segments;
  /// [s] From this time on the splines are exact; infinity: they end a motion, and are never exact.
  double exact_from = 0.0;
  std::vector<double> inexact_before;  ///< [rad] or [m] of all joints: how far the splines may be off until then

  TrajectoryPoint stateAt(double time) const;
  double positionAt(int joint, double time) const;
  /// Gives a joint of `segment` the motion between two times, if no spline begins or ends between them.
  void copyTo(SplineSegment& segment, int joint, double from, double to) const;
  /// [rad/s] or [m/s] The largest speed between two times.
  double largestSpeed(int joint, double from, double to) const;
  /// [rad] or [m] How far they may be off at a time, and from then on.
  double inexactAt(int joint, double time) const { return time < exact_from ? inexact_before[joint] : 0.0; }
};

/// Joints that follow splines, or may do so.
struct FollowedSplines {
  std::shared_ptr<const JointSplines> splines;
  std::vector<int> joints;  ///< indices into RobotModel::joints
  double time = 0.0;        ///< [s] the time of the splines at the stamp of the poses, with the delay that fits best
  double behind = 0.0;      ///< [s] the time of the splines is not before `time` - `behind`,
  double ahead = 0.0;       ///< [s] and not after `time` + `ahead`
  /// Followed: unless an earlier one of the same joints is. PerhapsFollowed: or else the joints keep their velocities.
  enum class Certainty : unsigned char { Followed, PerhapsFollowed } certainty = Certainty::Followed;
};

/// The motion of the joints that follow commands, from the stamp of the poses on.
struct CommandedMotion {
  std::vector<FollowedSplines> followed;  ///< by age; empty: every joint keeps its velocity
  Positions positions;                    ///< [rad] or [m] of all joints at the stamp; 0 if a position is not known
  std::vector<double> tracking_error;     ///< [rad] or [m] of all joints
};

}  // namespace proximity_server::scene
