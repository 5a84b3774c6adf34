#include "tools/sweep/sweep_options.h"

#include <CLI/CLI.hpp>

#include <stdexcept>

namespace proximity_server::tools {
namespace {

/// An option whose text `read` turns into a value; what it throws becomes an error of the option.
template <typename Value, typename Read>
CLI::Option* addRead(CLI::App& app, const std::string& name, std::optional<Value>& value, const Read& read,
                     const std::string& description) {
  const auto store = [&value, name, read](const std::string& text) {
    try {
      value = read(text);
    } catch (const std::invalid_argument& error) {
      throw CLI::ValidationError(name, error.what());
    }
  };
  return app.add_option_function<std::string>(name, store, description);
}

}  // namespace

void declareSweepOptions(CLI::App& app, SweepOptions& options) {
  CLI::Option* shard = addRead(app, "--shard", options.shard, readShard,
                               "only the I-th of N parts of the states, into a file of the folder --out, unless it is "
                               "there already")
                           ->type_name("I/N");
  CLI::Option* range =
      addRead(app, "--range", options.range, readRange, "the same, of the states A to B - 1")->type_name("A:B");
  shard->excludes(range);
  CLI::Option* merge = app.add_option("--merge", options.merge,
                                      "join the parts in a folder to the file --out, which one run would have written")
                           ->type_name("DIR");
  CLI::Option* summary = app.add_option("--summary", options.summary,
                                        "JSON with a histogram, the worst states and the most frequent pairs")
                             ->type_name("FILE");
  for (CLI::Option* part : {shard, range}) part->excludes(merge)->excludes(summary);
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
