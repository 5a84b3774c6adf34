#include "tools/sweep/row_file.h"

#include <filesystem>
#include <system_error>
#include <utility>

namespace proximity_server::tools {

RowFile::RowFile(const std::string& path, OutputFormat format) : format_(std::move(format)), file_(path) {
  file_.append(format_.header(0));
}

void RowFile::beginRows(std::uint64_t count) {
  if (count == 0) return;
  if (rows_ == 0) {
    file_.append(format_.before_first);
  } else {
    append(format_.between);
  }
  rows_ += count;
}

void RowFile::append(std::string_view bytes) {
  hash_.add(bytes.data(), bytes.size());
  file_.append(bytes);
}

void RowFile::complete(SweepManifest& manifest) {
  file_.append(format_.end);
  if (!format_.isText()) file_.replaceBegin(format_.header(rows_));
  // An older one does not belong to the new rows, should this process end before it writes the manifest.
  std::error_code ignored;
  std::filesystem::remove(manifestPath(path()), ignored);
  file_.complete();
  manifest.rows = rows_;
  manifest.bytes = file_.size();
  manifest.hash = hash_.text();
}

}  // namespace proximity_server::tools
