#pragma once

#include <algorithm>
#include <utility>
#include <vector>

namespace proximity_server::scene {

/// A hash table of fixed size that keeps values for pairs of numbers >= 0 until later questions. If the places for a
/// new pair are occupied, it replaces an old pair.
template <typename Value>
class PairMemory {
 public:
  /// Makes a table with room for at least so many pairs.
  explicit PairMemory(std::size_t pairs) : entries_(placesFor(pairs)) {}

  /// nullptr for a pair that is not in the table.
  const Value* find(int a, int b) const {
    for (std::size_t place = firstPlace(a, b), end = place + kWindow; place != end; ++place) {
      const Entry& entry = entries_[inTable(place)];
      if (entry.a == a && entry.b == b) return &entry.value;
    }
    return nullptr;
  }

  /// Removes the pairs of numbers (a, b) for which isVoid(a, b) is true.
  template <typename Predicate>
  void forget(const Predicate& isVoid) {
    for (Entry& entry : entries_)
      if (entry.a >= 0 && isVoid(entry.a, entry.b)) entry = {};
  }

  /// Makes room for at least so many pairs. Keeps the pairs that it knows, if they find a place.
  void grow(std::size_t pairs) {
    if (placesFor(pairs) <= entries_.size()) return;
    PairMemory larger(pairs);
    for (Entry& entry : entries_)
      if (entry.a >= 0) larger.of(entry.a, entry.b) = std::move(entry.value);
    entries_ = std::move(larger.entries_);
  }

  /// The value of a pair; a new Value if the pair is not in the table.
  Value& of(int a, int b) {
    Entry* free = nullptr;
    const std::size_t first = firstPlace(a, b);
    for (std::size_t place = first; place != first + kWindow; ++place) {
      Entry& entry = entries_[inTable(place)];
      if (entry.a == a && entry.b == b) return entry.value;
      if (!free && entry.a < 0) free = &entry;
    }
    if (!free) free = &entries_[inTable(first)];
    *free = {a, b, Value()};
    return free->value;
  }

 private:
  static constexpr std::size_t kWindow = 8;

  static std::size_t placesFor(std::size_t pairs) {
    std::size_t places = kWindow;
    while (places < 2 * pairs) places *= 2;
    return places;
  }

  struct Entry {
    int a = -1, b = -1;
    Value value;
  };

  /// The first of the places where a pair may be. They lie side by side, and go on at the begin of the table.
  static std::size_t firstPlace(int a, int b) {
    // The golden ratio and a prime as multipliers spread neighbours (Knuth, TAOCP 3, 6.4); the high bits are mixed
    // best.
    const std::size_t key =
        static_cast<std::size_t>(a) * 0x9E3779B97F4A7C15u + static_cast<std::size_t>(b) * 0xC2B2AE3D27D4EB4Fu;
    return key >> 32;
  }
  std::size_t inTable(std::size_t place) const { return place & (entries_.size() - 1); }

  std::vector<Entry> entries_;
};

}  // namespace proximity_server::scene
