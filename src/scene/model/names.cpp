#include "proximity_server/scene/model/names.h"

#include "system/number_text.h"

#include <algorithm>
#include <numeric>

namespace proximity_server::scene {
namespace {

/// [characters] What comes from outside may be so long that comparing all of it takes minutes. Names have no more.
constexpr std::size_t kMostCompared = 1024;

/// Whether a name may be meant from which `edits` edits lead to the known one.
bool isNear(const std::string& name, const std::string& known, int edits) {
  const auto [shorter, longer] = std::minmax({name.size(), known.size()});
  const bool is_part = shorter > 2 && (name.find(known) != std::string::npos || known.find(name) != std::string::npos);
  const std::size_t most = std::min(std::max<std::size_t>(2, known.size() / 3), std::max<std::size_t>(1, longer) - 1);
  return is_part || edits <= static_cast<int>(most);
}

}  // namespace

int editDistance(const std::string& from, const std::string& to) {
  // row[j]: distance from the part of `from` so far to the first j characters of `to`
  std::vector<int> row(to.size() + 1);
  std::iota(row.begin(), row.end(), 0);
  for (const char character : from) {
    int diagonal = row[0]++;
    for (std::size_t j = 0; j < to.size(); ++j) {
      const int replaced = diagonal + (character == to[j] ? 0 : 1);
      diagonal = row[j + 1];
      row[j + 1] = std::min({replaced, row[j] + 1, diagonal + 1});
    }
  }
  return row.back();
}

std::string nearestName(const std::string& name, const std::vector<std::string>& known) {
  const std::string compared = name.substr(0, kMostCompared);
  const std::string* nearest = nullptr;
  int smallest = 0;
  for (const std::string& other : known) {
    const int distance = editDistance(compared, other);
    if (!isNear(compared, other, distance) || (nearest && distance >= smallest)) continue;
    nearest = &other;
    smallest = distance;
  }
  return nearest ? *nearest : "";
}

std::string misspelledName(const std::string& name, const std::vector<std::string>& known) {
  const std::string nearest = nearestName(name, known);
  const int distance = editDistance(name.substr(0, kMostCompared), nearest),
            most = std::max(2, static_cast<int>(nearest.size() / 4));
  return !nearest.empty() && distance > 0 && distance <= most ? nearest : "";
}

std::string shortest(double number) { return system::shortest(number); }

std::string quoted(const std::string& name) { return "\"" + name + "\""; }

std::string listed(const std::vector<std::string>& items, std::size_t most) {
  std::string text;
  for (std::size_t i = 0; i < std::min(items.size(), most); ++i) text += (i > 0 ? ", " : "") + items[i];
  if (items.size() > most) text += " and " + std::to_string(items.size() - most) + " more";
  return text;
}

std::string unknownName(const std::string& name, const std::vector<std::string>& known) {
  const std::string nearest = nearestName(name, known);
  return quoted(name) + (nearest.empty() ? "" : " (did you mean " + quoted(nearest) + "?)");
}

std::string didYouMean(const std::string& name, const std::vector<std::string>& known) {
  const std::string nearest = nearestName(name, known);
  return nearest.empty() ? "" : ": did you mean '" + nearest + "'?";
}

}  // namespace proximity_server::scene
