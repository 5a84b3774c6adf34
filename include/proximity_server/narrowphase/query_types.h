#pragma once

#include <Eigen/Core>
#include <array>
#include <limits>

#include "proximity_server/narrowphase/shape/eigen_alignment.h"

// What is asked of a pair of convex shapes, and what is answered.

namespace proximity_server::narrowphase {

enum class Status : unsigned char {
  Unknown = 0,     ///< not evaluated: no number of the result is valid
  Converged,       ///< upper_bound - lower_bound <= options.distance_tolerance
  Threshold,       ///< the bounds decided options.stop_above or stop_below; the search ended early
  IterationLimit,  ///< the bounds hold, but are wider than the tolerance
  Degenerate,      ///< no further progress in double precision; the bounds hold, but are wider than the tolerance
};

struct Options {
  double distance_tolerance = 1e-9;  ///< [m] accepted gap between upper and lower bound
  int max_iterations = 500;          ///< of GJK, and again of EPA (whose storage ends there)

  /// The cheaper questions. The search ends with Status::Threshold as soon as
  ///   lower_bound > stop_above   (nobody asks how far), or
  ///   upper_bound <= stop_below  (nobody asks how near or deep).
  double stop_above = std::numeric_limits<double>::infinity();   ///< [m]
  double stop_below = -std::numeric_limits<double>::infinity();  ///< [m]

  /// Is the signed distance above `threshold` [m]? lower_bound > threshold: yes, upper_bound <= threshold: no.
  static Options above(double threshold) {
    Options options;
    options.stop_above = options.stop_below = threshold;
    return options;
  }
  /// Only the distance of shapes that are apart: an overlap is reported as such, without its depth.
  static Options apart() {
    Options options;
    options.stop_below = 0.0;
    return options;
  }
};

/// How far apart two convex shapes are, with the proof.
///
/// Sign:      distance > 0 apart, < 0 overlapping (minus the penetration depth).
/// Invariant: point_b = point_a + distance * normal, |normal| = 1, a towards b, also in overlap: moving b by
///            -distance * normal makes the shapes touch.
///            lower_bound <= truth <= upper_bound whatever the status. `normal` proves lower_bound: no point of a
///            lies further along it than lower_bound short of any point of b. Apart, the points prove upper_bound.
/// Points:    lie on the shapes within the tolerance. NaN, with has_points false, where the search ended before it
///            had any: an overlap without depth, a bound that needed no point.
struct SignedDistance {
  Status status = Status::Unknown;
  double distance = std::numeric_limits<double>::quiet_NaN();
  double lower_bound = -std::numeric_limits<double>::infinity();
  double upper_bound = std::numeric_limits<double>::infinity();
  Eigen::Vector3d point_a = Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());
  Eigen::Vector3d point_b = Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());
  Eigen::Vector3d normal = Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());
  bool has_points = false;
  bool unique = true;  ///< false: parallel faces, concentric, ...: normal or points are one choice of many
  int iterations = 0;  ///< of GJK and EPA together; 0 for a closed form
};

/// What a query leaves behind for the next one of the same two shapes. Any value is legal, a good one saves
/// iterations; the default starts cold.
struct WarmStart {
  Eigen::Vector3d axis = Eigen::Vector3d::Zero();  ///< separating axis, a's frame, a towards b; 0: none
  int vertex_a = 0;                                ///< last support vertex of a hull, a box or a segment
  int vertex_b = 0;
  struct Pair {
    int a, b;
  };
  std::array<Pair, 3> simplex{};  ///< vertices whose differences were nearest to the origin, of two polytopes
  int simplex_size = 0;
};

}  // namespace proximity_server::narrowphase
