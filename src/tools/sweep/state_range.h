#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <utility>

namespace proximity_server::tools {

class ProgramOptions;

/// The end of a range that has all states to their end.
constexpr std::uint64_t kToTheEnd = std::numeric_limits<std::uint64_t>::max();

/// The states begin to end - 1, counted from 0.
struct StateRange {
  std::uint64_t begin = 0, end = 0;

  std::uint64_t size() const { return end - begin; }
  bool operator==(const StateRange& other) const { return begin == other.begin && end == other.end; }
};

/// One of several parts of equal size, up to one state.
struct ShardNumber {
  std::uint64_t number = 1, of = 1;
};

/// The two whole numbers on either side of a sign; nullopt if the text is anything else.
std::optional<std::pair<std::uint64_t, std::uint64_t>> twoNumbers(const std::string& text, char between);

/// "3/8" with a number from 1 to 8, and "1000:2000". Throw std::invalid_argument naming the text.
ShardNumber readShard(const std::string& text);
StateRange readRange(const std::string& text);

/// The states of one shard. The ranges of all shards lie end to end, from 0 to `count`.
StateRange rangeOf(const ShardNumber& shard, std::uint64_t count);

/// "1000:2000", which readRange() understands.
std::string textOf(const StateRange& range);

/// The options of a sweep and its parts.
struct SweepOptions {
  std::optional<ShardNumber> shard;
  std::optional<StateRange> range;
  std::string summary;  ///< file; "": none
  std::string merge;    ///< folder; "": nothing is merged

  bool isPart() const { return shard || range; }
};

void declareSweepOptions(ProgramOptions& program, SweepOptions& options);

/// The states that a part has. `source` names them in messages.
/// Failure: throws std::invalid_argument if there are no states, fewer than the range wants, or if their number is not
///          known.
StateRange rangeOf(const SweepOptions& options, const std::optional<std::uint64_t>& count, const std::string& source);

}  // namespace proximity_server::tools
