#include "node/record/record_ring.h"

#include <cstring>

namespace proximity_server::node {

std::uint8_t* RecordRing::reserve(std::size_t bytes) {
  const std::size_t needed = sizeWithHead(bytes);
  const std::uint64_t head = head_.load(std::memory_order_relaxed);
  if (memory_.empty()) return nullptr;
  const std::size_t at = head % memory_.size(), to_the_end = memory_.size() - at;
  const std::size_t skipped = needed > to_the_end ? to_the_end : 0;
  const std::size_t used = head - tail_.load(std::memory_order_acquire);
  if (skipped + needed > memory_.size() - used) return nullptr;
  if (skipped > 0) std::memcpy(&memory_[at], &kSkip, kWord);
  std::uint8_t* const place = &memory_[skipped > 0 ? 0 : at];
  const std::uint64_t size = bytes;
  std::memcpy(place, &size, kWord);
  reserved_ = head + skipped + needed;
  return place + kWord;
}

RecordRing::Entry RecordRing::front() {
  std::uint64_t tail = tail_.load(std::memory_order_relaxed);
  if (tail == head_.load(std::memory_order_acquire)) return {};
  std::size_t at = tail % memory_.size();
  std::uint64_t size = 0;
  std::memcpy(&size, &memory_[at], kWord);
  if (size == kSkip) {
    tail_.store(tail + memory_.size() - at, std::memory_order_release);
    at = 0;
    std::memcpy(&size, memory_.data(), kWord);
  }
  return {&memory_[at] + kWord, static_cast<std::size_t>(size)};
}

void RecordRing::pop() {
  const Entry entry = front();
  if (entry.data)
    tail_.store(tail_.load(std::memory_order_relaxed) + sizeWithHead(entry.size), std::memory_order_release);
}

}  // namespace proximity_server::node
