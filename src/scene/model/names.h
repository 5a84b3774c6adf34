#pragma once

#include <string>
#include <vector>

namespace proximity_server::scene {

// How messages speak of the names of links, joints and groups; nearestName() is in robot_model.h.

/// Fewest insertions, deletions and replacements of a character that turn one text into the other (Levenshtein).
int editDistance(const std::string& from, const std::string& to);

/// "name"
std::string quoted(const std::string& name);

/// "name" (did you mean "nearest"?)
std::string unknownName(const std::string& name, const std::vector<std::string>& known);

/// What listed() lists.
constexpr std::size_t kMostListed = 5;

/// a, b, c, d, e and 12 more
std::string listed(const std::vector<std::string>& items);

}  // namespace proximity_server::scene
