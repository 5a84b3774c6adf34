#pragma once

#include "tools/clearance/clearance_question.h"
#include "tools/states/state_source.h"
#include "tools/sweep/output_format.h"
#include "tools/sweep/state_range.h"
#include "tools/sweep/sweep_manifest.h"

#include <nlohmann/json_fwd.hpp>

#include <cstdint>
#include <ctime>
#include <optional>
#include <string>

namespace proximity_server::tools {

/// Describes all that the answers of a sweep depend on, and the meaning of the numbers in its files; see
/// SweepManifest::sweep.
nlohmann::ordered_json describe(const ClearanceQuestion& question, RowFormat format, const StateSource& states,
                                std::uint64_t count);

/// Computes a part into the folder, unless it is there already, and says on standard error what it did.
/// Failure: throws std::invalid_argument as SweepFolder, RowOutput, rangeOf() and sweepStates(); then nothing new has
///          the name of the part.
void computePart(const ClearanceQuestion& question, RowFormat format, const SweepOptions& options, StateSource& states,
                 const std::string& folder);

/// Writes all rows into one .npy file, with a manifest beside it. Returns the manifest.
/// Failure: throws std::invalid_argument; then the file is what it was.
SweepManifest computeNpy(const ClearanceQuestion& question, StateSource& states, const std::string& out);

/// Joins the parts in the folder options.merge to a file, and writes their summary if that is asked for.
/// Failure: throws std::invalid_argument naming the part that is missing or wrong; then the file is what it was.
void mergeParts(const SweepOptions& options, const std::string& out);

/// Writes the summary into the file.
void writeSummary(const SweepSummary& summary, const std::string& file);

/// The cost of states, in the processor time since `begin`: "1.2e+10 states per core-hour, 24 bytes a state".
std::string costOf(std::uint64_t states, std::uint64_t bytes, std::clock_t begin);

/// The number of answers that are to come, if it is known without reading all states and somebody watches.
std::optional<std::uint64_t> totalOf(const StateSource& states, RowKind rows);

}  // namespace proximity_server::tools
