#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace proximity_server::node {

/// A queue of entries in memory of a fixed size. One thread appends, and one thread takes; neither waits for the other,
/// and neither allocates. Only the thread that takes may call front() and pop().
class RecordRing {
 public:
  /// Touches all memory, so that no entry causes a page fault.
  explicit RecordRing(std::size_t bytes) : memory_(bytes / kWord * kWord) {}

  /// The place of the next entry of this size, which commit() appends; nullptr if there is no room.
  std::uint8_t* reserve(std::size_t bytes);
  void commit() { head_.store(reserved_, std::memory_order_release); }

  struct Entry {
    const std::uint8_t* data = nullptr;  ///< nullptr: the queue is empty
    std::size_t size = 0;                ///< [byte]
  };

  /// The oldest entry; it is valid until pop(), which removes it.
  Entry front();
  void pop();

 private:
  static constexpr std::size_t kWord = sizeof(std::uint64_t);
  static constexpr std::uint64_t kSkip =
      UINT64_MAX;  ///< in place of a size: the next entry is at the begin of the memory

  static std::size_t sizeWithHead(std::size_t bytes) { return kWord + (bytes + kWord - 1) / kWord * kWord; }

  std::vector<std::uint8_t> memory_;
  std::uint64_t reserved_ = 0;
  // Bytes that were appended, and taken, since the start. Their remainders by the size are places in the memory.
  std::atomic<std::uint64_t> head_{0}, tail_{0};
};

}  // namespace proximity_server::node
