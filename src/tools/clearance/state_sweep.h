#pragma once

#include "tools/clearance/clearance_assertion.h"
#include "tools/clearance/clearance_question.h"
#include "tools/clearance/clearance_report.h"
#include "tools/program/progress.h"
#include "tools/second_opinion/second_opinion.h"
#include "tools/states/state_source.h"
#include "tools/sweep/row_output.h"
#include "tools/sweep/state_range.h"
#include "tools/sweep/sweep_summary.h"

#include <optional>

namespace proximity_server::tools {

/// The answers go to all of these, in their order.
struct AnswerOutput {
  RowFormat format = RowFormat::Csv;
  RowOutput& rows;
  AnswerCounter& counter;
  // Those that are missing are not asked for.
  std::optional<RowOutput> plot = std::nullopt;  ///< CSV
  std::optional<ClearanceAssertion> assertion = std::nullopt;
  std::optional<SecondOpinion> second_opinion = std::nullopt;  ///< not for segments, and not where the selection is Any
  std::optional<ClearanceReport> report = std::nullopt;

  /// Passes an answer to those that read more than rows.
  void add(const ClearanceAnswer& answer);

  /// Ends all of them, so that each is a complete document.
  void end();

  /// Gives their files their names, after end() and if all states are answered.
  void complete();
};

/// Answers the question about the states of a range, and writes their rows. `states` must not have been read from. An
/// end of kToTheEnd is the end of the states.
///
/// The bytes are the same for any number of threads, and the bytes of a range are the same as within the whole; see
/// isForBatch().
/// Failure: throws the error of reading a state, after the rows of all states before it were written; and
///          std::invalid_argument if the range has an end that the states do not reach.
SweepSummary sweepStates(const ClearanceQuestion& question, StateSource& states, const StateRange& range,
                         AnswerOutput& output);

}  // namespace proximity_server::tools
