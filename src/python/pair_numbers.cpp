#include "python/pair_numbers.h"

#include <algorithm>

namespace proximity_server::python {

using scene::PairReason;
using scene::ShapeRef;

PairNumbers::PairNumbers(const scene::Candidates& candidates, const scene::Objects& objects)
    : links_(objects.model().robot.links.size()), list_(candidates.list()) {
  for (int link = 0; link < static_cast<int>(links_); ++link)
    for (const int number : objects.numbers())
      if (objects.linkReason(link, number) == PairReason::Checked)
        list_.push_back({{link}, ShapeRef::ofObject(number)});
  const std::vector<int>& walkers = objects.walkers();
  for (const int walker : walkers) {
    for (const int number : objects.numbers()) {
      const bool was_listed = number < walker && std::binary_search(walkers.begin(), walkers.end(), number);
      if (!was_listed && objects.objectReason(walker, number) == PairReason::Checked)
        list_.push_back({ShapeRef::ofObject(std::min(walker, number)), ShapeRef::ofObject(std::max(walker, number))});
    }
  }
  numbers_.reserve(list_.size());
  for (const scene::ShapeRefPair& pair : list_)
    numbers_.emplace(keyOf(pair), static_cast<std::int32_t>(numbers_.size()));
}

std::uint64_t PairNumbers::keyOf(const scene::ShapeRefPair& pair) const {
  const auto root = [this](const ShapeRef& ref) {
    return ref.link >= 0 ? static_cast<std::uint64_t>(ref.link) : links_ + static_cast<std::uint64_t>(ref.object);
  };
  return root(pair.a) << 32 | root(pair.b);
}

std::int32_t PairNumbers::of(const scene::ShapeRefPair& pair) const {
  const auto place = numbers_.find(keyOf(pair));
  return place == numbers_.end() ? -1 : place->second;
}

}  // namespace proximity_server::python
