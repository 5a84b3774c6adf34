#pragma once

#include "proximity_server/narrowphase/query_types.h"
#include "proximity_server/scene/pieces/representation.h"
#include "proximity_server/scene/query/deadline.h"
#include "proximity_server/scene/scene_model/shape_ref.h"

#include <limits>
#include <vector>

// The questions to a scene, and its answers.

namespace proximity_server::scene {

class PairDistances;

/// The answer about two shapes, in the order asked: the signed distance of their closest (or deepest) pieces, minus the
/// padding of the pair of links. The bounds hold for the whole shapes; the normal belongs to these pieces.
///
/// A shape that lies wholly inside a closed mesh, and touches none of its pieces, overlaps it. The depth is then that
/// of a ball inside of the shape: its witness point is not on the surface of the shape, and the normal is the shortest
/// way out for the ball. The depth of the whole shape is not less.
struct PairProximity {
  ShapeRefPair asked;
  /// The closest <collision> of link a, or the closest shape of object a, counted from 1; 0 if bounds were enough.
  int collision_a = 0;
  int collision_b = 0;
  /// In the frame of the poses. Status::Unknown if a pose or all geometry is missing.
  narrowphase::SignedDistance result;
  Representation representation = Representation::Exact;  ///< the less exact one of the two pieces
  /// True if the two overlap and one of them has several pieces. Then the overlap of the whole may be deeper than that
  /// of any two pieces.
  bool depth_is_lower_bound = false;
};

/// Counts how the pairs of a question were settled, in the order in which the steps are tried. `total` is the sum of
/// all others.
struct PairCounts {
  int total = 0;
  int unknown = 0;    ///< a pose or all geometry is missing, the deadline came first, or numbers overflowed
  int at_rest = 0;    ///< the relative pose of the two bodies is the same as in the last computed answer
  int by_motion = 0;  ///< an earlier bound, minus the motion since then, was enough
  int by_bounds = 0;  ///< bounding volumes were enough, or `first` had found a pair before
  int computed = 0;   ///< at least one pair of pieces was computed by the narrowphase
};

/// The pairs at or below a threshold.
struct PairsBelow {
  const std::vector<PairProximity>& closest;  ///< sorted by distance
  int count;                                  ///< the number of all such pairs, whether in the list or not
};

/// The accuracy and the limits of an answer.
struct Question {
  double tolerance = 1e-9;  ///< [m] accepted width of the bounds; NaN counts as 0
  /// [m] For a pair farther than this a proof is enough: the answer has Status::Threshold, its distance is its lower
  /// bound, it has no points, and no normal if bounding volumes were enough. A pair counts as nearer unless its lower
  /// bound proves otherwise.
  double threshold = std::numeric_limits<double>::infinity();
  enum class Depth : unsigned char { Wanted, NotWanted };
  /// With NotWanted an overlap is reported (Status::Threshold) without its depth, any overlap is the minimum, and
  /// points and normal may be missing. If the threshold of a pair is negative, an overlap is one that is as deep.
  Depth depth = Depth::Wanted;
  Deadline deadline{};  ///< a pair that is not computed before it is Unknown
  /// If not nullptr, each pair adds its own distance to `threshold`. Pairs are then sorted by their distance minus
  /// their own threshold, and the pair with the smallest difference counts as the closest. It must live until the
  /// question is answered.
  const PairDistances* thresholds = nullptr;
};

/// Off computes every pair of pieces anew and gives the same answers; it is for tests and measurements.
enum class Skipping : unsigned char { On, Off };

}  // namespace proximity_server::scene
