#pragma once

#include "proximity_server/scene/query/deadline.h"

#include <cstdint>
#include <limits>

namespace proximity_server::scene {

/// How much work guaranteed distances may take. Pairs that are not finished by then are bounded more coarsely.
struct GuaranteeLimits {
  /// Steps are counted in place of time, so that every machine gives the same answer; see stepsIn().
  std::int64_t most_steps = std::numeric_limits<std::int64_t>::max();
  Deadline deadline{};
  /// For a replay: the deadline counts as passed after so many steps.
  std::int64_t steps_to_deadline = std::numeric_limits<std::int64_t>::max();
};

/// Why bounds are coarser than they would be without limits: not at all, because the steps of a pair were over, or
/// because the deadline has passed.
enum class GuaranteeEnd : unsigned char { None, Steps, Time };

/// The number of steps that take about so many seconds of one core of 2020.
constexpr std::int64_t stepsIn(double seconds) { return static_cast<std::int64_t>(3e8 * seconds); }

}  // namespace proximity_server::scene
