#pragma once

#include <functional>
#include <string>
#include <vector>

#include "tools/clearance/clearance_run.h"
#include "tools/clearance/state_rows.h"
#include "tools/states/state_source.h"
#include "tools/sweep/state_range.h"
#include "tools/sweep/sweep_summary.h"

namespace proximity_server::tools {

/// Where the answers about states go. Each function is called by one thread at a time, with states in their order.
struct SweepOutput {
  const StateRows& rows;
  std::function<void(const WrittenRows&)> write;
  std::function<void(std::uint64_t states)> count;

  const StateRows* plot_rows = nullptr;  ///< nullptr: there is no plot
  std::function<void(const WrittenRows&)> plot = nullptr;

  /// Gets each answer if StateQuestion::smallest is Always; may be missing.
  std::function<void(const StateClearance&)> judge = nullptr;

  /// Gets each answer with the pairs that are listed, and without StateClearance::smallest; may be missing. Not for Any.
  std::function<void(const StateClearance&)> listed = nullptr;
};

/// Answers the question about the states of a range, and writes their rows. `states` must not have been read from.
///
/// The candidates of the filter without objects are answered by SceneBatch: what is written of a state then depends on it
/// alone. Otherwise as answerStates(). In both cases the bytes are the same for any number of threads, and those of a range
/// are the same as within the whole.
/// Failure: throws the error of reading a state, after the rows of all states before it were written; and
///          std::invalid_argument if the range has an end that the states do not reach.
SweepSummary sweepStates(const ClearanceQuestion& question, const StateQuestion& state_question, StateSource& states,
                         const StateRange& range, const SweepOutput& output);

}  // namespace proximity_server::tools
