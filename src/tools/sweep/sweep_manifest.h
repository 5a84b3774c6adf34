#pragma once

#include "tools/sweep/state_range.h"
#include "tools/sweep/sweep_summary.h"

#include <nlohmann/json.hpp>

#include <cstdint>
#include <string>

namespace proximity_server::tools {

/// A manifest tells what a file of a sweep holds, and what made it: JSON beside the file.
struct SweepManifest {
  /// All that the answers depend on, and the meaning of the numbers in the file: program, model, question, states,
  /// output, pairs. Equal for all parts of one sweep.
  nlohmann::ordered_json sweep;

  StateRange range;
  std::uint64_t rows = 0;
  std::uint64_t bytes = 0;  ///< the size of the whole file
  std::string hash;         ///< the hash of its rows: all bytes between what OutputFormat puts before and after them
  SweepSummary summary;

  /// How many states the whole sweep has.
  std::uint64_t statesOfSweep() const { return sweep.at("states").at("count"); }

  std::string toText() const;
};

/// The manifest of a file: FILE.manifest.
std::string manifestPath(const std::string& file);

/// Throws std::invalid_argument naming the file if it cannot be read or is no manifest.
SweepManifest readManifest(const std::string& path);

/// Writes the manifest of a file, whole or not at all.
void writeManifest(const SweepManifest& manifest, const std::string& file);

/// Names the differences between two sweeps, as "model.shapes is A there and B here, ..."; "" if nothing does.
std::string differences(const nlohmann::ordered_json& there, const nlohmann::ordered_json& here);

}  // namespace proximity_server::tools
