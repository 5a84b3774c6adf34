#pragma once

#include <optional>
#include <string>

#include "tools/sweep/state_range.h"

namespace CLI {
class App;
}

namespace proximity_server::tools {

/// What the command line says of a sweep and its parts.
struct SweepOptions {
  std::optional<ShardNumber> shard;
  std::optional<StateRange> range;
  std::string summary;  ///< file; "": none
  std::string merge;    ///< folder; "": nothing is merged

  bool isPart() const { return shard || range; }
};

void declareSweepOptions(CLI::App& app, SweepOptions& options);

/// The states that a part has. `source` names them in messages.
/// Failure: throws std::invalid_argument if there are no states, fewer than the range wants, or if their number is not known.
StateRange rangeOf(const SweepOptions& options, const std::optional<std::uint64_t>& count, const std::string& source);

}  // namespace proximity_server::tools
