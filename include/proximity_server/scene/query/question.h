#pragma once

#include <chrono>
#include <limits>
#include <vector>

#include "proximity_server/narrowphase/query_types.h"
#include "proximity_server/scene/filter/shape_ref.h"
#include "proximity_server/scene/pieces/representation.h"

// The questions to a scene, and its answers.

namespace proximity_server::scene {

class PairDistances;

/// The answer about two shapes, in the order asked: the signed distance of their closest (or deepest) pieces, less the
/// padding of the pair of links. The bounds hold for the whole shapes; the normal belongs to these pieces.
///
/// What lies wholly inside a closed mesh, and touches none of its pieces, overlaps it: the depth is then that of a ball
/// inside of it, its point is not on its surface, and the normal is the ball's shortest way out. The depth of the whole
/// is not less.
struct PairProximity {
  ShapeRefPair asked;
  /// The <collision> of link a, or the shape of object a, that is closest, counted from 1; 0 if only bounds were needed.
  int collision_a = 0;
  int collision_b = 0;
  /// In the frame of the poses; Status::Unknown if a pose or all geometry is missing.
  narrowphase::SignedDistance result;
  Representation representation = Representation::Exact;  ///< the less exact of the two
  /// True if the two overlap and one of them has several pieces: the overlap of the whole may be deeper than that of
  /// any two pieces.
  bool depth_is_lower_bound = false;
};

/// How many pairs of a question were settled by which step, in the order in which the steps are tried. `total` is the
/// sum of all others.
struct PairCounts {
  int total = 0;
  int unknown = 0;    ///< a pose or all geometry is missing, the deadline came first, or numbers overflow
  int at_rest = 0;    ///< the relative pose of the two bodies is that of their last computed answer
  int by_motion = 0;  ///< an earlier bound, less the motion since then, was enough
  int by_bounds = 0;  ///< bounding volumes were enough, or `first` had found its pair earlier
  int computed = 0;   ///< at least one pair of pieces went to the narrowphase
};

/// Pairs at or below a threshold.
struct PairsBelow {
  const std::vector<PairProximity>& closest;  ///< sorted by distance
  int count;                                  ///< of all such pairs, listed or not
};

/// The accuracy and the limits of an answer.
struct Question {
  double tolerance = 1e-9;  ///< [m] accepted gap between upper and lower bound; NaN counts as 0
  /// [m] For a pair farther than this a proof is enough: Status::Threshold, distance = lower bound, no points, and no
  /// normal if bounding volumes were enough. A pair counts as nearer unless its lower bound proves otherwise.
  double threshold = std::numeric_limits<double>::infinity();
  enum class Depth : unsigned char { Wanted, NotWanted };
  Depth depth = Depth::Wanted;  ///< NotWanted: an overlap is reported (Status::Threshold) without its depth, any of
                                ///< them is the minimum, and points and normal may be missing
  /// A pair that is not computed by then is Unknown.
  std::chrono::steady_clock::time_point deadline = std::chrono::steady_clock::time_point::max();
  /// Each pair adds its own distance to `threshold`; nullptr adds nothing. Pairs are then sorted by their distance less their own, and
  /// the pair with the smallest difference counts as the closest. It has to live until the question is answered.
  const PairDistances* thresholds = nullptr;
};

/// Off computes every pair of pieces anew, with the same answers; it is for tests and measurements.
enum class Skipping : unsigned char { On, Off };

}  // namespace proximity_server::scene
