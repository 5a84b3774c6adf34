#pragma once

#include <cstdint>
#include <mutex>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace proximity_server::system {

/// Thrown where a file would be read and written. It is no std::invalid_argument, which some readers take for a file
/// that is missing, and go on without it.
struct FileConflict : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// The files that a program reads and those that it writes, as its command line says. None may be both, as the input
/// would be lost, and no two outputs may be one file.
///
/// Two paths are the same file if they have the same device and inode, through links and in any spelling; paths of
/// files that do not exist, if they lead to the same place. Only regular files count: a terminal may be both.
/// Thread-safe.
class FileRoles {
 public:
  /// Those of this process, which WholeFile asks. Inline, so that a library has no other ones.
  static FileRoles& ofProcess() {
    static FileRoles roles;
    return roles;
  }

  /// Notes a file that is read. `role` says what for: "--states", "the mesh".
  /// Failure: throws FileConflict naming both if it is an output.
  void addInput(const std::string& role, const std::string& path);

  /// Notes a file that will be written.
  /// Failure: throws FileConflict naming both if it is an input, or another output.
  void addOutput(const std::string& role, const std::string& path);

  /// Throws FileConflict naming both if the file is an input.
  void requireNoInput(const std::string& path) const;

 private:
  struct File {
    std::string role, path;
    std::string text() const { return role + " " + path; }
  };
  mutable std::mutex mutex_;
  std::vector<File> inputs_, outputs_;  // guarded by mutex_
};

/// A file that gets its name only when it is complete. Until then it is a temporary file in the same folder,
/// ".NAME.HOST-PID-0.tmp", which complete() writes to the disk and renames. If the process is killed, the temporary
/// file stays, and removeLeftOvers() removes it. Two processes may write the same file at the same time: the one that
/// completes last wins.
///
/// A link stays a link, and the file that it leads to is replaced, which need not exist. The new file has the
/// permissions of the old one. Anything but a regular file, such as a pipe or /dev/null, is written directly, and so is
/// a descriptor of this process, such as /dev/stdout.
/// Failure: throws std::invalid_argument with the file and the cause, and FileConflict for an input of the process.
///          Then no file has the name that did not have it before.
class WholeFile {
 public:
  explicit WholeFile(const std::string& path);
  ~WholeFile();  ///< removes the temporary file
  WholeFile(const WholeFile&) = delete;
  WholeFile& operator=(const WholeFile&) = delete;

  void append(std::string_view bytes);

  /// Passes on what was appended, so that the reader of a pipe gets it.
  void flush();

  /// Replaces the first bytes. The file must be seekable, which a pipe is not.
  void replaceBegin(std::string_view bytes);

  std::uint64_t size() const { return size_; }
  const std::string& path() const { return path_; }

  /// The descriptor of the file, for another program that writes into it. It stays open as long as this object lives.
  int descriptor() const { return file_; }

  /// Gives the file its name. Nothing may be written afterwards.
  void complete();

 private:
  [[noreturn]] void fail(const std::string& what) const;

  std::string path_, target_;  ///< as given, and without the links at its end
  std::string temporary_;      ///< "": written directly
  std::string buffer_;
  int file_ = -1;
  std::uint64_t size_ = 0;
};

/// Creates a file with the text, or replaces the file as a whole.
void replaceFile(const std::string& path, std::string_view text);

/// Throws as WholeFile if the file cannot be written, so that this is known before hours of computing. Nothing changes.
/// A pipe is not tried: opening and closing it would be the end of the data for its reader.
void requireWritable(const std::string& path);

/// Removes the temporary files for a name that killed processes left behind. Those of running processes stay.
void removeLeftOvers(const std::string& path);

/// Removes the temporary files in a folder for all names that begin with `begin`.
void removeLeftOvers(const std::string& folder, const std::string& begin);

/// The text of an error number, in parentheses, to be appended to a message: " (No space left on device)"; "" for 0.
std::string because(int error_number);

}  // namespace proximity_server::system
