#pragma once

#include <cstddef>
#include <memory>
#include <string>

struct XXH64_state_s;

namespace proximity_server::tools {

/// A hash of bytes, the same on every machine: XXH64 with seed 0, which each version of xxHash has. It tells contents apart
/// that differ by chance, not those that somebody made to have the same hash.
class ContentHash {
 public:
  ContentHash();
  ~ContentHash();

  ContentHash& add(const void* data, std::size_t size);
  /// Adds the text and its length, so that "a", "bc" is not "ab", "c".
  ContentHash& add(const std::string& text);

  /// 16 hexadecimal digits.
  std::string text() const;

 private:
  std::unique_ptr<XXH64_state_s, void (*)(XXH64_state_s*)> state_;
};

/// Hashes the whole file, at the speed of the disk. Throws std::invalid_argument naming it if it cannot be read.
std::string contentHash(const std::string& path);

}  // namespace proximity_server::tools
