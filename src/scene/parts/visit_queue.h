#pragma once

#include <limits>

#include "scene/bounds/heap.h"

namespace proximity_server::scene {

/// A pair of volumes that may have to be examined, see Volumes.
struct Visit {
  /// The origin of the lower bound. After any but Sphere only computing can improve it.
  enum class Bound : unsigned char { Sphere, Box, Motion, Rest };
  double lower_bound;  ///< [m] of their signed distance less the padding
  int number;          ///< decides between equal bounds
  int a, b;
  double padding;  ///< [m]
  Bound bound = Bound::Sphere;
  double threshold = 0.0;  ///< [m] what the pair adds to that of the question

  /// [m] By how much the lower bound is above the threshold of the pair.
  double excess() const { return lower_bound - threshold; }

  bool operator<(const Visit& other) const {
    return excess() != other.excess() ? excess() > other.excess() : number > other.number;
  }
};

/// Visits by their excess, the smallest first.
class VisitQueue : public Heap<Visit> {
 public:
  /// [m] The smallest excess, which is the smallest lower bound where no pair has a threshold of its own; infinity if the queue
  /// is empty.
  double lowestBound() const { return empty() ? std::numeric_limits<double>::infinity() : first().excess(); }
};

}  // namespace proximity_server::scene
