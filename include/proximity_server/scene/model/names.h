#pragma once

#include <algorithm>
#include <string>
#include <vector>

namespace proximity_server::scene {

// Names of links, joints and groups, and how messages write them.

/// The names of some things, in their order.
template <typename Named>
std::vector<std::string> namesOf(const std::vector<Named>& things) {
  std::vector<std::string> names;
  names.reserve(things.size());
  for (const Named& thing : things) names.push_back(thing.name);
  return names;
}

/// The index of the first thing with that name, or -1.
template <typename Named>
int findNamed(const std::vector<Named>& things, const std::string& name) {
  const auto hit = std::find_if(things.begin(), things.end(), [&](const Named& thing) { return thing.name == name; });
  return hit == things.end() ? -1 : static_cast<int>(hit - things.begin());
}

/// The known name that `name` may mean: the nearest one, if one of the two contains the other, or if the number of edits
/// between them is at most two, or at most a third of the known name, and fewer than the longer one has characters. "" if there
/// is none.
std::string nearestName(const std::string& name, const std::vector<std::string>& known);

/// The smallest number of insertions, deletions and replacements of a character that turn one text into the other
/// (Levenshtein distance).
int editDistance(const std::string& from, const std::string& to);

/// The known name of which `name` is probably a misspelling: the nearest one, if the number of edits between the two is
/// at most two or at most a quarter of its characters. "" if there is none, or if `name` itself is known.
std::string misspelledName(const std::string& name, const std::vector<std::string>& known);

/// The shortest text that gives the same number when it is read: "0.02".
std::string shortest(double number);

/// Returns "name" in quotes.
std::string quoted(const std::string& name);

/// Returns a text like: "name" (did you mean "nearest"?); "name" if none is near.
std::string unknownName(const std::string& name, const std::vector<std::string>& known);

/// Returns the end of a sentence: ": did you mean 'nearest'?"; "" if none is near.
std::string didYouMean(const std::string& name, const std::vector<std::string>& known);

/// The number of items that listed() writes out by default.
constexpr std::size_t kMaxListed = 5;

/// Returns a text like: a, b, c, d, e and 12 more
std::string listed(const std::vector<std::string>& items, std::size_t most = kMaxListed);

}  // namespace proximity_server::scene
