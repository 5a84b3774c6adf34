#pragma once

#include "proximity_server/scene/model/robot_model.h"

#include <cstdint>
#include <optional>
#include <set>
#include <string>
#include <vector>

namespace proximity_server::tools {

/// A column of a table of states.
struct JointColumn {
  enum class Quantity : unsigned char { Position, Velocity, Acceleration, Time };
  std::string name;
  int joint;  ///< index into RobotModel::joints; -1 of the time
  Quantity quantity = Quantity::Position;
};

/// The end of a column's name, after the name of the joint: "", ".velocity" or ".acceleration".
const char* suffixOf(JointColumn::Quantity quantity);

/// The columns of these names. A column "time" is the time of the state, unless a joint has that name. The names of
/// velocities and accelerations are the names of their joints with a suffix, unless a joint has the whole name.
/// Failure: throws std::invalid_argument naming the column: an unknown, repeated, fixed, floating or planar joint.
std::vector<JointColumn> jointColumns(const std::vector<std::string>& names, const scene::RobotModel& robot);

/// Index of the joint, which has one position.
/// Failure: throws std::invalid_argument with the reason, without the name: an unknown, fixed, floating or planar
///          joint.
int jointWithPosition(const std::string& name, const scene::RobotModel& robot);

/// The text behind "... is not used: " in a warning about a joint that follows another one; "" if it follows none.
std::string whyNotUsed(const scene::RobotModel& robot, int joint);

/// Counts the states in which a joint is beyond its limits by more than kLimitRounding, and keeps the first of them.
/// Mimic joints, and joints without limits, do not count. Also counts states that break an inequality of the robot.
class LimitCheck {
 public:
  /// The robot must outlive this.
  explicit LimitCheck(const scene::RobotModel& robot) : robot_(robot) {}

  /// `line` is a line of a text; 0: the source has no lines.
  void beginState(std::uint64_t state, long line);
  /// `joint` is an index into RobotModel::joints; `position` [rad] or [m] is what the state sets.
  void add(int joint, double position);
  /// `positions` are the positions of all joints.
  void endState(const std::vector<double>& positions);

  /// The warning about the states of `source` in a few sentences; "" if all were within the limits. It names all joints
  /// if there are several, and says so if the positions seem to be in degrees instead of radians.
  std::string warning(const std::string& source) const;

 private:
  struct Violation {
    std::uint64_t state;
    long line;
    int joint;
    double position;
  };
  bool looksLikeDegrees() const;
  std::string limitsText(const std::string& source) const;
  std::string inequalitiesText(const std::string& source) const;

  const scene::RobotModel& robot_;
  std::uint64_t states_ = 0, states_beyond_ = 0;
  std::uint64_t state_ = 0;  ///< number of the current one
  long line_ = 0;
  bool is_beyond_ = false;  ///< whether the current state is beyond a limit
  std::optional<Violation> first_;
  std::uint64_t states_breaking_ = 0;  ///< an inequality
  std::string first_break_;
  std::set<int> joints_;  ///< that were beyond their limits
  // About all positions of revolute joints beyond their limits:
  double largest_angle_ = 0.0;  ///< [rad] absolute value
  bool would_be_within_as_degrees_ = true;
};

/// [rad] or [m] How far rounding to six decimals, as most programs write them, may put a position beyond its limit.
constexpr double kLimitRounding = 1e-6;

}  // namespace proximity_server::tools
