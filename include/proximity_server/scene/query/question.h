#pragma once

#include <chrono>
#include <limits>
#include <vector>

#include "proximity_server/narrowphase/query_types.h"
#include "proximity_server/scene/pieces/representation.h"

// What is asked of a scene, and what is answered.

namespace proximity_server::scene {

/// A link, or one of its <collision> elements.
struct ShapeRef {
  int link = -1;
  int collision = 0;  ///< n-th <collision> of the link, counted from 1; 0 = the whole link
};
struct ShapeRefPair {
  ShapeRef a, b;
};

/// What is known about two subjects, in the order asked: the signed distance of their closest (or deepest) pieces,
/// less the padding of the pair of links. The bounds are those of the whole subjects, the normal that of these pieces.
struct PairProximity {
  ShapeRefPair asked;
  int collision_a = 0;  ///< the <collision> of a that is closest, counted from 1; 0 where nothing was computed
  int collision_b = 0;
  narrowphase::SignedDistance
      result;  ///< in the frame of the poses; Status::Unknown where a pose or all geometry is missing
  Representation representation = Representation::Exact;  ///< the less exact of the two
  /// Two that overlap, of which one has several pieces: the whole may be deeper than its deepest pieces are.
  bool depth_is_lower_bound = false;
};

/// How the pairs of a question were settled: total is the sum of the others, in the order in which they are tried.
struct PairCounts {
  int total = 0;
  int unknown = 0;    ///< a pose or all geometry is missing, or the deadline came first
  int at_rest = 0;    ///< the two bodies stand to each other as they did when their answer was computed
  int by_motion = 0;  ///< a bound of before, less the motion since, was enough
  int by_bounds = 0;  ///< bounds about bodies and pieces were enough, or `first` had its answer before
  int computed = 0;   ///< at least one pair of pieces went to the narrowphase
};

/// Pairs at or below a threshold.
struct PairsBelow {
  const std::vector<PairProximity>& closest;  ///< sorted by distance
  int count;                                  ///< of all, listed or not
};

/// How exactly to answer.
struct Question {
  double tolerance = 1e-9;  ///< [m] accepted gap between upper and lower bound
  /// [m] beyond this signed distance only the proof is wanted (Status::Threshold, distance = lower bound, no points,
  /// and no normal either where bounds were enough). A pair counts as nearer unless its lower bound proves otherwise.
  double threshold = std::numeric_limits<double>::infinity();
  enum class Depth : unsigned char { Wanted, NotWanted };
  Depth depth = Depth::Wanted;  ///< NotWanted: an overlap is reported (Status::Threshold) without its depth, any of
                                ///< them is the minimum, and points and normal may be missing
  /// A pair that would have to be computed after it is Unknown.
  std::chrono::steady_clock::time_point deadline = std::chrono::steady_clock::time_point::max();
};

/// Off is for tests and measurements: every pair of pieces is computed anew, with the same answers.
enum class Skipping : unsigned char { On, Off };

}  // namespace proximity_server::scene
