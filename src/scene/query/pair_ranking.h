#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "proximity_server/scene/query/pairs.h"
#include "scene/query/link_groups.h"
#include "scene/query/pair_measurement.h"

namespace proximity_server::scene {

/// Finds the closest of many pairs, and measures as few of them as it can.
///
/// 1. The pairs that were closest the last time are measured first: where little has moved they leave little to do.
/// 2. All others enter a queue by the bound of their spheres; candidates enter by groups of links, so that a bound of
///    two groups leaves out all of their pairs.
/// 3. The pair with the smallest bound is taken. A better bound puts it back, or it is measured.
/// 4. The search ends when the next bound exceeds the k-th smallest distance so far, or the threshold.
class PairRanking {
 public:
  enum class Goal : unsigned char {
    Closest,          ///< the k closest pairs
    ClosestAndCount,  ///< and how many pairs are at or below the threshold, see countBelow
    Any               ///< the first pair found at or below the threshold
  };

  PairRanking(const SceneModel& model, std::shared_ptr<const Volumes> volumes, Skipping skipping);

  void update(const BodyPoses& poses);
  const PairCounts& counts() const { return measurement_.counts(); }

  PairProximity one(const ShapeRefPair& pair, const Question& question);
  const std::vector<PairProximity>& all(const Pairs& pairs, const Question& question);
  const std::vector<PairProximity>& closest(const Pairs& pairs, std::size_t k, Goal goal, const Question& question);
  /// Of the last question, for Goal::ClosestAndCount.
  int countBelow() const { return below_; }

 private:
  /// What `closest` is about.
  struct Search {
    const Pairs& pairs;
    const std::size_t k;
    const Goal goal;
    const Question& question;
  };
  struct Ranked {
    double rank;
    int number;
    PairProximity proximity;
    bool operator<(const Ranked& other) const { return rank != other.rank ? rank < other.rank : number < other.number; }
  };

  double limit(const Search& search) const;
  void consider(const Visit& visit, const Search& search);
  void considerLikely(const Search& search);
  void enterOthers(const Search& search);
  void enter(int number, const Search& search);
  void enterBetween(int group_a, int group_b, const Search& search);
  bool needsOnlyCounting(const Visit& visit, const Search& search) const;
  void visitBestFirst(const Search& search);
  void countTheRest(const Search& search);

  const Skipping skipping_;
  const std::size_t candidate_count_;  // of this robot
  PairMeasurement measurement_;
  std::optional<LinkGroups> groups_;  // of many candidates
  bool groups_fit_ = false;           // the poses

  VisitQueue queue_;
  std::vector<Ranked> nearest_;  // a heap, the farthest in front
  std::vector<int> likely_;      // numbers of the pairs that were nearest the last time, ascending
  std::vector<PairProximity> results_;
  int below_ = 0;
};

}  // namespace proximity_server::scene
