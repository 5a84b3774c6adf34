#include "tools/sweep/row_output.h"

#include "tools/sweep/sweep_manifest.h"
#include "tools/text/output_file.h"

#include <filesystem>
#include <system_error>
#include <utility>

namespace proximity_server::tools {

RowOutput::RowOutput(std::ostream& stream, std::string name, OutputFormat format)
    : format_(std::move(format)), stream_(&stream), name_(std::move(name)) {
  writeBytes(format_.header(0));
}

RowOutput::RowOutput(const std::string& file, OutputFormat format)
    : format_(std::move(format)), file_(std::in_place, file), name_(file) {
  system::FileRoles::ofProcess().requireNoInput(manifestPath(file));  // complete() removes it
  system::removeLeftOvers(file);
  writeBytes(format_.header(0));
}

void RowOutput::beginRows(std::uint64_t count) {
  if (count == 0) return;
  if (rows_ == 0) {
    writeBytes(format_.before_first);
  } else {
    append(format_.between);
  }
  rows_ += count;
}

void RowOutput::append(std::string_view bytes) {
  hash_.add(bytes.data(), bytes.size());
  writeBytes(bytes);
}

void RowOutput::end() {
  writeBytes(format_.end);
  if (!file_) return flushTo(*stream_, name_);
  if (format_.rows == RowFormat::Npy) file_->replaceBegin(format_.header(rows_));
  file_->flush();
}

void RowOutput::complete() {
  if (!file_) return;
  // An older one does not belong to the new rows, should this process end before it writes the manifest.
  std::error_code ignored;
  std::filesystem::remove(manifestPath(name_), ignored);
  file_->complete();
}

void RowOutput::writeBytes(std::string_view bytes) {
  bytes_ += bytes.size();
  if (file_) {
    file_->append(bytes);
  } else {
    writeTo(*stream_, name_, bytes);
  }
}

}  // namespace proximity_server::tools
