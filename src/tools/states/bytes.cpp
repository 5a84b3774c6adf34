#include "tools/states/bytes.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <stdexcept>

#include "tools/command_line/output_file.h"

namespace proximity_server::tools {

FileBytes::FileBytes(const std::string& path)
    : FileBytes(open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK), path) {}

FileBytes::FileBytes(int descriptor, const std::string& name) : descriptor_(descriptor) {
  struct stat status {};
  const bool is_open = descriptor_ >= 0 && fstat(descriptor_, &status) == 0;
  const int cause = is_open ? 0 : errno;
  const bool is_file = is_open && S_ISREG(status.st_mode);
  if (!is_file && descriptor_ >= 0) close(descriptor_);
  if (!is_open) throw std::invalid_argument(name + ": cannot be read" + because(cause));
  if (!is_file) throw std::invalid_argument(name + ": no file; arrays are not read from pipes or folders");
  size_ = static_cast<std::uint64_t>(status.st_size);
}

FileBytes::~FileBytes() { close(descriptor_); }

void FileBytes::read(std::uint64_t begin, void* to, std::size_t count) {
  auto* bytes = static_cast<char*>(to);
  while (count > 0) {
    const ssize_t got = pread(descriptor_, bytes, count, static_cast<off_t>(begin));
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) throw std::invalid_argument(std::string("reading failed (") + std::strerror(errno) + ")");
    if (got == 0) throw std::invalid_argument("truncated: ends at byte " + std::to_string(begin));
    bytes += got;
    begin += static_cast<std::uint64_t>(got);
    count -= static_cast<std::size_t>(got);
  }
}

}  // namespace proximity_server::tools
