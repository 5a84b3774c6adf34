#pragma once

#include <algorithm>
#include <limits>
#include <vector>

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
};

/// Visits by their excess, the smallest first.
class VisitQueue {
 public:
  void reserve(std::size_t size) { heap_.reserve(size); }
  void clear() { heap_.clear(); }
  bool empty() const { return heap_.empty(); }

  void push(const Visit& visit) {
    heap_.push_back(visit);
    std::push_heap(heap_.begin(), heap_.end(), Later{});
  }

  Visit pop() {
    std::pop_heap(heap_.begin(), heap_.end(), Later{});
    const Visit first = heap_.back();
    heap_.pop_back();
    return first;
  }

  const std::vector<Visit>& remaining() const { return heap_; }

  /// [m] The smallest excess, which is the smallest lower bound where no pair has a threshold of its own; infinity if the queue
  /// is empty.
  double lowestBound() const {
    return heap_.empty() ? std::numeric_limits<double>::infinity() : heap_.front().excess();
  }

 private:
  struct Later {  // a type, so that the heap calls no function for each comparison
    bool operator()(const Visit& a, const Visit& b) const {
      return a.excess() != b.excess() ? a.excess() > b.excess() : a.number > b.number;
    }
  };

  std::vector<Visit> heap_;
};

}  // namespace proximity_server::scene
