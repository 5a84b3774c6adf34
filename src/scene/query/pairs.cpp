#include "proximity_server/scene/query/pairs.h"

namespace proximity_server::scene {

Candidates::Candidates(const PairTable& table) {
  list_.reserve(table.checked.size());
  for (const int index : table.checked) {
    const LinkPair& pair = table.pairs[index];
    list_.push_back({{pair.link_a}, {pair.link_b}});
  }
}

}  // namespace proximity_server::scene
