#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "proximity_server/scene/model/robot_model.h"

namespace proximity_server::tools {

/// Counts the states in which a joint is beyond its limits by more than kLimitRounding, and keeps the first of them.
/// Mimic joints, and joints without limits, do not count.
class LimitCheck {
 public:
  /// The robot must outlive this.
  explicit LimitCheck(const scene::RobotModel& robot) : robot_(robot) {}

  /// `line` is that of a text; 0: the source has no lines.
  void beginState(std::uint64_t state, long line);
  /// `joint` is an index into RobotModel::joints; `position` [rad] or [m] is what the state sets.
  void add(int joint, double position);

  /// The warning about the states of `source` in one or two sentences; "" if all were within the limits. It says so if
  /// the positions seem to be in degrees instead of radians.
  std::string warning(const std::string& source) const;

 private:
  struct Violation {
    std::uint64_t state;
    long line;
    int joint;
    double position;
  };
  bool looksLikeDegrees() const;

  const scene::RobotModel& robot_;
  std::uint64_t states_ = 0, states_beyond_ = 0;
  std::uint64_t state_ = 0;  ///< number of the current one
  long line_ = 0;
  bool is_beyond_ = false;  ///< whether the current state is beyond a limit
  std::optional<Violation> first_;
  // About all positions of revolute joints beyond their limits:
  double largest_angle_ = 0.0;  ///< [rad] absolute value
  bool would_be_within_as_degrees_ = true;
};

/// [rad] or [m] How far rounding to six decimals, as most programs write them, may put a position beyond its limit.
constexpr double kLimitRounding = 1e-6;

}  // namespace proximity_server::tools
