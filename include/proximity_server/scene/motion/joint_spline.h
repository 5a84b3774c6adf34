#pragma once

#include "proximity_server/scene/model/joint_ranges.h"
#include "proximity_server/scene/model/robot_model.h"

#include <array>
#include <optional>
#include <vector>

// The motion that joint_trajectory_controller of ros_controllers makes of the points of a trajectory.

namespace proximity_server::scene {

/// A point of a trajectory. Each list has one number for each of RobotModel::joints; mimic joints are not used.
/// Without velocities or accelerations their list is empty.
struct TrajectoryPoint {
  double time = 0.0;          ///< [s] from the start
  Positions positions;        ///< [rad] or [m]
  Positions velocities{};     ///< by second
  Positions accelerations{};  ///< by second squared
};

/// The points that the controller follows if it is in the state `start` at time 0. Points at or before this time are
/// dropped, and the start comes before all others. A continuous joint goes the shorter way to the first of them, and keeps the
/// offset of full turns from then on.
/// Failure: throws std::invalid_argument if no point is left, or for a wrong number of positions.
std::vector<TrajectoryPoint> drivenFrom(const RobotModel& robot, TrajectoryPoint start,
                                        const std::vector<TrajectoryPoint>& points);

/// The motion from one point of a trajectory to the next, over the time [0, 1]: for each joint a polynomial of degree 5,
/// 3 or 1, by the data that both points have. With positions only it is linear, with velocities a cubic, with
/// accelerations a quintic.
/// 1. Velocities and accelerations that a point lacks are taken from the polynomial of lower degree. So each is the
///    quintic through the positions, velocities and accelerations of both ends.
/// 2. In Bernstein form its six control values follow from these directly, and the control values of a part of the time
///    by de Casteljau's algorithm. On that part the polynomial stays between the smallest and the largest of them.
/// 3. The difference from the straight line between two times has control values, too: the polynomial's minus the
///    line's. The largest is a bound of how far the joint leaves the line, and falls by 4 with each halving.
///
/// Error:  kRounding times the largest control value. It covers the rounding here and in the controller, which
///         computes with powers of the time.
/// Source: Farouki, The Bernstein Polynomial Basis: A Centennial Retrospective, Computer Aided Geometric Design 29, 2012.
class SplineSegment {
 public:
  /// The sum of the controller's six terms is at most 863 times the largest control value; each of them has an error of
  /// less than 16 eps.
  static constexpr double kRounding = 0x1p-38;

  /// Failure: throws std::invalid_argument with the time and the joint for a time that is not later, a wrong number of
  ///          positions, velocities or accelerations, and numbers that are not finite or too far apart.
  SplineSegment(const RobotModel& robot, const TrajectoryPoint& from, const TrajectoryPoint& to);

  /// Without joints; for rest().
  SplineSegment() = default;

  double begin() const { return begin_; }  ///< [s]
  double end() const { return end_; }      ///< [s]
  /// [s] That of a place in [0, 1]; at 1 the end to the last bit.
  double timeAt(double place) const { return place < 1.0 ? begin_ + place * (end_ - begin_) : end_; }
  double placeAt(double time) const { return (time - begin_) / (end_ - begin_); }

  Positions at(double time) const;
  void at(double time, Positions& positions) const;

  /// That of one joint.
  double positionAt(int joint, double time) const { return valueAt(joints_[joint], time); }

  /// [rad/s] or [m/s] A joint is nowhere faster: a polynomial is not steeper than its control values.
  double largestSpeed(int joint) const;

  /// Positions, velocities and accelerations, with the time in seconds.
  TrajectoryPoint stateAt(double time) const;

  // To make a segment anew in its memory, joint by joint.
  /// All joints rest, from one time [s] to another.
  void rest(double begin, double end, const Positions& positions);
  void goStraight(int joint, double from, double to);
  /// Takes the motion of a joint from a part of another segment, which is between two places on it.
  void copy(int joint, const SplineSegment& other, double from, double to);

  /// The motion between two times, over a time [0, 1] of its own.
  SplineSegment between(double from, double to) const;

  /// A straight line from the positions at one time to those at a later time, and how far each joint leaves it.
  struct Chord {
    Positions from, to;
    std::vector<double> deviation;  ///< [rad] or [m]
  };
  void chord(double from, double to, Chord& chord) const;

  /// A joint beyond a limit, where it is farthest beyond.
  struct Excess {
    int joint;
    double time;             ///< in [0, 1]
    double position, limit;  ///< [rad] or [m]
  };
  /// The joints that leave their limits by more than 1e-9 rad or m. Mimic joints have no limits of their own.
  std::vector<Excess> beyondLimits(const RobotModel& robot) const;

  /// An inequality that is broken, where it is broken most.
  struct Break {
    const JointInequality* inequality;
    double time;  ///< in [0, 1]
    double excess;
  };
  /// The broken inequalities of the robot. The sum of an inequality is a polynomial too, whose control values are the
  /// sums of the control values of its joints. `resting` are positions that joints have instead of the segment's, or it
  /// is empty; with one that is NaN, an inequality is not broken.
  std::vector<Break> brokenInequalities(const RobotModel& robot,
                                        const std::vector<std::optional<double>>& resting = {}) const;

 private:
  using ControlValues = std::array<double, 6>;
  static ControlValues part(const ControlValues& whole, double from, double to);
  static double valueAt(const ControlValues& values, double time);
  static double timeOfHighest(const ControlValues& values);

  double begin_ = 0.0, end_ = 1.0;
  std::vector<ControlValues> joints_;
};

}  // namespace proximity_server::scene
