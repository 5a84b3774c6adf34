#pragma once

#include "scene/bounds/heap.h"
#include "scene/state/part.h"

#include <limits>

namespace proximity_server::scene {

/// A pair that may have to be examined.
struct Visit : PartPair {
  /// How the lower bound was found. Only a Sphere bound can be improved without computing the pair.
  enum class Bound : unsigned char { Sphere, Box, Motion, Rest };
  double lower_bound;  ///< [m] of their signed distance minus the padding
  int number;          ///< decides between equal bounds
  double padding;      ///< [m]
  Bound bound = Bound::Sphere;
  double threshold = 0.0;  ///< [m] the threshold of the pair, which is added to the threshold of the question

  /// [m] How far the lower bound is above the threshold of the pair.
  double excess() const { return lower_bound - threshold; }

  bool operator<(const Visit& other) const {
    return excess() != other.excess() ? excess() > other.excess() : number > other.number;
  }
};

/// A queue of visits, the smallest excess first.
class VisitQueue : public Heap<Visit> {
 public:
  /// [m] The smallest excess; infinity if the queue is empty. If no pair has a threshold of its own, this is the
  /// smallest lower bound.
  double lowestBound() const { return empty() ? std::numeric_limits<double>::infinity() : first().excess(); }
};

}  // namespace proximity_server::scene
