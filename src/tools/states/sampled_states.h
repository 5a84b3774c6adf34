#pragma once

#include "tools/states/state_source.h"

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace proximity_server::tools {

/// Two numbers, uniform in [0, 1), which depend on the arguments alone: multiples of 2^-53, the top 53 of 64 random
/// bits.
///
/// Source: Philox4x32-10 of Salmon, Moraes, Dror, Shaw, Parallel Random Numbers: As Easy as 1, 2, 3, SC 2011. Key: the
///         seed. Counter: the state (two words), the draw, the attempt; lower words first. Each number takes two words
///         of the answer, the lower one first.
std::array<double, 2> uniformNumbers(std::uint64_t seed, std::uint64_t state, std::uint32_t draw,
                                     std::uint32_t attempt = 0);

/// Random states, each joint uniform in its range (see scene::jointRanges) and independent of all others. State i is
/// the same wherever it is computed, and however many there are: the joint of range r is at lower + u * (upper - lower)
/// with number r % 2 of uniformNumbers(seed, i, r / 2). That is attempt 0; if it breaks an inequality of the robot the
/// next attempts follow, until one breaks none, see scene::drawWithin().
class SampledStates : public StateSource {
 public:
  /// Failure: throws std::invalid_argument for a joint whose range has no finite width.
  SampledStates(std::uint64_t count, std::uint64_t seed, const scene::RobotModel& robot);

  bool next(scene::TrajectoryPoint& state) override;
  std::optional<std::uint64_t> count() const override { return count_; }
  std::string identity() const override;

 private:
  void draw(std::uint32_t attempt, scene::Positions& positions) const;

  std::uint64_t count_, seed_;
  std::vector<scene::JointRange> ranges_;
};

/// The sentences about joints without limits, whose ranges are a guess.
std::vector<std::string> guessedRanges(const scene::RobotModel& robot, const std::vector<scene::JointRange>& ranges);

}  // namespace proximity_server::tools
