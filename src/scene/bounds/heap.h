#pragma once

#include <algorithm>
#include <vector>

namespace proximity_server::scene {

/// A std::priority_queue, the largest first, that can reserve memory and lets the caller read all its elements.
template <typename Thing>
class Heap {
 public:
  void reserve(std::size_t size) { things_.reserve(size); }
  void clear() { things_.clear(); }
  bool empty() const { return things_.empty(); }
  std::size_t size() const { return things_.size(); }
  const Thing& first() const { return things_.front(); }

  void push(const Thing& thing) {
    things_.push_back(thing);
    std::push_heap(things_.begin(), things_.end());
  }

  Thing pop() {
    std::pop_heap(things_.begin(), things_.end());
    const Thing first = things_.back();
    things_.pop_back();
    return first;
  }

  const std::vector<Thing>& all() const { return things_; }

  /// All elements, the smallest first. Afterwards nothing can be pushed before clear().
  const std::vector<Thing>& sorted() {
    std::sort_heap(things_.begin(), things_.end());
    return things_;
  }

 private:
  std::vector<Thing> things_;
};

/// A Heap for searches whose next element often is the largest of those that were pushed since the last pop: this one
/// waits beside the heap.
template <typename Thing>
class SearchHeap {
 public:
  void reserve(std::size_t size) { others_.reserve(size); }
  void clear() {
    others_.clear();
    has_largest_ = false;
  }
  bool empty() const { return !has_largest_ && others_.empty(); }
  const Thing& first() const { return has_largest_ ? largest_ : others_.first(); }

  void push(const Thing& thing) {
    if (!empty() && thing < first()) return others_.push(thing);
    if (has_largest_) others_.push(largest_);
    largest_ = thing;
    has_largest_ = true;
  }

  Thing pop() {
    if (!has_largest_) return others_.pop();
    has_largest_ = false;
    return largest_;
  }

 private:
  Heap<Thing> others_;
  Thing largest_{};           ///< not smaller than all others
  bool has_largest_ = false;  ///< false: the largest one is the first of the others
};

}  // namespace proximity_server::scene
