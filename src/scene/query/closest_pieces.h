#pragma once

#include "proximity_server/scene/query/question.h"
#include "scene/bounds/heap.h"
#include "scene/bounds/leaf_boxes.h"
#include "scene/model/numbers.h"
#include "scene/state/placed_robot.h"

#include <cstdint>
#include <limits>

namespace proximity_server::scene {

/// [m] If a pair is proven to be farther than a distance by this much, Scene finds it beyond that distance, too: the
/// search of Scene ends within the tolerance of 1e-9 m, and its lower bound may be that much below the truth. Twice the
/// tolerance, because of the rounding of the poses.
constexpr double kSettledFor = 2e-9;

inline bool isBeyond(const narrowphase::SignedDistance& result, double limit) { return result.lower_bound > limit; }

/// True if no other pair of pieces can be closer. That is so for an overlap, if the question does not ask for its
/// depth.
bool isFinal(const narrowphase::SignedDistance& result, const Question& question);

/// Subtracts a padding [m] from a distance: both surfaces move outwards by half of it.
narrowphase::SignedDistance padded(narrowphase::SignedDistance result, double padding);

/// Two leaves, by their numbers in their parts; or a leaf of one part and a half-space of the other part.
struct LeafPair {
  int a = -1, b = -1;
  int half_space = -1;  ///< takes the place of b

  bool hasHalfSpace() const { return half_space >= 0; }
  bool areLeaves() const { return b >= 0; }
  bool operator==(const LeafPair& other) const {
    return a == other.a && b == other.b && half_space == other.half_space;
  }
};

/// The closest of the pairs of pieces that were computed, and the bounds that all of them prove together.
struct ClosestPieces {
  LeafPair leaves;                     ///< no leaves if bounds were enough
  narrowphase::SignedDistance result;  ///< in the frame of the body of a
  bool is_beyond = true;               ///< true if it is beyond the limit
  /// [m] of the distance of the closest pieces, whether they were computed or not
  double lower_bound = std::numeric_limits<double>::infinity();
  double upper_bound = std::numeric_limits<double>::infinity();
  narrowphase::Status lower_bound_status = narrowphase::Status::Threshold;

  bool empty() const { return leaves.a < 0; }
  void offer(const LeafPair& pair, const narrowphase::SignedDistance& other, double limit);
  /// Adds what was found among other pairs, with the same limit.
  void add(const ClosestPieces& other);

  /// States that the other pairs are not computed, because their distance [m] is not below this.
  void leaveOut(double lower_bound_of_others);

  /// [m] Pieces that are farther apart than this cannot change the answer.
  double limit(double outer_limit, const Question& question) const;
};

/// The data that a search keeps from earlier answers.
enum class Memory : unsigned char {
  OfAnswers,  ///< the last answer about a pair, and the pieces at which its search ended
  None        ///< no answer: every question is answered like the first one. The places where searches ended are kept
              ///< along edges
};

/// Finds the closest pieces of two parts. It walks the hierarchies of both at the same time, the closest volumes first,
/// and bounds all parts of a WideVolume at once. It serves components, convex parts and triangles, in any mixture.
///
/// Source: Larsen, Gottschalk, Lin, Manocha, Fast Proximity Queries with Swept Sphere Volumes, 1999 (two hierarchies,
///         the closest parts first). Unlike there, the volumes are spheres, then boxes, and GJK measures the leaves.
class PieceSearch {
 public:
  PieceSearch(std::size_t pieces, Skipping skipping, Memory memory = Memory::OfAnswers);

  /// Makes room for the warm starts of so many pieces, of the robot and its objects together.
  void makeRoomFor(std::size_t pieces);

  /// Finds the closest pieces that are closer than `limit` [m]. The pair `guess` is computed first. With
  /// Memory::None its distance only limits the search: among equally close pieces those are found that would be found
  /// without it, if the tolerance is at most the default one. `found` is an earlier result that becomes part of the
  /// answer.
  ClosestPieces between(const PlacedPair& pair, const LeafPair& guess, double limit, const Question& question,
                        const ClosestPieces* found = nullptr);

  /// True if the lower bounds of all pairs of pieces are above the limit [m]. Stops at the first pair whose bound is
  /// not.
  bool areBeyond(const PlacedPair& pair, double limit);

  Skipping skipping() const { return skipping_; }
  Memory memory() const { return memory_; }

 private:
  /// Two volumes, one of each part, in the queue of a search. It is half as large as a Visit, and a search moves
  /// hundreds of them.
  struct VolumePair {
    double lower_bound;   ///< [m] of their signed distance minus the padding
    std::int64_t number;  ///< decides between equal bounds
    int a, b;

    bool operator<(const VolumePair& other) const {
      return lower_bound != other.lower_bound ? lower_bound > other.lower_bound : number > other.number;
    }
  };

  void begin(const PlacedPair& pair, double limit);
  bool areLeaves(const VolumePair& pair) const { return a_[pair.a].isLeaf() && b_[pair.b].isLeaf(); }
  narrowphase::SignedDistance distanceInBodyA(const LeafPair& leaves, const PlacedPair& pair,
                                              const narrowphase::Options& options, Memory start_from);
  void open(const VolumePair& whole, const RelativePose& a_T_b, double limit);
  void pushPairs(const LeafBoxes& a, const LeafBoxes& b, const VolumePair& whole, const RelativePose& a_T_b,
                 double limit);
  double lowestBound() const { return queue_.empty() ? kInfinity : queue_.first().lower_bound; }

  Part a_, b_;  ///< of the pair that the question is about
  const Skipping skipping_;
  const Memory memory_;
  WarmStarts warm_starts_;
  LeafGaps gaps_;
  bool uses_bounds_ = true;
  SearchHeap<VolumePair> queue_;
  std::int64_t pushed_ = 0;  ///< the number of pairs that the search has made so far
  double padding_ = 0.0;     ///< [m]
  double left_out_ = 0.0;    ///< [m] the smallest lower bound of all pairs that were not put into the queue
};

}  // namespace proximity_server::scene
