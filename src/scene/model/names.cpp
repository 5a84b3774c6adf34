#include "proximity_server/scene/model/names.h"

#include "system/number_text.h"

#include <algorithm>
#include <numeric>

namespace proximity_server::scene {
namespace {

/// [characters] What comes from outside may be so long that comparing all of it takes minutes. Names have no more.
constexpr std::size_t kMostCompared = 1024;

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
    if (nearest && distance >= smallest) continue;
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
  return quoted(name) + (known.empty() ? "" : " (did you mean " + quoted(nearestName(name, known)) + "?)");
}

}  // namespace proximity_server::scene
