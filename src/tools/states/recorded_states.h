#pragma once

#include "tools/states/state_source.h"

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace proximity_server::tools {

/// Messages of joint states, each about some of the joints of a robot, as one or several publishers send them.
class JointRecording {
 public:
  /// The robot must outlive this.
  explicit JointRecording(const scene::RobotModel& robot) : robot_(robot) {}

  /// Adds a message of a time [s]. Joints that the robot does not have, and such without one position of their own, are
  /// left out. So is a message without positions, which is about velocities or efforts.
  /// Failure: throws std::invalid_argument without a place: not as many positions as names, a joint named twice, a
  ///          position that is not finite.
  void add(double time, const std::vector<std::string>& names, const std::vector<double>& positions);

 private:
  friend class RecordedStates;
  struct Position {
    int joint;
    double value;
  };
  struct Message {
    double time;
    std::size_t begin, end;  ///< the range of its positions
  };
  static constexpr int kNotUsed = -1;
  int jointOf(const std::string& name);

  const scene::RobotModel& robot_;
  std::map<std::string, int> joints_;  ///< the joints of the names seen so far; kNotUsed
  std::vector<std::string> left_out_;  ///< a sentence about each joint that is not used
  std::vector<Message> messages_;      ///< with positions of used joints
  std::vector<Position> positions_;
};

/// The states that the messages of a recording tell of. Messages count in the order of their times; messages of one
/// time make one state. A joint that a message does not name keeps its last position. The first state is the one in
/// which all joints that the recording names are known; joints that it never names are at 0. The states are held in
/// memory.
class RecordedStates : public StateSource {
 public:
  /// With a rate [Hz] the states are those at the time of the first one and every 1 / rate seconds after it, up to that
  /// of the last message; each is the last that was known then.
  /// Failure: throws std::invalid_argument naming the source if there is no state.
  RecordedStates(std::string source, const JointRecording& recording, std::optional<double> rate);

  std::optional<std::uint64_t> count() const override { return rate_ ? ticks_ : times_.size(); }
  std::string identity() const override;
  std::string place() const override;

 protected:
  std::optional<const double*> fetch() override;

 private:
  void addStates(const JointRecording& recording);
  void countTicks();
  double tick(std::uint64_t number) const;

  std::optional<double> rate_;
  std::vector<double> times_;     ///< [s] of the states of the messages, strictly increasing
  std::vector<double> states_;    ///< state by state the time, then the joints that the recording names
  std::uint64_t ticks_ = 0;       ///< states at the rate
  const double* last_ = nullptr;  ///< the numbers of the last state, its time first
};

/// The limits of a rate [Hz]; beyond them the times of a recording cannot tell states apart.
constexpr double kLowestRate = 1e-6, kHighestRate = 1e6;

}  // namespace proximity_server::tools
