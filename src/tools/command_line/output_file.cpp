#include "tools/command_line/output_file.h"

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <stdexcept>

namespace proximity_server::tools {

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

std::string because(int cause) { return cause != 0 ? std::string(" (") + std::strerror(cause) + ")" : ""; }

}  // namespace proximity_server::tools
