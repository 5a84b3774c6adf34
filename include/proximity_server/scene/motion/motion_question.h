#pragma once

#include "proximity_server/scene/model/joint_ranges.h"
#include "proximity_server/scene/query/pair_distances.h"
#include "proximity_server/scene/query/question.h"

#include <limits>
#include <vector>

// The questions about a motion, and its answers.

namespace proximity_server::scene {

/// A contact distance [m] for one pair.
struct PairContactDistance {
  ShapeRefPair pair;
  double contact_distance;
};

struct MotionQuestion {
  /// [m] Contact is a signed distance, minus the pair's padding, at or below this. Below 0, and if one shape of a pair
  /// has a closed mesh with room inside, the time of contact is left open (IterationLimit, t_free 0) unless it is at
  /// the start.
  double contact_distance = 0.0;
  /// If not nullptr, each pair adds its own distance to `contact_distance`. It must live until the question is
  /// answered.
  const PairDistances* thresholds = nullptr;
  /// Pairs that may come nearer than all others, such as pairs that are nearer at the start and must be allowed to move
  /// apart. If a pair has two contact distances, the smaller one counts; with minus infinity the pair is left out. If
  /// one of them is below 0 and its pair has a closed mesh with room inside, the time of contact is left open from the
  /// start on.
  std::vector<PairContactDistance> nearer_pairs{};
  double tolerance = 1e-6;  ///< [m] of the distance at contact, and of the minimum; NaN counts as 0
  Deadline deadline{};
};

/// How the pairs of a question were settled.
struct MotionCounts {
  int pairs = 0;    ///< the pairs of links and objects
  int unknown = 0;  ///< pairs without an answer, because a pose or all geometry is missing
  /// pairs that one bound settled for the whole motion, or that bounds of many objects settled at once
  int by_one_bound = 0;
  int intervals = 0;  ///< examined intervals of time of pairs of volumes, or of a volume and many objects
  int queries = 0;    ///< queries of the narrowphase about one time
};

/// The first contact: the first time at which a robot comes too close to itself or to an object. Times are parameters of
/// the motion.
struct RobotTimeOfContact {
  /// Converged: the answer is complete. IterationLimit (the deadline has passed, or the iterations were used up) and
  /// Degenerate: t_free still holds. Unknown: nothing is known of any pair, or nothing of a pair whose motion
  /// overflows. Degenerate with a `pair` but without contact: from t_free on the tube around a spline may touch, and no
  /// state of it is known that does.
  narrowphase::Status status = narrowphase::Status::Unknown;
  bool contact = false;
  /// Until this time every pair is proven to be above its contact distance, in all states of the tube.
  double t_free = 0.0;
  /// See TimeOfContact. For a tube it may be later than t_free, when the spline itself touches.
  double t_contact = std::numeric_limits<double>::quiet_NaN();
  /// The pair in contact at t_contact, in the frame of the poses; without contact the pair that may touch. Degenerate:
  /// because of rounding, its bounds are wider than the tolerance.
  PairProximity pair;
  Positions state{};  ///< in contact, at t_contact; empty: none, or a motion whose positions are not known
  MotionCounts counts;
};

/// The smallest distance of a robot from itself and from objects. Around a spline the lower bound is the guaranteed
/// distance: no state of the tube is nearer. The upper bound is the distance of a state of the tube. Converged: the
/// guaranteed distance is within the tolerance of what the bounds of the tube allow at one time.
struct RobotMinimum {
  narrowphase::Status status = narrowphase::Status::Unknown;      ///< as in RobotTimeOfContact; the bounds always hold
  double lower_bound = -std::numeric_limits<double>::infinity();  ///< [m] of the smallest signed distance of all pairs
  double upper_bound = std::numeric_limits<double>::infinity();   ///< [m] the distance of `pair` at `time`
  double time = std::numeric_limits<double>::quiet_NaN();         ///< a parameter of the motion
  PairProximity pair;  ///< the closest pair, at `time`, in the frame of the poses; Degenerate as in RobotTimeOfContact
  Positions state{};   ///< the state of `pair`; empty as in RobotTimeOfContact
  MotionCounts counts;
};

}  // namespace proximity_server::scene
