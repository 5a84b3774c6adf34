#include "system/whole_file.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <stdexcept>
#include <system_error>
#include <vector>

namespace proximity_server::system {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kBuffer = std::size_t{1} << 20;  ///< [byte] so large that system calls cost hardly anything
constexpr const char *kPrefix = ".", *kSuffix = ".tmp";

bool writeAll(int file, std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(file, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return false;
    bytes.remove_prefix(static_cast<std::size_t>(written));
  }
  return true;
}

fs::path folderOf(const std::string& path) {
  const fs::path folder = fs::path(path).parent_path();
  return folder.empty() ? "." : folder;
}

/// Creates a temporary file with a new name that begins with `begin`, and locks it, so that others see that its process
/// lives. Returns -1 with errno on failure.
int openLocked(const std::string& begin, std::string& path) {
  for (int attempt = 0;; ++attempt) {
    path = begin + "-" + std::to_string(attempt) + kSuffix;
    const int file = ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (file < 0 && errno == EEXIST) continue;
    if (file < 0) return -1;
    ::flock(file, LOCK_EX);  // if the file system has no locks, left-over files are never removed
    struct stat status {};
    if (::fstat(file, &status) == 0 && status.st_nlink > 0) return file;
    ::close(file);  // another process took it for a left-over file before it was locked
  }
}

/// Makes a name in a folder survive a loss of power. Some file systems refuse this, and that is ignored.
void syncFolder(const fs::path& folder) {
  const int file = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (file < 0) return;
  ::fsync(file);
  ::close(file);
}

/// Removes a temporary file unless a process holds its lock.
void removeIfLeft(const fs::path& path) {
  const int file = ::open(path.c_str(), O_WRONLY | O_CLOEXEC);  // NFS locks only files that are open for writing
  if (file < 0) return;
  if (::flock(file, LOCK_EX | LOCK_NB) == 0) ::unlink(path.c_str());
  ::close(file);
}

/// A name for this process. It may not be unique, because containers may have equal host names and their own process
/// numbers.
std::string processName() {
  std::vector<char> host(256, '\0');
  ::gethostname(host.data(), host.size() - 1);
  return std::string(host.data()) + "-" + std::to_string(::getpid());
}

}  // namespace

WholeFile::WholeFile(const std::string& path) : path_(path) {
  std::error_code ignored;
  const fs::file_status status = fs::status(path, ignored);
  if (fs::is_directory(status)) fail("is a folder, not a file");
  if (fs::exists(status) && !fs::is_regular_file(status)) {
    file_ = ::open(path.c_str(), O_WRONLY | O_CLOEXEC);
  } else {
    const std::string name = fs::path(path).filename();
    file_ = openLocked(folderOf(path) / (kPrefix + name + "." + processName()), temporary_);
  }
  if (file_ < 0) fail("cannot be written" + because(errno));
  buffer_.reserve(kBuffer);
}

WholeFile::~WholeFile() {
  if (file_ >= 0) ::close(file_);
  if (!temporary_.empty()) ::unlink(temporary_.c_str());
}

void WholeFile::append(std::string_view bytes) {
  if (buffer_.size() + bytes.size() > kBuffer) flush();
  size_ += bytes.size();
  if (bytes.size() > kBuffer) {
    if (!writeAll(file_, bytes)) fail("writing failed" + because(errno));
  } else {
    buffer_ += bytes;
  }
}

void WholeFile::flush() {
  if (!writeAll(file_, buffer_)) fail("writing failed" + because(errno));
  buffer_.clear();
}

void WholeFile::replaceBegin(std::string_view bytes) {
  flush();
  if (::lseek(file_, 0, SEEK_SET) < 0) fail("its begin cannot be written at the end" + because(errno));
  if (!writeAll(file_, bytes)) fail("writing failed" + because(errno));
}

void WholeFile::complete() {
  flush();
  if (temporary_.empty()) return;
  if (::fsync(file_) != 0) fail("writing failed" + because(errno));
  if (::rename(temporary_.c_str(), path_.c_str()) != 0) fail("cannot be given its name" + because(errno));
  temporary_.clear();
  syncFolder(folderOf(path_));
}

void WholeFile::fail(const std::string& what) const { throw std::invalid_argument(path_ + ": " + what); }

void replaceFile(const std::string& path, std::string_view text) {
  WholeFile file(path);
  file.append(text);
  file.complete();
}

void removeLeftOvers(const std::string& path) {
  removeLeftOvers(folderOf(path), fs::path(path).filename().string() + ".");
}

void removeLeftOvers(const std::string& folder, const std::string& begin) {
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, error)) {
    const std::string name = entry.path().filename();
    const bool is_temporary =
        name.compare(0, begin.size() + 1, kPrefix + begin) == 0 && entry.path().extension() == kSuffix;
    if (is_temporary) removeIfLeft(entry.path());
  }
}

std::string because(int error_number) {
  return error_number != 0 ? std::string(" (") + std::strerror(error_number) + ")" : "";
}

}  // namespace proximity_server::system
