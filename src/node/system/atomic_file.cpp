#include "node/system/atomic_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <system_error>

namespace proximity_server::node {
namespace {

/// An open file, closed at the end of its scope.
class Descriptor {
 public:
  Descriptor(const std::string& path, int flags) : path_(path), number_(open(path.c_str(), flags | O_CLOEXEC, 0666)) {
    require(number_ >= 0);
  }
  ~Descriptor() { close(number_); }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;

  void write(const std::string& text) {
    for (std::size_t done = 0; done < text.size();) {
      const ssize_t count = ::write(number_, text.data() + done, text.size() - done);
      if (count < 0 && errno == EINTR) continue;
      require(count >= 0);
      done += static_cast<std::size_t>(count);
    }
  }
  void putOnDisk() { require(fsync(number_) == 0); }

 private:
  void require(bool condition) const {
    if (!condition) throw std::system_error(errno, std::generic_category(), path_);
  }
  const std::string path_;
  const int number_;
};

}  // namespace

void replaceFile(const std::string& path, const std::string& text) {
  const std::string draft = path + ".draft";
  Descriptor file(draft, O_WRONLY | O_CREAT | O_TRUNC);
  try {
    file.write(text);
    file.putOnDisk();
    std::filesystem::rename(draft, path);
  } catch (...) {
    std::error_code ignored;
    std::filesystem::remove(draft, ignored);
    throw;
  }
  // The name is in the folder, which has to reach the disk too.
  Descriptor(std::filesystem::path(path).parent_path(), O_RDONLY | O_DIRECTORY).putOnDisk();
}

}  // namespace proximity_server::node
