#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

struct zip;

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

/// The bytes of a regular file. A file that others cut off while it is read is an error, not a crash as of a mapped
/// one.
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

/// A ZIP archive, as .npz are, opened for reading.
///
/// Failure: throws std::invalid_argument naming the file and the member.
class ZipArchive {
 public:
  explicit ZipArchive(const std::string& path);

  /// The names of all members, in the order of the archive.
  const std::vector<std::string>& members() const { return members_; }

  /// The bytes of a member. A stored one is read in its place; its checksum is proven if all of it is read, with its
  /// last byte. One that is compressed is unpacked into an unnamed temporary file first, so that any part of it can be
  /// read, and its checksum is proven then. Encrypted members are refused.
  std::unique_ptr<Bytes> open(const std::string& member) const;

 private:
  std::string path_;
  std::shared_ptr<zip> archive_;
  std::vector<std::string> members_;
};

}  // namespace proximity_server::tools
