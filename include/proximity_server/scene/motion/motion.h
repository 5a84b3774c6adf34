#pragma once

#include "proximity_server/scene/model/joint_ranges.h"
#include "proximity_server/scene/model/kinematics.h"
#include "proximity_server/scene/motion/joint_spline.h"
#include "proximity_server/scene/motion/robot_motion.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <optional>
#include <vector>

namespace proximity_server::scene {

/// A motion of a robot and of the frames that carry its objects, in pieces that follow each other. Its parameter goes
/// from 0 to 1 and stands for an interval of time. The model of a motion along a spline must outlive it.
class Motion {
 public:
  /// A part of the motion: straight, or along a spline of the joints, or anywhere in a tube around the spline.
  struct Piece {
    double begin = 0.0, end = 1.0;  ///< parameters of the motion
    /// Straight: the motion over this piece, in a time [0, 1] of its own. Along a spline: at rest at the positions
    /// `from`, and so are the frames of objects in their parents; a joint whose position changes moves from there by
    /// the difference, all others may stand anywhere.
    RobotMotion robot;
    Positions from{}, to{};                 ///< of a straight piece, if they are known
    std::optional<SplineSegment> spline{};  ///< over the time [0, 1] of this piece
    /// Along a spline, per joint [rad] or [m]: how far the robot may be off it at any time; mimic joints follow. Empty:
    /// nowhere.
    std::vector<double> tracking_error{};

    /// The positions at a time in [0, 1] of this piece; empty: not known.
    Positions positionsAt(double time) const;

    /// Along a spline: the robot at rest in a state.
    RobotMotion restAt(const Positions& state) const;

    /// Maps a time [0, 1] of this piece to the parameter of the whole motion.
    double onWhole(double time) const { return time < 1.0 ? std::min(end, begin + time * (end - begin)) : end; }
  };

  /// A straight motion.
  Motion(RobotMotion motion);  // NOLINT(google-explicit-constructor): the same motion

  /// Throws std::invalid_argument if there is no piece, or if their parameters leave a gap.
  explicit Motion(std::vector<Piece> pieces);

  /// The motion from one point of a trajectory to the next, at the times of these points, see SplineSegment. It is
  /// straight if the points have no velocities and there is no tracking error. `start` are the poses at the first point.
  /// Failure: throws std::invalid_argument as SplineSegment and RobotMotion::ofTravel do.
  Motion(const RobotModel& model, const BodyPoses& start, const TrajectoryPoint& from, const TrajectoryPoint& to,
         const std::vector<double>& tracking_error = {});

  /// Takes the poses at the first point from forwardKinematics().
  Motion(const RobotModel& model, const TrajectoryPoint& from, const TrajectoryPoint& to,
         const std::vector<double>& tracking_error = {});

  /// The motion along a spline, with the poses of forwardKinematics().
  Motion(const RobotModel& model, SplineSegment spline, std::vector<double> tracking_error = {});

  const std::vector<Piece>& pieces() const { return pieces_; }

  /// The first piece, to be made anew in its memory. It is the only one of a motion that stands for one piece at a time,
  /// whose parameters then need not be 0 and 1.
  Piece& onlyPiece() { return pieces_.front(); }

  /// Sets the interval of time [s] for which the parameter stands; at first it is from 0 to 1.
  void setTime(double begin, double end);
  /// [s] Rounded, but never outside of the interval.
  double timeAt(double parameter) const;

  /// The poses at one parameter; in a piece along a spline those at the positions `state`, or, if it is empty, on the
  /// spline.
  BodyPoses at(double parameter, const Positions& state = {}) const;

  /// See RobotMotion::inWorld() and worldAt().
  RobotMotion::State inWorld(double parameter) const;
  std::optional<Eigen::Isometry3d> worldAt(double parameter, const BodyPoses& bodies) const;

  /// Splits the motion of the frames that carry objects, which is over the whole motion, into the pieces. Throws as
  /// RobotMotion::carryObjects does.
  void carryObjects(const RobotMotion::ObjectFrames& frames);

 private:
  /// A piece, and a time in it.
  struct Place {
    const Piece& piece;
    double time;
  };
  Place placeOf(double parameter) const;

  std::vector<Piece> pieces_;
  double begin_ = 0.0, end_ = 1.0;
};

}  // namespace proximity_server::scene
