#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "proximity_server/scene/filter/scene_model.h"
#include "proximity_server/scene/model/kinematics.h"
#include "proximity_server/scene/query/question.h"
#include "scene/query/closest_pieces.h"
#include "scene/query/link_groups.h"
#include "scene/query/pair_memory.h"
#include "scene/query/placed_robot.h"
#include "scene/query/visit_queue.h"

namespace proximity_server::scene {

/// What the last computation of a pair of subjects may be good for, later.
struct KeptAnswer {
  RelativePose a_T_b;
  PairProximity proximity;  ///< in the frame of a
  LeafPair leaves;
};

/// Answers questions about pairs of subjects, and computes only what it must. From the cheapest bound to the dearest:
/// spheres; the answer of before, less the motion since; boxes; the narrowphase. The pairs are visited best first.
class PairSearch {
 public:
  enum class Goal : unsigned char {
    Nearest,
    NearestOfAll,  ///< and how many there are at or below the threshold, see countBelow
    Any
  };

  PairSearch(const SceneModel& model, std::shared_ptr<const Volumes> volumes, Skipping skipping);

  /// The pairs that are checked, as whole links. Where these are asked about by reference, many are settled at once.
  const std::vector<ShapeRefPair>& candidates() const { return candidates_; }

  void update(const BodyPoses& poses);
  const PairCounts& counts() const { return counts_; }

  PairProximity one(const ShapeRefPair& pair, const Question& question);
  const std::vector<PairProximity>& all(const std::vector<ShapeRefPair>& pairs, const Question& question);
  const std::vector<PairProximity>& closest(const std::vector<ShapeRefPair>& pairs, std::size_t k, Goal goal,
                                            const Question& question);
  /// Of the last question, for Goal::NearestOfAll.
  int countBelow() const { return below_; }

 private:
  struct PairPadding {
    int link_a, link_b;  ///< link_a < link_b
    double padding;      ///< [m]
  };
  /// What `closest` is about.
  struct Search {
    const std::vector<ShapeRefPair>& pairs;
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

  double paddingOf(const ShapeRefPair& pair) const;
  std::optional<Visit> visitOf(const ShapeRefPair& pair, int number) const;
  Visit refined(Visit visit, double limit);
  PairProximity settle(const ShapeRefPair& pair, const Question& question);
  PairProximity measure(const ShapeRefPair& pair, const Visit& visit, double limit, const Question& question);
  std::optional<PairProximity> answerAtRest(const Visit& visit, const RelativePose& a_T_b, const Question& question);
  PairProximity compute(const Visit& visit, const RelativePose& a_T_b, double limit, const Question& question);
  PairProximity proof(const Visit& visit) const;
  PairProximity asAsked(const ShapeRefPair& pair, const Visit& visit, PairProximity proximity) const;
  int& countOf(Visit::Bound bound);

  double limit(const Search& search) const;
  void consider(const Visit& visit, const Search& search);
  void considerLikely(const Search& search);
  void enterOthers(const Search& search);
  void enter(int number, const Search& search);
  void enterBetween(int group_a, int group_b, const Search& search);
  bool needsOnlyCounting(const Visit& visit, const Search& search) const;
  void visitBestFirst(const Search& search);

  const SceneModel& model_;
  const Skipping skipping_;
  PlacedRobot robot_;
  PieceSearch pieces_;
  PairMemory<KeptAnswer> kept_;
  std::vector<PairPadding> paddings_;
  std::vector<ShapeRefPair> candidates_;
  std::optional<LinkGroups> groups_;  // of many candidates
  bool groups_fit_ = false;           // the poses

  VisitQueue queue_;
  std::vector<Ranked> nearest_;  // a heap, the farthest in front
  std::vector<int> likely_;      // numbers of the pairs that were nearest the last time, ascending
  std::vector<PairProximity> results_;
  PairCounts counts_;
  int below_ = 0;
};

}  // namespace proximity_server::scene
