#pragma once

#include <string>
#include <string_view>

#include "system/whole_file.h"
#include "tools/command_line/content_hash.h"
#include "tools/sweep/output_format.h"
#include "tools/sweep/sweep_manifest.h"

namespace proximity_server::tools {

/// A file of rows that has its name only once it is complete.
class RowFile {
 public:
  RowFile(const std::string& path, OutputFormat format);

  /// Says that so many rows follow; then append() gets them, with what stands between them.
  void beginRows(std::uint64_t count);
  void append(std::string_view bytes);

  std::uint64_t rows() const { return rows_; }
  std::uint64_t bytes() const { return file_.size(); }

  /// Writes the end, removes an older manifest, gives the file its name, and fills in what the manifest says of it.
  void complete(SweepManifest& manifest);

  const OutputFormat& format() const { return format_; }
  const std::string& path() const { return file_.path(); }

 private:
  OutputFormat format_;
  system::WholeFile file_;
  ContentHash hash_;  ///< of what append() and beginRows() wrote, less before_first
  std::uint64_t rows_ = 0;
};

}  // namespace proximity_server::tools
