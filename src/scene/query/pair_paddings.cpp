#include "scene/query/pair_paddings.h"

#include <algorithm>
#include <utility>

namespace proximity_server::scene {

PairPaddings::PairPaddings(const PairTable& table) {
  for (const LinkPair& pair : table.pairs)
    if (pair.padding != 0.0) paddings_.push_back({pair.link_a, pair.link_b, pair.padding});
}

double PairPaddings::of(const ShapeRefPair& pair) const {
  if (paddings_.empty()) return 0.0;
  const auto [a, b] = std::minmax(pair.a.link, pair.b.link);
  const auto found = std::lower_bound(paddings_.begin(), paddings_.end(), std::make_pair(a, b),
                                      [](const Padding& padding, const std::pair<int, int>& links) {
                                        return std::make_pair(padding.link_a, padding.link_b) < links;
                                      });
  return found != paddings_.end() && found->link_a == a && found->link_b == b ? found->value : 0.0;
}

}  // namespace proximity_server::scene
