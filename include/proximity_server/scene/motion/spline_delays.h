#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <vector>

namespace proximity_server::scene {

/// The state of a joint that may follow a spline, and how far it may be off.
struct MeasuredJoint {
  double position;        ///< [rad] or [m], on the turn of the spline
  double velocity;        ///< by second
  double velocity_later;  ///< [s] by so much the velocity is newer than the position
  double position_error;  ///< [rad] or [m]
  double velocity_error;  ///< by second
};

/// The delays with which joints may follow a spline: with one and the same delay each state must be within the position
/// errors. A set of cells of kStep is kept, as a filter of bounds keeps it, instead of an estimate with its noise.
///
/// 1. A cell fits a state if each joint is within its error of what the spline covers during this cell.
/// 2. The cells that fit are intersected with those that fitted all states before. If none is left, the states do not
///    agree: the set begins anew with those that fit now. If none fits now, the joints are off the spline.
/// 3. The joints agree with the spline as long as, in one and the same cell of the set, their velocities are within the
///    velocity errors, too. After kAgreement of this they count as following it. A robot that only crosses its spline
///    does not: with another velocity it leaves the cells.
/// 4. Two states farther apart than kLongestGap tell nothing of the time between them: agreement begins anew. A joint
///    that leaves the spline with an acceleration a, and is back with the same velocity after this time t, has been off
///    by up to a t^2 / 16: by 0.01 rad, the default of the parameter tracking_error, at 10 rad/s^2.
///
/// Error:  the set has no cell too few if the spline leaves the range of its values at both ends of a cell by less than
///         the position error leaves over: by (acceleration) * kStep^2 / 8, 3e-5 rad at 10 rad/s^2.
/// Source: Jaulin et al., Applied Interval Analysis, 2001, section 6.4: set-membership estimation.
class SplineDelays {
 public:
  static constexpr double kLargest = 0.1;       ///< [s]
  static constexpr double kLargestLead = 0.02;  ///< [s] of negative delays
  static constexpr double kStep = 0.005;        ///< [s]
  static constexpr int kCells = 24;             ///< from -kLargestLead to kLargest
  static constexpr double kAgreement = 0.1;     ///< [s]
  static constexpr double kLongestGap = 0.125;  ///< [s]

  /// The delay is between `least`, which is 0 or -kLargestLead, and kLargest. `agreed_since` [s]: for joints that have
  /// agreed with the motion which the spline goes on with; infinity: they have not.
  explicit SplineDelays(double least, double agreed_since = std::numeric_limits<double>::infinity());

  /// Takes the state at a time [s], not before the time of the last one. `position_at` is the position of a joint, by
  /// its index in `joints`, on the spline with a delay [s].
  void observe(double time, const std::vector<MeasuredJoint>& joints,
               const std::function<double(std::size_t joint, double delay)>& position_at);

  bool fits() const { return last_fit_ == time_; }  ///< the last state, to some delay
  double leftAt() const { return left_; }           ///< [s] if it does not fit: since this state none has fitted
  /// [s] The time of the first of those states that agree up to the last one. If the last one fits but does not agree,
  /// or comes after a gap, its own time; infinity if it does not fit.
  double agreedSince() const { return agreed_since_; }
  bool areFollowed() const { return time_ - agreed_since_ >= kAgreement; }

  double least() const;                  ///< [s] no smaller delay is possible
  double most() const;                   ///< [s] no larger one is
  double best() const { return best_; }  ///< [s] the one that fits the last state best

  int farthestJoint() const { return farthest_joint_; }  ///< that is off most with the best delay, by its error
  double farthest() const { return farthest_; }          ///< [rad] or [m] by so much it is off

 private:
  using Cells = std::uint32_t;  ///< bit i: delays from delayOf(i) to delayOf(i + 1)
  static double delayOf(int i) { return i * kStep - kLargestLead; }
  const double* samplesOf(std::size_t joint) const { return samples_.data() + joint * (kCells + 1); }
  Cells fitting(const std::vector<MeasuredJoint>& joints) const;
  Cells agreeing(const std::vector<MeasuredJoint>& joints) const;

  /// The delay of a cell that fits a state best, at a place in [0, 1].
  struct Fit {
    int cell;
    double place;
    double price;  ///< [rad^2], also for joints that slide
  };
  void findBest(const std::vector<MeasuredJoint>& joints);
  Fit bestIn(int cell, const std::vector<MeasuredJoint>& joints) const;
  double positionAt(std::size_t joint, const Fit& fit) const;

  Cells bounds_, possible_, agreed_;  // those with which the states agree since agreed_since_ are agreed_
  double time_ = std::numeric_limits<double>::quiet_NaN();  // of the last state
  double last_fit_ = -std::numeric_limits<double>::infinity(), left_ = last_fit_;
  double agreed_since_;
  double best_ = 0.0, farthest_ = 0.0;
  int farthest_joint_ = 0;
  std::vector<double> samples_;  // of each joint the positions at delayOf(0) to delayOf(kCells)
};

}  // namespace proximity_server::scene
