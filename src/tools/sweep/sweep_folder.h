#pragma once

#include "tools/sweep/output_format.h"
#include "tools/sweep/sweep_manifest.h"

#include <string>
#include <vector>

namespace proximity_server::tools {

/// A folder of parts of one sweep: for each range of states a file, and its manifest once the file is complete.
class SweepFolder {
 public:
  /// Makes the folder if it is not there. Throws std::invalid_argument naming it if that fails, or if it is a file.
  explicit SweepFolder(std::string path);

  /// The file of a range.
  std::string file(const StateRange& range, RowFormat format) const;

  /// Whether the part of this sweep and range is complete, so that nothing is left to do. Removes what killed processes
  /// left of it.
  /// Failure: throws std::invalid_argument naming the manifest and what differs if the folder has parts of another
  ///          sweep, or other parts with some of the states.
  bool isDone(const nlohmann::ordered_json& sweep, const StateRange& range, RowFormat format) const;

 private:
  std::string path_;
};

/// The paths of the manifests of all parts in a folder, in the order of their names.
std::vector<std::string> manifestsIn(const std::string& folder);

/// The complete parts of one sweep, in their order and end to end from its first state to its last.
struct CompleteSweep {
  std::vector<std::string> files;
  std::vector<SweepManifest> manifests;  ///< one for each of the files
};

/// Failure: throws std::invalid_argument naming the folder and the ranges that are missing, or two files that overlap,
///          or two manifests and what differs between their sweeps.
CompleteSweep completeSweep(const std::string& folder);

/// Writes the file that one run over all states would have written, byte for byte. Returns its manifest.
/// Failure: throws std::invalid_argument naming a part whose content is not what its manifest says. Nothing is written
///          then.
SweepManifest mergeSweep(const CompleteSweep& sweep, const OutputFormat& format, const std::string& out);

}  // namespace proximity_server::tools
