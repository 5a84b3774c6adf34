#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace proximity_server::system {

/// A file that has its name only once it is complete. Until then it is a temporary one beside it, ".NAME.HOST-PID-0.tmp", which
/// complete() writes to the disk and renames; if the process is killed it stays, and removeLeftOvers() removes it. Two
/// processes may write the same file at once: the last one's stays.
///
/// A name that stands for no regular file, such as /dev/null, is written directly.
/// Failure: throws std::invalid_argument naming the file and the cause; then no file has the name that had it not.
class WholeFile {
 public:
  explicit WholeFile(const std::string& path);
  ~WholeFile();  ///< removes the temporary file
  WholeFile(const WholeFile&) = delete;
  WholeFile& operator=(const WholeFile&) = delete;

  void append(std::string_view bytes);

  /// Replaces the first bytes. Needs a file that can be written anywhere, which a pipe cannot.
  void replaceBegin(std::string_view bytes);

  std::uint64_t size() const { return size_; }
  const std::string& path() const { return path_; }

  /// Gives the file its name. Nothing may follow.
  void complete();

 private:
  void flush();
  [[noreturn]] void fail(const std::string& what) const;

  std::string path_, temporary_;
  std::string buffer_;
  int file_ = -1;
  std::uint64_t size_ = 0;
};

/// Makes a file of the text, or replaces one, as a whole.
void replaceFile(const std::string& path, std::string_view text);

/// Removes the temporary files of a name that killed processes left behind; those of running ones stay.
void removeLeftOvers(const std::string& path);

/// The same for all names in a folder that begin so.
void removeLeftOvers(const std::string& folder, const std::string& begin);

/// The text of an error number, in parentheses, to be appended to a message: " (No space left on device)"; "" for 0.
std::string because(int error_number);

}  // namespace proximity_server::system
