#pragma once

#include "system/whole_file.h"
#include "tools/sweep/output_format.h"
#include "tools/text/content_hash.h"

#include <cstdint>
#include <optional>
#include <ostream>
#include <string>
#include <string_view>

namespace proximity_server::tools {

/// Rows as they are written, with what stands between them.
struct WrittenRows {
  std::string bytes;
  std::uint64_t rows = 0;

  void clear() {
    bytes.clear();
    rows = 0;
  }
};

/// Writes rows, and what stands before, between and after them: to a stream, or to a file that has its name only once
/// it is complete. Failure: the functions throw std::invalid_argument naming the stream or file.
class RowOutput {
 public:
  /// `name` is the name of the stream in messages. The stream must outlive this.
  RowOutput(std::ostream& stream, std::string name, OutputFormat format);
  RowOutput(const std::string& file, OutputFormat format);

  /// Says that so many rows follow; then append() gets them, with what stands between them.
  void beginRows(std::uint64_t count);
  void append(std::string_view bytes);

  void write(const WrittenRows& rows) {
    beginRows(rows.rows);
    append(rows.bytes);
  }

  /// Writes the end of the rows, so that this is a complete document.
  void end();

  /// Gives the file its name, after end().
  void complete();

  std::uint64_t rows() const { return rows_; }
  std::uint64_t bytes() const { return bytes_; }
  /// The hash of all bytes between what OutputFormat puts before and after the rows.
  std::string hash() const { return hash_.text(); }

 private:
  void writeBytes(std::string_view bytes);

  OutputFormat format_;
  std::optional<system::WholeFile> file_;
  std::ostream* stream_ = nullptr;
  std::string name_;
  ContentHash hash_;
  std::uint64_t rows_ = 0, bytes_ = 0;
};

}  // namespace proximity_server::tools
