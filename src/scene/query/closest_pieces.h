#pragma once

#include <limits>

#include "proximity_server/scene/query/question.h"
#include "scene/bounds/leaf_boxes.h"
#include "scene/parts/placed_robot.h"
#include "scene/parts/visit_queue.h"

namespace proximity_server::scene {

inline bool isBeyond(const narrowphase::SignedDistance& result, double limit) { return result.lower_bound > limit; }

/// Whether no other pair of pieces can be closer: an overlap if the question does not ask for its depth.
bool isFinal(const narrowphase::SignedDistance& result, const Question& question);

/// The distance less a padding [m]: both surfaces moved outwards by half of it.
narrowphase::SignedDistance padded(narrowphase::SignedDistance result, double padding);

/// Two leaves, by their numbers in their parts; or a leaf and a half-space of the other.
struct LeafPair {
  int a = -1, b = -1;
  int half_space = -1;  ///< in place of b

  static LeafPair withHalfSpace(int a, int half_space) { return {a, -1, half_space}; }
  bool hasHalfSpace() const { return half_space >= 0; }
  bool areLeaves() const { return b >= 0; }
  bool operator==(const LeafPair& other) const {
    return a == other.a && b == other.b && half_space == other.half_space;
  }
};

/// The closest of the pairs of pieces that were computed, and what all of them prove together.
struct ClosestPieces {
  LeafPair leaves;  ///< none if bounds were enough
  narrowphase::SignedDistance result;
  bool is_beyond = true;                                         ///< the limit
  double lower_bound = std::numeric_limits<double>::infinity();  ///< of the closest, whichever it is
  double upper_bound = std::numeric_limits<double>::infinity();
  narrowphase::Status lower_bound_status = narrowphase::Status::Threshold;

  bool empty() const { return leaves.a < 0; }
  void offer(const LeafPair& pair, const narrowphase::SignedDistance& other, double limit);

  /// Others are not computed, as their distance [m] is not below this.
  void leaveOut(double lower_bound_of_others);

  /// [m] A pair of pieces farther apart than this cannot change the answer.
  double limit(double outer_limit, const Question& question) const;
};

/// What is known of earlier answers.
enum class Memory : unsigned char {
  OfAnswers,  ///< the last answer about a pair, and where the search of its pieces ended
  None        ///< nothing: every answer is that of the first question
};

/// Finds the closest pieces of two parts: walks their hierarchies at once, the closest parts first; or bounds all their
/// pieces at once, if these are few. The one query of components, convex parts and triangles, in any mixture.
///
/// Source: Larsen, Gottschalk, Lin, Manocha, Fast Proximity Queries with Swept Sphere Volumes, 1999 (two hierarchies,
///         the closest parts first); here with spheres, then boxes, and GJK at the leaves.
class PieceSearch {
 public:
  PieceSearch(const PlacedRobot& robot, std::size_t pieces, Skipping skipping, Memory memory = Memory::OfAnswers);

  /// Remembers more warm starts, for so many pieces of robot and objects together.
  void makeRoomFor(std::size_t pieces);

  /// Finds the closest pieces that are closer than `limit` [m]. The pair `likely` is computed first, as a guess. If
  /// something is found already, it is part of the answer.
  ClosestPieces between(const Visit& pair, const RelativePose& a_T_b, const LeafPair& likely, double limit,
                        const Question& question, const ClosestPieces* found = nullptr);

  /// Whether the lower bounds of all pieces are above the limit [m]. It ends with the first that is not.
  bool areBeyond(const Visit& pair, const RelativePose& a_T_b, double limit);

 private:
  void begin(const Visit& pair, const RelativePose& a_T_b, double limit);
  bool isLeaf(const Visit& visit) const { return a_[visit.a].isLeaf() && b_[visit.b].isLeaf(); }
  narrowphase::SignedDistance distance(const LeafPair& leaves, const Visit& pair, const RelativePose& a_T_b,
                                       const narrowphase::Options& options);
  Visit withBoxes(Visit visit, const RelativePose& a_T_b) const;
  void split(const Visit& visit, const RelativePose& a_T_b, double limit);

  const PlacedRobot& robot_;
  Part a_, b_;  ///< of the pair that is asked about
  const Skipping skipping_;
  const Memory memory_;
  WarmStarts warm_starts_;
  LeafGaps gaps_;
  VisitQueue queue_;
  int visits_ = 0;
  double left_out_ = 0.0;  ///< [m] the smallest lower bound of the pairs that never entered the queue
};

}  // namespace proximity_server::scene
