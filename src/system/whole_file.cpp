#include "system/whole_file.h"

#include "system/number_text.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <optional>
#include <stdexcept>
#include <system_error>
#include <vector>

namespace proximity_server::system {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kBuffer = std::size_t{1} << 20;  ///< [byte] so large that system calls cost hardly anything
constexpr std::size_t kPipeBuffer = 8192;              ///< [byte] so small that a reader need not wait for long
constexpr const char *kPrefix = ".", *kSuffix = ".tmp";
constexpr int kMostLinks = 40;  ///< one after the other, as for Linux

bool writeAll(int file, std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(file, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return false;
    bytes.remove_prefix(static_cast<std::size_t>(written));
  }
  return true;
}

fs::path folderOf(const fs::path& path) {
  const fs::path folder = path.parent_path();
  return folder.empty() ? "." : folder;
}

/// The number of the descriptor of this process that a path names, as /proc/self/fd/1; nullopt of any other path.
std::optional<int> descriptorOf(const fs::path& path) {
  std::error_code none;
  const fs::path folder = fs::canonical(folderOf(path), none), own = fs::canonical("/proc/self/fd", none);
  if (none || folder != own) return std::nullopt;
  return numberIn<int>(path.filename().native());
}

/// The file that a path leads to through links, which need not exist; or the link that names a descriptor. If links
/// lead in a circle, it is one of them, which the system refuses to open.
fs::path targetOf(fs::path path) {
  for (int links = 0; links < kMostLinks && !descriptorOf(path); ++links) {
    std::error_code is_no_link;
    const fs::path next = fs::read_symlink(path, is_no_link);
    if (is_no_link) break;
    path = folderOf(path) / next;  // an absolute one replaces the folder
  }
  return path;
}

/// Whether two paths lead to one regular file, or to the place of one that does not exist.
bool areSameFile(const std::string& a, const std::string& b) {
  std::error_code error;
  const fs::file_status of_a = fs::status(a, error), of_b = fs::status(b, error);
  if (fs::is_regular_file(of_a) && fs::is_regular_file(of_b)) return fs::equivalent(a, b, error);
  const auto isMissing = [](const fs::file_status& status) { return status.type() == fs::file_type::not_found; };
  if (!isMissing(of_a) || !isMissing(of_b)) return false;
  const fs::path target_a = targetOf(a), target_b = targetOf(b);
  return target_a.filename() == target_b.filename() && fs::equivalent(folderOf(target_a), folderOf(target_b), error);
}

/// Gives a new file the owner and the permissions of the file that it will replace, as far as this process may and the
/// file system has them.
void adopt(int file, const struct stat& replaced) {
  const bool has_owner = ::fchown(file, replaced.st_uid, replaced.st_gid) == 0;
  ::fchmod(file, replaced.st_mode & (has_owner ? 07777U : 0777U));
}

std::string conflict(const std::string& output, const std::string& input) {
  return output + ": is the same file as " + input + ", which is read and would be lost";
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

void FileRoles::addInput(const std::string& role, const std::string& path) {
  const std::lock_guard<std::mutex> lock(mutex_);
  inputs_.push_back({role, path});
  for (const File& output : outputs_)
    if (areSameFile(output.path, path)) throw FileConflict(conflict(output.text(), inputs_.back().text()));
}

void FileRoles::addOutput(const std::string& role, const std::string& path) {
  const std::lock_guard<std::mutex> lock(mutex_);
  const File added{role, path};
  for (const File& input : inputs_)
    if (areSameFile(input.path, path)) throw FileConflict(conflict(added.text(), input.text()));
  const bool is_stream = descriptorOf(targetOf(path)).has_value();  // where several may write one after the other
  for (const File& output : outputs_)
    if (!is_stream && areSameFile(output.path, path))
      throw FileConflict(added.text() + ": is the same file as " + output.text() + ", and both would be written");
  outputs_.push_back(added);
}

void FileRoles::requireNoInput(const std::string& path) const {
  const std::lock_guard<std::mutex> lock(mutex_);
  for (const File& input : inputs_)
    if (areSameFile(input.path, path)) throw FileConflict(conflict(path, input.text()));
}

WholeFile::WholeFile(const std::string& path) : path_(path) {
  FileRoles::ofProcess().requireNoInput(path);
  target_ = targetOf(path);
  struct stat status {};
  const bool exists = ::stat(path.c_str(), &status) == 0;
  if (!exists && errno != ENOENT) fail("cannot be written" + because(errno));
  if (exists && S_ISDIR(status.st_mode)) fail("is a folder, not a file");
  if (const std::optional<int> descriptor = descriptorOf(target_)) {
    file_ = ::fcntl(*descriptor, F_DUPFD_CLOEXEC, 0);
  } else if (exists && !S_ISREG(status.st_mode)) {
    file_ = ::open(path.c_str(), O_WRONLY | O_CLOEXEC);
  } else if (!exists || ::access(path.c_str(), W_OK) == 0) {
    const std::string name = fs::path(target_).filename();
    file_ = openLocked(folderOf(target_) / (kPrefix + name + "." + processName()), temporary_);
  }
  if (file_ < 0) fail("cannot be written" + because(errno));
  if (exists && !temporary_.empty()) adopt(file_, status);
  buffer_.reserve(kBuffer);
}

WholeFile::~WholeFile() {
  if (file_ >= 0) ::close(file_);
  if (!temporary_.empty()) ::unlink(temporary_.c_str());
}

void WholeFile::append(std::string_view bytes) {
  if (buffer_.size() + bytes.size() > (temporary_.empty() ? kPipeBuffer : kBuffer)) flush();
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
  if (::rename(temporary_.c_str(), target_.c_str()) != 0) fail("cannot be given its name" + because(errno));
  temporary_.clear();
  syncFolder(folderOf(target_));
}

void WholeFile::fail(const std::string& what) const { throw std::invalid_argument(path_ + ": " + what); }

void replaceFile(const std::string& path, std::string_view text) {
  WholeFile file(path);
  file.append(text);
  file.complete();
}

void requireWritable(const std::string& path) {
  std::error_code ignored;
  const fs::file_status status = fs::status(path, ignored);
  if (fs::exists(status) && !fs::is_regular_file(status) && !fs::is_directory(status)) return;
  removeLeftOvers(path);
  const WholeFile tried(path);
}

void removeLeftOvers(const std::string& path) {
  const fs::path target = targetOf(path);
  removeLeftOvers(folderOf(target), target.filename().string() + ".");
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
