#pragma once

#include <istream>
#include <optional>
#include <string>
#include <vector>

#include "proximity_server/scene/model/robot_model.h"
#include "tools/command_line/limit_check.h"

namespace proximity_server::tools {

/// The most characters of one line: enough for the quoted names of as many joints as a robot may have.
constexpr std::size_t kLongestLine = std::size_t{8} << 20;

/// Reads the states of a robot from comma-separated values, one at a time: a header of joint names, then a row for each
/// state. Joints without a column are at 0. Mimic joints follow their leader: a column of a mimic joint, as recorded
/// joint states have it, is not used, and a warning says so. A column "time" is the time of the state, unless a joint
/// has that name.
///
/// Unit:    [rad] or [m], [s]. Empty lines are skipped.
/// Failure: throws std::invalid_argument naming source, line and column: no header, an unknown, repeated, fixed or
///          floating or planar joint, too few or many numbers, a text that is no finite number, a line longer than
///          kLongestLine.
class JointStates {
 public:
  /// `source` is the name of the file in messages. Reads the header. The stream and the robot must outlive this.
  JointStates(std::istream& stream, std::string source, const scene::RobotModel& robot);

  /// The next state, one position for each of RobotModel::joints; false at the end.
  bool next(std::vector<double>& positions);

  /// Whether there is a column "time", and the time [s] of the last state.
  bool hasTimes() const;
  std::optional<double> time() const { return time_; }

  const scene::RobotModel& robot() const { return robot_; }
  const std::string& source() const { return source_; }
  std::string place() const;  ///< source and line of the last state, for messages
  const std::vector<std::string>& warnings() const { return warnings_; }

  /// A warning about the states read so far that set a joint to a position beyond its limits; "" if there are none.
  std::string limitWarning() const { return limits_.warning(source_); }

 private:
  static constexpr int kTime = -1;
  struct Column {
    std::string name;
    int joint;  ///< index into RobotModel::joints, or kTime
  };

  bool nextLine(std::string& text);
  bool nextFields();
  void addColumn(const std::string& name);
  int jointOf(const std::string& name) const;
  double number(std::size_t column) const;
  [[noreturn]] void fail(const std::string& what) const;

  std::istream& stream_;
  std::string source_;
  const scene::RobotModel& robot_;
  std::vector<Column> columns_;
  std::vector<std::string> fields_;  ///< of the current line
  std::vector<std::string> warnings_;
  LimitCheck limits_;
  std::optional<double> time_;
  long line_ = 0;
};

}  // namespace proximity_server::tools
