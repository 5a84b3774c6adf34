#pragma once

#include "proximity_server/scene/filter/pair_filter.h"
#include "proximity_server/scene/objects/objects.h"
#include "proximity_server/scene/query/question.h"

#include <cstddef>
#include <vector>

namespace proximity_server::scene {

/// The candidate pairs of a robot, as pairs of whole links, in the order of PairTable::checked.
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

/// The kind of candidates that a question is about: pairs of two links, pairs with an object, or both.
enum class PairKind : unsigned char { Any, OfLinks, WithObject };

/// The pairs that a question is about: a list of any pairs, or the candidates of the scene's own robot together with
/// all checked pairs with the scene's objects (see Objects). A scene settles many candidates at once by groups of links
/// and by a hierarchy of the objects; it examines the pairs of a list one by one.
///
/// It refers to the list or the candidates, which must outlive the question.
/// Failure: a scene throws std::invalid_argument for the candidates of another robot, recognised by their number.
class Pairs {
 public:
  Pairs(const std::vector<ShapeRefPair>& list) : list_(list) {}                             // NOLINT: implicit
  Pairs(const Candidates& candidates) : list_(candidates.list()), are_candidates_(true) {}  // NOLINT: implicit
  Pairs(const Candidates& candidates, PairKind kind) : list_(candidates.list()), are_candidates_(true), kind_(kind) {}

  /// If these are the candidates, the list holds no pairs with objects.
  const std::vector<ShapeRefPair>& list() const { return list_; }
  std::size_t size() const { return list_.size(); }
  bool areCandidates() const { return are_candidates_; }
  PairKind kind() const { return kind_; }

  /// includeLinks(): true if the pairs of the list belong to the question. includeObjects(): true if the checked pairs
  /// with objects do; nullptr: there are no objects.
  bool includeLinks() const { return kind_ != PairKind::WithObject; }
  bool includeObjects(const Objects* objects) const {
    return are_candidates_ && kind_ != PairKind::OfLinks && objects && !objects->empty();
  }

 private:
  const std::vector<ShapeRefPair>& list_;
  bool are_candidates_ = false;
  PairKind kind_ = PairKind::Any;
};

}  // namespace proximity_server::scene
