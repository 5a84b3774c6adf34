#pragma once

#include <cstddef>
#include <vector>

#include "proximity_server/scene/filter/pair_filter.h"
#include "proximity_server/scene/query/question.h"

namespace proximity_server::scene {

/// The candidate pairs of a robot, as whole links, in the order of PairTable::checked.
class Candidates {
 public:
  explicit Candidates(const PairTable& table);

  const std::vector<ShapeRefPair>& list() const { return list_; }
  bool empty() const { return list_.empty(); }
  std::size_t size() const { return list_.size(); }
  const ShapeRefPair& operator[](std::size_t index) const { return list_[index]; }
  std::vector<ShapeRefPair>::const_iterator begin() const { return list_.begin(); }
  std::vector<ShapeRefPair>::const_iterator end() const { return list_.end(); }

 private:
  std::vector<ShapeRefPair> list_;
};

/// The pairs that a question is about: a list of any pairs, or the candidates of the scene's own robot. A scene settles
/// many candidates at once by the groups of their links; the pairs of a list are looked at one by one.
///
/// It refers to what it is made of, which must outlive the question. The candidates of another robot, recognised by their
/// number, are refused with std::invalid_argument.
class Pairs {
 public:
  Pairs(const std::vector<ShapeRefPair>& list) : list_(list) {}                             // NOLINT: implicit
  Pairs(const Candidates& candidates) : list_(candidates.list()), are_candidates_(true) {}  // NOLINT: implicit

  const std::vector<ShapeRefPair>& list() const { return list_; }
  std::size_t size() const { return list_.size(); }
  bool areCandidates() const { return are_candidates_; }

 private:
  const std::vector<ShapeRefPair>& list_;
  bool are_candidates_ = false;
};

}  // namespace proximity_server::scene
