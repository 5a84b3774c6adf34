#pragma once

#include "proximity_server/scene/model/joint_ranges.h"
#include "proximity_server/scene/model/robot_model.h"
#include "tools/states/joint_columns.h"

#include <Eigen/Core>

#include <cstdint>
#include <exception>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace proximity_server::tools {

/// States of a robot, numbered from 0: from a file, from a recorded bag, or made. Joints that a source does not name
/// are at 0, and mimic joints follow their leader: what a source says of them is not used, and a warning says so.
///
/// Unit:    [rad] or [m], [s].
/// Failure: next(), read() and skipTo() throw std::invalid_argument naming source, place and column.
class StateSource {
 public:
  virtual ~StateSource() = default;
  StateSource(const StateSource&) = delete;
  StateSource& operator=(const StateSource&) = delete;

  /// The next state, one position for each of RobotModel::joints; false at the end.
  virtual bool next(scene::Positions& positions);

  /// The next states, as many as the block has rows, from its first row on; one column for each of RobotModel::joints.
  /// Returns how many there are: fewer only at the end, or before a state that is wrong, of which the next call throws.
  /// `each` gets every state as soon as it is read; if it throws std::invalid_argument the state is wrong.
  int read(Eigen::Ref<Eigen::MatrixXd> block, const std::function<void(const scene::Positions&)>& each = nullptr);

  /// next() then returns the state of this number, or false if there are not so many. Forward only. Takes a constant
  /// time, except that CSV is read on.
  virtual void skipTo(std::uint64_t state) { state_ = state; }

  /// How many states there are; nullopt if that is known at the end only, as of a stream. It may read the whole file.
  virtual std::optional<std::uint64_t> count() const = 0;

  /// A text for manifests, which is equal only if the states are the same. It has a hash of the whole content of a
  /// file, which it reads. "" for a stream, which can be read only once.
  virtual std::string identity() const = 0;

  /// Whether the states have times, and the time [s] of the last state.
  bool hasTimes() const;
  std::optional<double> time() const { return time_; }

  /// Whether there is a column of this quantity, of one joint or of any. The velocities and accelerations of the last
  /// state, by second and second squared, are 0 for joints without such a column.
  bool hasColumn(JointColumn::Quantity quantity, std::optional<int> joint = std::nullopt) const;
  const scene::Positions& velocities() const { return velocities_; }
  const scene::Positions& accelerations() const { return accelerations_; }

  const scene::RobotModel& robot() const { return robot_; }
  const std::string& source() const { return source_; }  ///< the name of the file, or what it is, for messages
  virtual std::string place() const;  ///< the source and the place of the last state in it, for messages
  /// The warnings that are known before the first state.
  const std::vector<std::string>& warnings() const { return warnings_; }

  /// A warning about the states read so far that set a joint to a position beyond its limits, or that break an
  /// inequality of the robot; "" if there are none.
  std::string limitWarning() const { return limits_.warning(source_); }

 protected:
  /// The robot must outlive this.
  StateSource(std::string source, const scene::RobotModel& robot)
      : source_(std::move(source)), robot_(robot), limits_(robot) {}

  /// Takes the columns of these names, and warns of those that are not used.
  /// Failure: throws std::invalid_argument as jointColumns().
  void setColumns(const std::vector<std::string>& names);

  /// Finds the numbers of the state state(), one for each column; false at the end. They may be not finite, which
  /// next() refuses.
  virtual bool fetch(const double*& /*numbers*/) { return false; }

  /// The text of a number that fetch() has found, for messages.
  virtual std::string textOf(std::size_t column, double number) const;

  /// Throws std::invalid_argument that begins with place().
  [[noreturn]] void fail(const std::string& what) const;
  void warn(const std::string& sentence) { warnings_.push_back(source_ + ": " + sentence); }

  std::uint64_t state() const { return state_; }  ///< the number of the next one
  void passState() { ++state_; }

  std::vector<JointColumn> columns_;
  long line_ = 0;  ///< the line of the last state in a text; 0: the source has no lines

 private:
  std::string source_;
  const scene::RobotModel& robot_;
  std::vector<std::string> warnings_;
  LimitCheck limits_;
  std::uint64_t state_ = 0;
  std::optional<double> time_;
  scene::Positions velocities_, accelerations_;
  scene::Positions row_;      ///< scratch of read()
  std::exception_ptr error_;  ///< that of the state that ended the last block
};

}  // namespace proximity_server::tools
