#pragma once

#include <stdexcept>
#include <string>

namespace proximity_server::tools {

/// Calls `act` and returns its result. An std::invalid_argument of it gets the name of the file, or of another place,
/// in front: "NAME: error", unless it has that already.
template <typename Act>
auto naming(const std::string& name, const Act& act) {
  try {
    return act();
  } catch (const std::invalid_argument& error) {
    const std::string what = error.what(), begin = name + ": ";
    if (what.compare(0, begin.size(), begin) == 0) throw;
    throw std::invalid_argument(begin + what);
  }
}

}  // namespace proximity_server::tools
