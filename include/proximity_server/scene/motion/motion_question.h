#pragma once

#include <chrono>
#include <limits>
#include <vector>

#include "proximity_server/scene/query/pair_distances.h"
#include "proximity_server/scene/query/question.h"

// The questions about a motion, and its answers.

namespace proximity_server::scene {

/// A contact distance [m] that one pair has for itself.
struct PairContactDistance {
  ShapeRefPair pair;
  double contact_distance;
};

struct MotionQuestion {
  /// [m] Contact is a signed distance, less the pair's padding, at or below it. Below 0, a first contact of two of which
  /// one has a closed mesh with room inside is left open (IterationLimit, t_free 0) unless it is at the start.
  double contact_distance = 0.0;
  /// Each pair adds its own distance to `contact_distance`; nullptr adds nothing. It has to live until the question is answered.
  const PairDistances* thresholds = nullptr;
  /// Pairs that may come nearer than all others, as those that are nearer at the start and shall be allowed to part. Of two
  /// contact distances of a pair the smaller one counts; with minus infinity the pair is left out. If one of them is below 0
  /// and its pair has a closed mesh with room inside, a first contact is left open from the start on.
  std::vector<PairContactDistance> nearer_pairs{};
  double tolerance = 1e-6;  ///< [m] of that distance, and of the minimum; NaN counts as 0
  std::chrono::steady_clock::time_point deadline = std::chrono::steady_clock::time_point::max();
};

/// How the pairs of a question were settled.
struct MotionCounts {
  int pairs = 0;    ///< of links and objects
  int unknown = 0;  ///< of these, pairs without an answer because a pose or all geometry is missing
  int by_one_bound =
      0;  ///< of these, pairs that one bound settled for the whole motion, or bounds of many objects at once
  int intervals = 0;  ///< pairs of volumes, or of a volume and many objects, and intervals of time that were examined
  int queries = 0;    ///< of the narrowphase, at one time
};

/// When a robot comes too close to itself, or to an object, for the first time.
struct RobotContact {
  /// Converged: complete. IterationLimit (the deadline has passed, or the iterations were used up) and Degenerate:
  /// t_free still holds. Unknown: nothing is known of any pair, or of one whose motion overflows.
  narrowphase::Status status = narrowphase::Status::Unknown;
  bool contact = false;
  /// Until this time every pair is proven to be above its contact distance.
  double t_free = 0.0;
  /// See TimeOfContact.
  double t_contact = std::numeric_limits<double>::quiet_NaN();
  /// The pair in contact at t_contact, in the frame of the poses. Degenerate: rounding makes its bounds wider than the tolerance.
  PairProximity pair;
  MotionCounts counts;
};

/// How close a robot comes to itself and to objects.
struct RobotMinimum {
  narrowphase::Status status = narrowphase::Status::Unknown;      ///< as in RobotContact; the bounds always hold
  double lower_bound = -std::numeric_limits<double>::infinity();  ///< [m] of the smallest signed distance of all
  double upper_bound = std::numeric_limits<double>::infinity();   ///< [m] the distance of `pair` at `time`
  double time = std::numeric_limits<double>::quiet_NaN();
  PairProximity pair;  ///< the closest pair, at `time`, in the frame of the poses; Degenerate as in RobotContact
  MotionCounts counts;
};

}  // namespace proximity_server::scene
