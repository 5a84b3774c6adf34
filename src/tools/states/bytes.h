#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

namespace proximity_server::tools {

/// The bytes of a file, or of a member of an archive, at any place.
class Bytes {
 public:
  virtual ~Bytes() = default;
  Bytes(const Bytes&) = delete;
  Bytes& operator=(const Bytes&) = delete;

  virtual std::uint64_t size() const = 0;

  /// Copies `count` bytes from `begin` on. Throws std::invalid_argument without a name if they cannot be read.
  virtual void read(std::uint64_t begin, void* to, std::size_t count) = 0;

 protected:
  Bytes() = default;
};

/// The bytes of a regular file. A file that others cut off while it is read is an error, not a crash as of a mapped one.
///
/// Failure: the constructor throws std::invalid_argument naming the file.
class FileBytes : public Bytes {
 public:
  explicit FileBytes(const std::string& path);
  /// Takes over an open file. `name` is that in messages.
  FileBytes(int descriptor, const std::string& name);
  ~FileBytes() override;

  std::uint64_t size() const override { return size_; }
  void read(std::uint64_t begin, void* to, std::size_t count) override;

 private:
  int descriptor_;
  std::uint64_t size_ = 0;
};

}  // namespace proximity_server::tools
