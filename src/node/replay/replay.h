#pragma once

#include "node/monitor/monitor.h"
#include "node/record/record_messages.h"

#include <cstdint>
#include <memory>
#include <optional>
#include <ostream>
#include <string>
#include <vector>

namespace proximity_server::node {

/// [m] Bounds overlap within this: poses lose bits where they become messages.
constexpr double kRoundingOfMessages = 1e-9;

struct ReplayOptions {
  std::string file;
  std::optional<double> mesh_tolerance;  ///< [m] in place of the record's
};

/// The answers of a replay, compared with the record.
struct ReplayResult {
  std::uint64_t cycles = 0, different = 0;
  std::vector<std::string> first_differences;  ///< a line for each of the first ten
  std::uint64_t coarse = 0;                    ///< cycles of the record whose guaranteed distances ended at a limit
  std::vector<std::string> first_coarse;       ///< a line for each of the first ten
  std::vector<std::string> reasons;            ///< what is not as it was: the version, the mesh tolerance, ...
  bool agrees() const { return different == 0; }
};

/// Gives the states of a record to a Monitor again, as the node did. Meshes are read from where they are now.
///
/// `rows` gets CSV with a line for each cycle: its stamp, the level now and in the record, the pair that sets the
/// level, and the bounds of the closest pair, now and in the record. Two replays write the same bytes.
/// Failure: throws std::invalid_argument naming the file: no bag, no record, or a model that cannot be loaded.
ReplayResult replay(const ReplayOptions& options, std::ostream& rows);

/// Tells whether the event of a record was contact, or how much of it is the envelope around the surfaces of the
/// model: uncertainty, padding, and the pieces that replace meshes, each in millimetres.
/// Failure: as replay(); also if no pair set the level before the event.
std::string explainEvent(const ReplayOptions& options);

}  // namespace proximity_server::node
