#include "tools/program/time_budget.h"

#include "tools/program/options.h"

#include <gtest/gtest.h>

#include <stdexcept>
#include <string>

namespace proximity_server::tools::time_budget_test {

TEST(TimeBudget, NamesItselfWhenItIsOver) {
  ProgramOptions program("tool", "what it does");
  TimeBudget budget;
  addTimeBudget(program, budget, "what happens then");
  const char* const arguments[] = {"tool", "--time-budget=1e-9"};
  EXPECT_FALSE(program.parse(2, arguments));
  budget.require();  // it has not begun
  budget.begin();
  try {
    budget.require();
    ADD_FAILURE() << "a nanosecond is not over";
  } catch (const std::runtime_error& error) {
    EXPECT_STREQ(error.what(), "the time is over: --time-budget is 1e-09 s");
  }
}

TEST(TimeBudget, IsWithoutEndByDefaultAndTakesAnyNumber) {
  TimeBudget budget;
  budget.begin();
  budget.require();
  budget.seconds = 1e300;
  budget.begin();
  budget.require();
}

}  // namespace proximity_server::tools::time_budget_test
