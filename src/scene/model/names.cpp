#include "proximity_server/scene/model/names.h"

#include <algorithm>
#include <charconv>
#include <numeric>

namespace proximity_server::scene {

int editDistance(const std::string& from, const std::string& to) {
  std::vector<int> row(to.size() + 1);  // row[j]: distance from the part of `from` so far to the first j of `to`
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
  const std::string* nearest = nullptr;
  int least = 0;
  for (const std::string& other : known) {
    const int distance = editDistance(name, other);
    if (nearest && distance >= least) continue;
    nearest = &other;
    least = distance;
  }
  return nearest ? *nearest : "";
}

std::string shortest(double number) {
  char text[32];
  return {text, std::to_chars(text, text + sizeof text, number).ptr};
}

std::string quoted(const std::string& name) { return "\"" + name + "\""; }

std::string listed(const std::vector<std::string>& items) {
  std::string text;
  for (std::size_t i = 0; i < std::min(items.size(), kMaxListed); ++i) text += (i > 0 ? ", " : "") + items[i];
  if (items.size() > kMaxListed) text += " and " + std::to_string(items.size() - kMaxListed) + " more";
  return text;
}

std::string unknownName(const std::string& name, const std::vector<std::string>& known) {
  return quoted(name) + (known.empty() ? "" : " (did you mean " + quoted(nearestName(name, known)) + "?)");
}

}  // namespace proximity_server::scene
