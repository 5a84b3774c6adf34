#pragma once

#include <utility>
#include <vector>

namespace proximity_server::system {

/// Appends a thing to a vector and returns its index.
template <typename Thing>
int append(std::vector<Thing>& things, Thing thing) {
  things.push_back(std::move(thing));
  return static_cast<int>(things.size()) - 1;
}

}  // namespace proximity_server::system
