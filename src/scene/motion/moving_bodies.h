#pragma once

#include <map>
#include <vector>

#include "proximity_server/scene/model/kinematics.h"
#include "proximity_server/scene/motion/robot_motion.h"
#include "scene/model/bounds.h"

namespace proximity_server::scene {

/// The poses of a robot in motion, each time computed once.
class PosesInTime {
 public:
  explicit PosesInTime(const RobotMotion& motion) : motion_(motion) {}

  const BodyPoses& at(double time);

 private:
  const RobotMotion& motion_;
  std::map<double, BodyPoses> known_;
};

/// Two bodies in motion, seen from a body between them: the one in the middle of the joints that move, so that each of
/// the two moves little.
class MovingBodies {
 public:
  /// `a` and `b` bound all of the bodies that will be asked about.
  MovingBodies(const RobotMotion& motion, int body_a, const Bounds& a, int body_b, const Bounds& b);

  /// False if a pose is missing.
  bool isKnown() const { return is_known_; }

  /// The motion of a frame that is fixed to a body.
  narrowphase::MotionChain chainOfA(const Eigen::Isometry3d& a_T_frame) const { return fixedTo(chain_a_, a_T_frame); }
  narrowphase::MotionChain chainOfB(const Eigen::Isometry3d& b_T_frame) const { return fixedTo(chain_b_, b_T_frame); }

  /// The body from which they are seen; -1: the frame of the poses.
  int middle() const { return middle_; }

  /// An interval of time by bisection: the whole motion is number 1, the halves of n are 2 n and 2 n + 1.
  struct Interval {
    explicit Interval(int number);
    double begin, end;
  };

  /// A lower bound [m] of the signed distance, during an interval, of the contents of two spheres that are fixed to the
  /// bodies; and how far [m] the sphere of b moves as seen from that of a.
  struct SphereGap {
    double gap, travel;
  };
  SphereGap sphereGap(const Bounds& a, const Bounds& b, int interval, PosesInTime& poses);

  /// [m] How far any point of one body moves during an interval, seen from the other, from where it is in the middle of
  /// the interval; with the rounding of a distance.
  double driftIn(int interval, PosesInTime& poses);

  /// The same bound for their boxes: the gap in the middle of the interval, less how far any point moves from there.
  double boxGap(const Bounds& a, const Bounds& b, int interval, PosesInTime& poses);

 private:
  /// The motion of both bodies during an interval; it is the same for all of their parts.
  struct IntervalMotion {
    Eigen::Isometry3d a_begin, b_begin, a_middle, b_middle, a_end, b_end;
    double bulge;     ///< [m] how far a point of b, seen from one of a, leaves the chord from its begin to its end
    double drift;     ///< [m] how far it leaves its place in the middle of the interval
    double rounding;  ///< [m] of a distance
  };

  static narrowphase::MotionChain fixedTo(narrowphase::MotionChain chain, const Eigen::Isometry3d& pose);
  const IntervalMotion& motionIn(int interval, PosesInTime& poses);

  const int body_a_, body_b_;
  bool is_known_ = true;
  int middle_ = -1;
  narrowphase::MotionChain chain_a_, chain_b_;  ///< without those that rest; never empty
  Bounds a_, b_;
  double length_ = 0.0;                             ///< [m] of the chains, in which each pose is rounded
  std::map<int, IntervalMotion> interval_motions_;  ///< by the number of the interval
};

}  // namespace proximity_server::scene
