#include "tools/program/time_budget.h"

#include "system/durations.h"
#include "tools/program/options.h"

#include <stdexcept>

namespace proximity_server::tools {

void TimeBudget::begin() {
  if (seconds) deadline = system::deadlineIn(*seconds);
}

void TimeBudget::require() const {
  if (deadline.hasPassed())
    throw std::runtime_error("the time is over: --time-budget is " + system::secondsText(seconds.value_or(0.0)));
}

void addTimeBudget(ProgramOptions& program, TimeBudget& budget, const std::string& description) {
  program.addRead("--time-budget", "SECONDS", budget.seconds, readPositive, description);
}

}  // namespace proximity_server::tools
