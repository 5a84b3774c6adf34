#include "edit_distance.h"

#include <algorithm>
#include <numeric>
#include <vector>

namespace proximity_server {

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

}  // namespace proximity_server
