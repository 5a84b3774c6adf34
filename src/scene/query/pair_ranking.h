#pragma once

#include "proximity_server/scene/query/pairs.h"
#include "proximity_server/scene/state/state.h"
#include "scene/query/object_visits.h"
#include "scene/query/pair_measurement.h"
#include "scene/state/link_groups.h"

#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <tuple>
#include <vector>

namespace proximity_server::scene {

/// Finds the closest of many pairs and measures as few of them as it can.
///
/// 1. Measure the pairs that were closest the last time: if little has moved, their distances exclude most other pairs.
/// 2. Put all other pairs into a queue, sorted by the bound of their spheres. Candidates enter by groups of links: one
///    bound of two groups excludes all pairs between them.
/// 3. Take the pair with the smallest bound. If a better bound is found, put the pair back; otherwise measure it. Pairs
///    with objects enter one by one, as soon as a bound from the hierarchy of objects is the smallest.
/// 4. End when the smallest bound in the queue exceeds the k-th smallest distance so far, or the threshold.
///
/// If pairs have thresholds of their own (Question::thresholds), these are subtracted before bounds and distances are
/// compared. Bounds of groups, and of the hierarchy of objects, hold for the largest threshold of all their pairs.
class PairRanking {
 public:
  enum class Goal : unsigned char {
    Closest,          ///< the k closest pairs
    ClosestAndCount,  ///< the k closest pairs, and how many pairs are at or below the threshold, see countBelow
    Any               ///< the first pair found at or below the threshold
  };

  PairRanking(const SceneModel& model, Skipping skipping);

  static constexpr std::size_t kAll = std::numeric_limits<std::size_t>::max();

  const PairCounts& counts() const { return measurement_.counts(); }

  // Each question is about a state of this model.

  /// The number of checked pairs with an object that have no distance because a pose is missing.
  std::int64_t unknownPairsWithObjects(const State& state) {
    see(state);
    return object_visits_.unknownPairs();
  }

  /// See PairMeasurement::interiorOf().
  DistanceBounds interiorOf(const State& state, const ShapeRefPair& pair, double within) {
    see(state);
    return measurement_.interiorOf(pair, within);
  }

  PairProximity one(const State& state, const ShapeRefPair& pair, const Question& question);
  const std::vector<PairProximity>& all(const State& state, const Pairs& pairs, const Question& question);
  const std::vector<PairProximity>& closest(const State& state, const Pairs& pairs, std::size_t k, Goal goal,
                                            const Question& question);
  /// The number of pairs at or below the threshold of the last question, if its goal was ClosestAndCount.
  int countBelow() const { return below_; }

 private:
  void see(const State& state);
  const Objects& objects() const { return *measurement_.robot().objects(); }

  /// The arguments of closest().
  struct Search {
    Search(const Pairs& pairs, std::size_t k, Goal goal, const Question& question, const Objects& objects);

    const Pairs& pairs;
    const bool with_links, with_objects;
    const std::size_t total;  ///< the number of all pairs
    const std::size_t k;      ///< at most all
    const Goal goal;
    const Question& question;
    const double of_links, with_object;  ///< [m] the largest threshold of a pair of links, and of a pair with an object
  };

  /// A pair that the question is about: one of the list, by its place there, or a candidate with an object.
  struct QueriedPair : PartPair {  // of a candidate with an object a < b
    int number;                    ///< in the list; kNotInList of a candidate with an object
    bool isInList() const { return number != kNotInList; }
    bool operator<(const QueriedPair& other) const {
      return std::tie(number, a, b) < std::tie(other.number, other.a, other.b);
    }
  };
  static constexpr int kNotInList = std::numeric_limits<int>::max();

  struct Ranked {
    double rank;
    int number;
    PairProximity proximity;
    bool operator<(const Ranked& other) const { return rank != other.rank ? rank < other.rank : number < other.number; }
  };

  double limit(const Search& search) const;
  QueriedPair inList(int number, const Search& search) const;
  ShapeRefPair refsOf(const QueriedPair& pair, const Search& search) const;
  bool isQueried(const QueriedPair& pair, const Search& search) const {
    return pair.isInList() ? search.with_links : search.with_objects;
  }
  std::optional<Visit> visitOf(const QueriedPair& pair, const Search& search) const;
  void consider(const Visit& visit, const Search& search);
  void considerLikely(const Search& search);
  void enterOthers(const Search& search);
  void enterCandidates(const Search& search);
  void countUnknown(const Search& search);
  void enterObjects(const Search& search);
  void enter(const QueriedPair& pair, const Search& search);
  void openNearby(const Search& search);
  void enterBetween(int group_a, int group_b, const Search& search);
  bool needsOnlyCounting(const Visit& visit, const Search& search) const;
  void visitBestFirst(const Search& search);
  void countTheRest(const Search& search);
  void keepLikely(const Search& search);

  /// A candidate pair of links, which are parts of the same numbers.
  struct Candidate : PartPair {
    double padding;  ///< [m]
  };

  const SceneModel& model_;
  const Skipping skipping_;
  std::vector<Candidate> candidates_;  // of this robot
  PairMeasurement measurement_;
  std::optional<LinkGroups> groups_;  // only used if there are many candidates
  bool groups_fit_ = false;           // true if the groups have the boxes of the latest poses

  ObjectVisits object_visits_;
  std::uint64_t seen_ = 0;  ///< the revision of the last state

  VisitQueue queue_;
  Heap<Ranked> nearest_;                   // the farthest first
  std::vector<QueriedPair> last_nearest_;  // the pairs that were nearest the last time, ascending
  std::vector<PairProximity> results_;
  int below_ = 0;
};

}  // namespace proximity_server::scene
