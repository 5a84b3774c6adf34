#pragma once

#include "proximity_server/scene/query/deadline.h"

#include <optional>
#include <string>

namespace proximity_server::tools {

class ProgramOptions;

/// The option --time-budget: how long a tool may search.
struct TimeBudget {
  std::optional<double> seconds;  ///< as given
  scene::Deadline deadline;

  /// The time begins to count.
  void begin();

  /// Throws std::runtime_error naming the option if the time is over.
  void require() const;
};

/// Declares --time-budget. `description` is what happens when the time is over.
void addTimeBudget(ProgramOptions& program, TimeBudget& budget, const std::string& description);

}  // namespace proximity_server::tools
