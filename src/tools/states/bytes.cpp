#include "tools/states/bytes.h"

#include "tools/text/output_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zip.h>

#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <stdexcept>
#include <system_error>
#include <utility>

namespace proximity_server::tools {
namespace {

using OpenMember = std::unique_ptr<zip_file_t, decltype(&zip_fclose)>;

/// A member that is not compressed.
class StoredBytes : public Bytes {
 public:
  StoredBytes(std::shared_ptr<zip_t> archive, OpenMember member, std::uint64_t size)
      : archive_(std::move(archive)), member_(std::move(member)), size_(size) {}

  std::uint64_t size() const override { return size_; }

  void read(std::uint64_t begin, void* to, std::size_t count) override {
    if (begin != at_ && zip_fseek(member_.get(), static_cast<zip_int64_t>(begin), SEEK_SET) != 0) fail();
    at_ = begin;
    auto* bytes = static_cast<char*>(to);
    while (count > 0) {
      const zip_int64_t got = zip_fread(member_.get(), bytes, count);
      if (got < 0) fail();
      if (got == 0) throw std::invalid_argument("truncated: ends at byte " + std::to_string(at_));
      bytes += got;
      at_ += static_cast<std::uint64_t>(got);
      count -= static_cast<std::size_t>(got);
    }
    // libzip compares the checksum of what was read, if that is all, when it is asked for more.
    char behind = 0;
    if (at_ == size_ && zip_fread(member_.get(), &behind, 1) != 0) fail();
  }

 private:
  [[noreturn]] void fail() const {
    throw std::invalid_argument(std::string("reading failed (") + zip_file_strerror(member_.get()) + ")");
  }

  std::shared_ptr<zip_t> archive_;
  OpenMember member_;
  std::uint64_t size_, at_ = 0;
};

struct CloseFile {
  void operator()(std::FILE* file) const { std::fclose(file); }
};

/// Copies the whole member into a file without a name, in the folder for temporary files.
std::unique_ptr<Bytes> unpacked(zip_file_t* member, std::uint64_t size, const std::string& name) {
  std::error_code missing;
  std::string path = std::filesystem::temp_directory_path(missing) / "proximity_server.XXXXXX";
  if (missing) throw std::invalid_argument(name + ": no folder for temporary files to unpack it into; set TMPDIR");
  const int descriptor = mkstemp(path.data());
  if (descriptor < 0) throw std::invalid_argument(path + ": cannot be created, to unpack " + name);
  unlink(path.c_str());
  const std::unique_ptr<std::FILE, CloseFile> file(fdopen(dup(descriptor), "wb"));
  std::array<char, 1 << 16> buffer;
  std::uint64_t unpacked = 0;
  zip_int64_t got = 0;
  bool is_written = file != nullptr;
  while (is_written && unpacked <= size && (got = zip_fread(member, buffer.data(), buffer.size())) > 0) {
    unpacked += static_cast<std::uint64_t>(got);
    is_written =
        std::fwrite(buffer.data(), 1, static_cast<std::size_t>(got), file.get()) == static_cast<std::size_t>(got);
  }
  is_written = is_written && std::fflush(file.get()) == 0;
  auto bytes = std::make_unique<FileBytes>(descriptor, name);
  if (got < 0) throw std::invalid_argument(name + ": damaged (" + zip_file_strerror(member) + ")");
  if (!is_written) throw std::invalid_argument(path + ": writing failed, to unpack " + name);
  if (unpacked != size) throw std::invalid_argument(name + ": damaged (not as long as the archive says)");
  return bytes;
}

}  // namespace

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

ZipArchive::ZipArchive(const std::string& path) : path_(path) {
  int code = 0;
  archive_.reset(zip_open(path.c_str(), ZIP_RDONLY | ZIP_CHECKCONS, &code), [](zip_t* archive) {
    if (archive) zip_discard(archive);
  });
  if (!archive_) {
    zip_error_t error;
    zip_error_init_with_code(&error, code);
    const std::string text = zip_error_strerror(&error);
    zip_error_fini(&error);
    throw std::invalid_argument(path + ": no .npz, or a damaged one (" + text + ")");
  }
  const zip_int64_t count = zip_get_num_entries(archive_.get(), 0);
  for (zip_int64_t i = 0; i < count; ++i) {
    const char* name = zip_get_name(archive_.get(), static_cast<zip_uint64_t>(i), 0);
    members_.emplace_back(name ? name : "");
  }
}

std::unique_ptr<Bytes> ZipArchive::open(const std::string& member) const {
  const std::string name = path_ + ", " + member;
  zip_stat_t status;
  zip_stat_init(&status);
  constexpr zip_uint64_t kNeeded = ZIP_STAT_INDEX | ZIP_STAT_SIZE | ZIP_STAT_COMP_METHOD | ZIP_STAT_ENCRYPTION_METHOD;
  if (zip_stat(archive_.get(), member.c_str(), 0, &status) != 0 || (status.valid & kNeeded) != kNeeded)
    throw std::invalid_argument(name + ": cannot be found");
  if (status.encryption_method != ZIP_EM_NONE) throw std::invalid_argument(name + ": encrypted");
  OpenMember file(zip_fopen_index(archive_.get(), status.index, 0), &zip_fclose);
  if (!file) throw std::invalid_argument(name + ": cannot be read (" + zip_strerror(archive_.get()) + ")");
  if (status.comp_method != ZIP_CM_STORE) return unpacked(file.get(), status.size, name);
  return std::make_unique<StoredBytes>(archive_, std::move(file), status.size);
}

}  // namespace proximity_server::tools
