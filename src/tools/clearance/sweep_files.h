#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>

#include "tools/clearance/clearance_run.h"
#include "tools/clearance/state_rows.h"
#include "tools/command_line/answer_counter.h"
#include "tools/states/state_source.h"
#include "tools/sweep/sweep_options.h"
#include "tools/sweep/sweep_summary.h"

namespace proximity_server::tools {

/// The question of a sweep, and how its answers are written.
struct Sweep {
  const ClearanceQuestion& question;
  StateQuestion state_question;
  RowFormat format = RowFormat::Csv;
  std::string objects, thresholds;  ///< the files; "": none
};

/// What the answers of a sweep depend on, and the meaning of the numbers in its files; see SweepManifest::sweep.
nlohmann::ordered_json describe(const Sweep& sweep, const StateSource& states, std::uint64_t count);

/// Computes a part into the folder, unless it is there already, and says on standard error what it did.
/// Failure: throws std::invalid_argument as SweepFolder, RowFile, rangeOf() and sweepStates(); then nothing new has the
///          name of the part.
void computePart(const Sweep& sweep, const SweepOptions& options, StateSource& states, const std::string& folder);

/// Writes all rows into one .npy file, with a manifest beside it. Returns the summary.
/// Failure: throws std::invalid_argument; then the file is what it was.
SweepSummary computeNpy(const Sweep& sweep, StateSource& states, const std::string& out, AnswerCounter& counter,
                        std::uint64_t& bytes);

/// Joins the parts in the folder options.merge to a file, and writes their summary if that is asked for.
/// Failure: throws std::invalid_argument naming the part that is missing or wrong; then the file is what it was.
void mergeParts(const SweepOptions& options, const std::string& out);

/// Writes the summary into the file.
void writeSummary(const SweepSummary& summary, const std::string& file);

/// The processor time that a run takes, from its making on.
class CoreTime {
 public:
  CoreTime();
  /// "1.2e+10 states per core-hour, 24 bytes a state"
  std::string text(std::uint64_t states, std::uint64_t bytes) const;

 private:
  double begin_;  ///< [s]
};

}  // namespace proximity_server::tools
