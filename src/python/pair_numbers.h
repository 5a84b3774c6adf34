#pragma once

#include "proximity_server/scene/objects/objects.h"
#include "proximity_server/scene/query/pairs.h"

#include <cstddef>
#include <cstdint>
#include <unordered_map>
#include <vector>

namespace proximity_server::python {

/// The checked pairs of a robot in the order of Robot.pairs: first the pairs of links, then those with objects.
class PairNumbers {
 public:
  PairNumbers(const scene::Candidates& candidates, const scene::Objects& objects);

  const std::vector<scene::ShapeRefPair>& list() const { return list_; }

  /// The index of a pair in the list; -1 if it is not in the list. The two of the pair are in the order in which a
  /// scene names them.
  std::int32_t of(const scene::ShapeRefPair& pair) const;

 private:
  std::uint64_t keyOf(const scene::ShapeRefPair& pair) const;

  std::uint64_t links_;
  std::vector<scene::ShapeRefPair> list_;
  std::unordered_map<std::uint64_t, std::int32_t> numbers_;
};

}  // namespace proximity_server::python
