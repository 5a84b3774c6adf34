#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace proximity_server::system {

/// A file that gets its name only when it is complete. Until then it is a temporary file in the same folder,
/// ".NAME.HOST-PID-0.tmp", which complete() writes to the disk and renames. If the process is killed, the temporary
/// file stays, and removeLeftOvers() removes it. Two processes may write the same file at the same time: the one that
/// completes last wins.
///
/// A name that is not that of a regular file, such as /dev/null, is written directly.
/// Failure: throws std::invalid_argument with the file and the cause. Then no file has the name that did not have it
///          before.
class WholeFile {
 public:
  explicit WholeFile(const std::string& path);
  ~WholeFile();  ///< removes the temporary file
  WholeFile(const WholeFile&) = delete;
  WholeFile& operator=(const WholeFile&) = delete;

  void append(std::string_view bytes);

  /// Replaces the first bytes. The file must be seekable, which a pipe is not.
  void replaceBegin(std::string_view bytes);

  std::uint64_t size() const { return size_; }
  const std::string& path() const { return path_; }

  /// Gives the file its name. Nothing may be written afterwards.
  void complete();

 private:
  void flush();
  [[noreturn]] void fail(const std::string& what) const;

  std::string path_, temporary_;
  std::string buffer_;
  int file_ = -1;
  std::uint64_t size_ = 0;
};

/// Creates a file with the text, or replaces the file as a whole.
void replaceFile(const std::string& path, std::string_view text);

/// Removes the temporary files for a name that killed processes left behind. Those of running processes stay.
void removeLeftOvers(const std::string& path);

/// Removes the temporary files in a folder for all names that begin with `begin`.
void removeLeftOvers(const std::string& folder, const std::string& begin);

/// The text of an error number, in parentheses, to be appended to a message: " (No space left on device)"; "" for 0.
std::string because(int error_number);

}  // namespace proximity_server::system
