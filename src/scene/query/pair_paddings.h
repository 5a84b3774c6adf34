#pragma once

#include <vector>

#include "proximity_server/scene/filter/pair_filter.h"
#include "proximity_server/scene/query/question.h"

namespace proximity_server::scene {

/// The paddings of pairs of links, see LinkPair::padding. Most robots have none, and then a look-up costs nothing.
class PairPaddings {
 public:
  explicit PairPaddings(const PairTable& table);

  /// [m] Taken off the distance of a pair, in either order.
  double of(const ShapeRefPair& pair) const;

 private:
  struct Padding {
    int link_a, link_b;  ///< link_a < link_b
    double value;        ///< [m] not 0
  };
  std::vector<Padding> paddings_;  ///< sorted by links
};

}  // namespace proximity_server::scene
