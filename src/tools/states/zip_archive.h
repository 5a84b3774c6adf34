#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "tools/states/bytes.h"

struct zip;

namespace proximity_server::tools {

/// A ZIP archive, as .npz are, opened for reading.
///
/// Failure: throws std::invalid_argument naming the file and the member.
class ZipArchive {
 public:
  explicit ZipArchive(const std::string& path);

  /// The names of all members, in the order of the archive.
  const std::vector<std::string>& members() const { return members_; }

  /// The bytes of a member. A stored one is read in its place; its checksum is proven if all of it is read, with its last byte.
  /// One that is compressed is unpacked into an unnamed temporary file first, so that any part of it can be read, and its
  /// checksum is proven then. Encrypted members are refused.
  std::unique_ptr<Bytes> open(const std::string& member) const;

 private:
  std::string path_;
  std::shared_ptr<zip> archive_;
  std::vector<std::string> members_;
};

}  // namespace proximity_server::tools
