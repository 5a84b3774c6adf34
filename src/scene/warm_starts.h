#pragma once

#include <algorithm>
#include <vector>

#include "proximity_server/narrowphase/signed_distance.h"

namespace proximity_server {

/// What the last query of each pair of pieces left behind for the next. A table of fixed size: a pair that falls on the
/// place of another one takes it over, and starts cold.
class WarmStarts {
 public:
  explicit WarmStarts(std::size_t pieces) : entries_(placesFor(pieces)) {}

  WarmStart& of(int piece_a, int piece_b) {
    // Golden ratio and prime multipliers spread neighbours (Knuth, TAOCP 3, 6.4); the high bits are the best mixed.
    const std::size_t key = static_cast<std::size_t>(piece_a) * 0x9E3779B97F4A7C15u +
                            static_cast<std::size_t>(piece_b) * 0xC2B2AE3D27D4EB4Fu;
    Entry& entry = entries_[(key >> 32) & (entries_.size() - 1)];
    if (entry.piece_a != piece_a || entry.piece_b != piece_b) entry = {piece_a, piece_b, {}};
    return entry.warm_start;
  }

 private:
  struct Entry {
    int piece_a = -1, piece_b = -1;
    WarmStart warm_start;
  };

  /// A power of two, with room for all pairs of a robot of up to 256 pieces.
  static std::size_t placesFor(std::size_t pieces) {
    constexpr std::size_t kMostPlaces = 1u << 16;
    std::size_t places = 1;
    while (places < std::min(pieces * pieces, kMostPlaces)) places *= 2;
    return places;
  }

  std::vector<Entry> entries_;
};

}  // namespace proximity_server
