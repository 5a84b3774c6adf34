#include "python/pair_numbers.h"

namespace proximity_server::python {

using scene::ShapeRef;

PairNumbers::PairNumbers(const scene::Candidates& candidates, const scene::Objects& objects)
    : links_(objects.model().robot.links.size()), list_(candidates.list()) {
  objects.forEachCheckedPair([&](const ShapeRef& a, const ShapeRef& b) { list_.push_back({a, b}); });
  numbers_.reserve(list_.size());
  for (const scene::ShapeRefPair& pair : list_)
    numbers_.emplace(keyOf(pair), static_cast<std::int32_t>(numbers_.size()));
}

std::uint64_t PairNumbers::keyOf(const scene::ShapeRefPair& pair) const {
  const auto root = [this](const ShapeRef& ref) {
    return ref.isLink() ? static_cast<std::uint64_t>(ref.link()) : links_ + static_cast<std::uint64_t>(ref.object());
  };
  return root(pair.a) << 32 | root(pair.b);
}

std::int32_t PairNumbers::of(const scene::ShapeRefPair& pair) const {
  const auto place = numbers_.find(keyOf(pair));
  return place == numbers_.end() ? -1 : place->second;
}

}  // namespace proximity_server::python
