#pragma once

#include "tools/states/state_source.h"

#include <cstdint>
#include <string>
#include <vector>

namespace proximity_server::tools {

/// The axis of one --grid: of one joint, or of all joints if it has no name.
struct GridAxis {
  std::string joint;
  double lower = 0.0, upper = 0.0;  ///< [rad] or [m]; not of all joints
  std::uint64_t count = 0;
  bool is_in_degrees = false;  ///< as text, which is for a joint that turns only
};

/// Reads JOINT=LOWER:UPPER:COUNT, JOINT=POSITION or COUNT; positions may be angles like 90deg. Throws std::invalid_argument naming the text.
GridAxis readGridAxis(const std::string& text);

/// A regular grid of joint space. The axes are those named, in the order in which they are named, or all joints in the
/// order of RobotModel::joints; other joints are at 0. The last axis runs fastest, as in nested loops: with the counts
/// n0, n1, n2, state (i0 * n1 + i1) * n2 + i2 has position i0 of the first axis.
///
/// A named axis has positions from its lower to its upper end, both included. All joints have the ranges of
/// scene::jointRanges, both ends included; but if the range is a full turn, its upper end is left out, as it is the
/// lower one again.
class GridStates : public StateSource {
 public:
  /// Failure: throws std::invalid_argument naming the axis: a joint without one position of its own, one that is named
  ///          twice, a named joint beside all joints, no joint, too many states for a signed number of 64 bits.
  GridStates(const std::vector<GridAxis>& axes, const scene::RobotModel& robot);

  std::optional<std::uint64_t> count() const override { return count_; }
  std::string identity() const override;

 protected:
  std::optional<const double*> fetch() override;

 private:
  struct Axis {
    double lower, upper;
    std::uint64_t count, intervals;  ///< positions, and intervals from lower to upper
    std::uint64_t index = 0;         ///< the index of the position

    double position() const;
  };
  void addNamed(const GridAxis& axis);
  void addAll(std::uint64_t count);
  void add(int joint, const Axis& axis);
  void countStates();

  std::vector<Axis> axes_;  ///< one for each column
  std::uint64_t count_ = 1;
  std::uint64_t at_ = 0;  ///< the state in which the axes are
  std::vector<double> numbers_;
};

}  // namespace proximity_server::tools
