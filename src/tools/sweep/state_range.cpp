#include "tools/sweep/state_range.h"

#include "tools/program/options.h"
#include "tools/text/csv.h"

#include <stdexcept>

namespace proximity_server::tools {

std::optional<std::pair<std::uint64_t, std::uint64_t>> twoNumbers(const std::string& text, char between) {
  const std::size_t middle = text.find(between);
  if (middle == std::string::npos) return std::nullopt;
  const auto first = numberIn<std::uint64_t>(text.substr(0, middle));
  const auto second = numberIn<std::uint64_t>(text.substr(middle + 1));
  return first && second ? std::optional(std::pair(*first, *second)) : std::nullopt;
}

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

void declareSweepOptions(ProgramOptions& program, SweepOptions& options) {
  program.addRead(
      "--shard", "I/N", options.shard, readShard,
      "only the I-th of N parts of the states, into a file of the folder --out, unless it is there already");
  program.addRead("--range", "A:B", options.range, readRange, "the same, of the states A to B - 1");
  program.addText("--merge", "DIR", options.merge,
                  "join the parts in a folder to the file --out, which one run would have written");
  program.addOutput("--summary", "FILE", options.summary,
                    "JSON with a histogram, the worst states and the most frequent pairs");
  program.atMostOneOf({"--shard", "--range", "--merge"});
  program.atMostOneOf({"--shard", "--range", "--summary"});
}

StateRange rangeOf(const SweepOptions& options, const std::optional<std::uint64_t>& count, const std::string& source) {
  if (!count) throw std::invalid_argument(source + ": a stream has no parts; give --shard and --range a file");
  if (*count == 0) throw std::invalid_argument(source + ": no state");
  if (!options.range) return rangeOf(*options.shard, *count);
  if (options.range->end > *count)
    throw std::invalid_argument("--range " + textOf(*options.range) + ": " + source +
                                " has the states 0:" + std::to_string(*count));
  return *options.range;
}

}  // namespace proximity_server::tools
