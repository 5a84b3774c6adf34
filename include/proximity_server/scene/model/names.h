#pragma once

#include <algorithm>
#include <string>
#include <vector>

namespace proximity_server::scene {

// Names of links, joints and groups, and how messages write them.

/// The names of the things, in their order.
template <typename Named>
std::vector<std::string> namesOf(const std::vector<Named>& things) {
  std::vector<std::string> names;
  names.reserve(things.size());
  for (const Named& thing : things) names.push_back(thing.name);
  return names;
}

/// Index of the first thing of that name, or -1.
template <typename Named>
int findNamed(const std::vector<Named>& things, const std::string& name) {
  const auto hit = std::find_if(things.begin(), things.end(), [&](const Named& thing) { return thing.name == name; });
  return hit == things.end() ? -1 : static_cast<int>(hit - things.begin());
}

/// The known name nearest to `name` in edit distance ("did you mean ..."); "" if `known` is empty.
std::string nearestName(const std::string& name, const std::vector<std::string>& known);

/// The smallest number of insertions, deletions and replacements of a character that turn one text into the other
/// (Levenshtein distance).
int editDistance(const std::string& from, const std::string& to);

/// The known name that `name` probably is a misspelling of: the nearest one, if it can be made of it by two edits, or by as
/// many as a quarter of its characters; "" if there is none, and if `name` itself is known.
std::string misspelledName(const std::string& name, const std::vector<std::string>& known);

/// The shortest text that is read back as the same number: "0.02".
std::string shortest(double number);

/// "name"
std::string quoted(const std::string& name);

/// "name" (did you mean "nearest"?)
std::string unknownName(const std::string& name, const std::vector<std::string>& known);

/// The number of items that listed() writes out where no other is asked for.
constexpr std::size_t kMaxListed = 5;

/// a, b, c, d, e and 12 more
std::string listed(const std::vector<std::string>& items, std::size_t most = kMaxListed);

}  // namespace proximity_server::scene
