#include "tools/text/output_file.h"

#include <cerrno>
#include <filesystem>
#include <ostream>
#include <stdexcept>

namespace proximity_server::tools {
namespace {

/// Throws if writing to the stream has failed, with the cause that errno tells.
void requireWritten(const std::ostream& stream, const std::string& name) {
  const int cause = errno;
  if (!stream) throw std::invalid_argument(name + ": writing failed" + because(cause));
}

}  // namespace

void requireWritable(const std::string& path) {
  std::error_code ignored;
  const std::filesystem::file_status status = std::filesystem::status(path, ignored);
  const bool existed = std::filesystem::exists(status);
  // A pipe is not tried: opening and closing it would be the end of the data for its reader.
  if (existed && !std::filesystem::is_regular_file(status) && !std::filesystem::is_directory(status)) return;
  errno = 0;
  if (!std::ofstream(path, std::ios::binary | std::ios::app)) {
    const int cause = errno;
    throw std::invalid_argument(path + ": cannot be written" + because(cause));
  }
  if (!existed) std::filesystem::remove(path, ignored);
}

std::ofstream openOutput(const std::string& path) {
  errno = 0;
  std::ofstream file(path, std::ofstream::binary);
  const int cause = errno;
  if (!file) throw std::invalid_argument(path + ": cannot be opened" + because(cause));
  return file;
}

void writeTo(std::ostream& stream, const std::string& name, std::string_view text) {
  errno = 0;
  requireWritten(stream << text, name);
}

void flushTo(std::ostream& stream, const std::string& name) {
  errno = 0;
  requireWritten(stream << std::flush, name);
}

void writeFile(const std::string& path, std::string_view text) {
  std::ofstream stream(path, std::ios::binary);
  writeTo(stream, path, text);
  flushTo(stream, path);
}

}  // namespace proximity_server::tools
