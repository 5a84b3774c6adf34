#pragma once

namespace proximity_server::scene {

/// Signed distances [m], less the padding of a pair, above which the pairs of a robot shall stay.
struct StopDistances {
  double links = 0.0;    ///< of two links
  double objects = 0.0;  ///< of pairs with an object
};

}  // namespace proximity_server::scene
