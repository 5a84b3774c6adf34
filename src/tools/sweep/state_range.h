#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <string>

namespace proximity_server::tools {

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

/// "3/8" with a number from 1 to 8, and "1000:2000". Throw std::invalid_argument naming the text.
ShardNumber readShard(const std::string& text);
StateRange readRange(const std::string& text);

/// The states of one shard. The ranges of all shards lie end to end, from 0 to `count`.
StateRange rangeOf(const ShardNumber& shard, std::uint64_t count);

/// "1000:2000", which readRange() understands.
std::string textOf(const StateRange& range);

}  // namespace proximity_server::tools
