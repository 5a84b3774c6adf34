#pragma once

#include <string>

namespace proximity_server {

/// Fewest insertions, deletions and replacements of a character that turn one text into the other (Levenshtein).
int editDistance(const std::string& from, const std::string& to);

}  // namespace proximity_server
