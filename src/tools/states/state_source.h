#pragma once

#include "proximity_server/scene/model/robot_model.h"
#include "proximity_server/scene/motion/joint_spline.h"
#include "tools/states/joint_columns.h"

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace proximity_server::tools {

/// The name, the columns and the warnings of a source.
struct StateHeader {
  std::string source;              ///< the name of the file, or what it is, for messages
  const scene::RobotModel& robot;  ///< must outlive the source
  std::vector<JointColumn> columns{};
  std::vector<std::string> warnings{};

  /// Takes the columns of these names, and warns of those that are not used.
  /// Failure: throws std::invalid_argument as jointColumns().
  void setColumns(const std::vector<std::string>& names);
  void warn(const std::string& sentence) { warnings.push_back(source + ": " + sentence); }

  /// Whether there is a column of this quantity, of one joint or of any.
  bool has(JointColumn::Quantity quantity, std::optional<int> joint = std::nullopt) const;
};

/// States of a robot, numbered from 0: from a file, from a recorded bag, or made. Joints that a source does not name
/// are at 0, and mimic joints follow their leader: what a source says of them is not used, and a warning says so.
///
/// Unit:    [rad] or [m], [s].
/// Failure: next() and skipTo() throw std::invalid_argument naming source, place and column.
class StateSource {
 public:
  virtual ~StateSource() = default;
  StateSource(const StateSource&) = delete;
  StateSource& operator=(const StateSource&) = delete;

  const StateHeader& header() const { return header_; }

  /// The next state; false at the end. Its time is NaN without such a column. Velocities and accelerations are 0 for
  /// joints without such a column, and their lists are empty if no joint has one.
  virtual bool next(scene::TrajectoryPoint& state);

  /// next() then returns the state of this number, or false if there are not so many. Forward only. Takes a constant
  /// time, except that CSV is read on.
  virtual void skipTo(std::uint64_t state) { state_ = state; }

  virtual std::string place() const;  ///< the source and the place of the last state in it, for messages

  /// A warning about the states read so far that set a joint to a position beyond its limits, or that break an
  /// inequality of the robot; "" if there are none.
  std::string limitWarning() const { return limits_.warning(header_.source); }

  /// How many states there are; nullopt if that is known at the end only, as of a stream. It may read the whole file.
  virtual std::optional<std::uint64_t> count() const = 0;

  /// A text for manifests, which is equal only if the states are the same. It has a hash of the whole content of a
  /// file, which it reads. "" for a stream, which can be read only once.
  virtual std::string identity() const = 0;

 protected:
  StateSource(std::string source, const scene::RobotModel& robot) : header_{std::move(source), robot}, limits_(robot) {}

  /// Finds the numbers of the state state(), one for each column, of which there may be none; nullopt at the end. They
  /// may be not finite, which next() refuses.
  virtual std::optional<const double*> fetch() { return std::nullopt; }

  /// The text of a number that fetch() has found, for messages.
  virtual std::string textOf(std::size_t column, double number) const;

  /// Throws std::invalid_argument that begins with place().
  [[noreturn]] void fail(const std::string& what) const;

  /// Makes it a state of which no column says anything.
  void clear(scene::TrajectoryPoint& state) const;

  std::uint64_t state() const { return state_; }  ///< the number of the next one
  void passState() { ++state_; }

  StateHeader header_;
  long line_ = 0;  ///< the line of the last state in a text; 0: the source has no lines

 private:
  LimitCheck limits_;
  std::uint64_t state_ = 0;
};

}  // namespace proximity_server::tools
