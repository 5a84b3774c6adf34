#include "tools/sweep/state_range.h"

#include <charconv>
#include <stdexcept>

namespace proximity_server::tools {
namespace {

/// The two whole numbers on either side of a sign; nullopt if the text is anything else.
std::optional<std::pair<std::uint64_t, std::uint64_t>> twoNumbers(const std::string& text, char between) {
  std::uint64_t first = 0, second = 0;
  const char* end = text.data() + text.size();
  const auto [middle, error] = std::from_chars(text.data(), end, first);
  if (error != std::errc() || middle == end || *middle != between) return std::nullopt;
  const auto [stop, second_error] = std::from_chars(middle + 1, end, second);
  if (second_error != std::errc() || stop != end) return std::nullopt;
  return std::pair{first, second};
}

}  // namespace

ShardNumber readShard(const std::string& text) {
  const auto numbers = twoNumbers(text, '/');
  if (!numbers) throw std::invalid_argument("'" + text + "' is not of the form I/N, as 3/8");
  const auto [number, of] = *numbers;
  if (number < 1 || number > of)
    throw std::invalid_argument("'" + text + "': shards are numbered from 1 to N, here from 1 to " +
                                std::to_string(of));
  return {number, of};
}

StateRange readRange(const std::string& text) {
  const auto numbers = twoNumbers(text, ':');
  if (!numbers) throw std::invalid_argument("'" + text + "' is not of the form A:B, as 0:1000");
  if (numbers->first >= numbers->second)
    throw std::invalid_argument("'" + text + "' has no state: A:B are the states A to B - 1");
  return {numbers->first, numbers->second};
}

StateRange rangeOf(const ShardNumber& shard, std::uint64_t count) {
  // count * k / of without overflow: of the quotient and of the remainder.
  const std::uint64_t quotient = count / shard.of, remainder = count % shard.of;
  const auto border = [&](std::uint64_t k) {
    // remainder, k and of are below 2^64; the product of the first two may not be.
    __extension__ using Wide = unsigned __int128;
    return quotient * k + static_cast<std::uint64_t>(static_cast<Wide>(remainder) * k / shard.of);
  };
  return {border(shard.number - 1), border(shard.number)};
}

std::string textOf(const StateRange& range) { return std::to_string(range.begin) + ":" + std::to_string(range.end); }

}  // namespace proximity_server::tools
