#pragma once

#include "proximity_server/narrowphase/shape/eigen_alignment.h"

#include <Eigen/Core>

#include <array>
#include <cstdint>
#include <limits>

// The question about a pair of convex shapes, and the answer.

namespace proximity_server::narrowphase {

/// A tolerance as it is used: one that is negative or NaN counts as 0.
inline double usableTolerance(double tolerance) { return tolerance > 0.0 ? tolerance : 0.0; }

enum class Status : unsigned char {
  Unknown = 0,     ///< not evaluated; no number of the result is valid
  Converged,       ///< upper_bound - lower_bound <= options.distance_tolerance
  Threshold,       ///< the bounds decided options.stop_above or stop_below; the search ended early
  IterationLimit,  ///< the bounds hold, but are wider than the tolerance, or no points were found
  Degenerate,      ///< no further progress in double precision; otherwise as IterationLimit
};

/// How far the digits of an answer may depend on the warm start.
enum class Repeatability : unsigned char {
  WithinTolerance,
  /// Two polytopes apart whose nearest features are nearer than all others beyond rounding have the same answer to the
  /// last bit, but for iterations, and for a bound that decides a threshold. Features are vertices, edges and triangles;
  /// a face that has more corners, as a box has, is none, and a sweep has none. Two boxes may have other last
  /// digits in any case. A search without a warm start takes up to a sixth longer.
  OfClearFeatures,
  /// Every answer is the same to the last bit, but for iterations, and for the bound that proves a distance above
  /// stop_above by more than the tolerance. A warm start serves only to find such a bound, or where OfClearFeatures makes
  /// the same promise. With max_iterations of about 12 or fewer a search may end before, and answers may differ.
  Always
};

struct Options {
  double distance_tolerance = 1e-9;  ///< [m] accepted width of the bounds; NaN counts as 0
  int max_iterations = 500;          ///< of GJK, and of EPA; EPA's storage holds no more

  /// Thresholds that make a query cheaper. The search ends with Status::Threshold as soon as
  ///   lower_bound > stop_above   (the shapes are far enough apart; how far does not matter), or
  ///   upper_bound <= stop_below  (the shapes are too close; how close does not matter).
  double stop_above = std::numeric_limits<double>::infinity();   ///< [m]
  double stop_below = -std::numeric_limits<double>::infinity();  ///< [m]

  Repeatability repeatability = Repeatability::WithinTolerance;

  /// Asks whether the signed distance is above `threshold` [m]: it is if lower_bound > threshold, and it is not if
  /// upper_bound <= threshold.
  static Options above(double threshold) {
    Options options;
    options.stop_above = options.stop_below = threshold;
    return options;
  }
  /// Asks for the distance of shapes that are apart; an overlap is reported without its depth.
  static Options apart() {
    Options options;
    options.stop_below = 0.0;
    return options;
  }
};

/// Signed distance of two convex shapes, with proven bounds.
///
/// Sign:      distance > 0 apart, < 0 overlapping (minus the penetration depth).
/// Invariant: point_b = point_a + distance * normal, |normal| = 1, a towards b, also in overlap: moving b by
///            -distance * normal makes the shapes touch.
///            lower_bound <= true distance <= upper_bound for every status. `normal` proves lower_bound: along it,
///            every point of b lies at least lower_bound beyond every point of a. If the shapes are apart, the points
///            prove upper_bound.
/// Points:    lie on the shapes within the tolerance. They are NaN, with has_points false, if the search ended before
///            it had found any: an overlap without depth, or a bound that needed no point. Status Converged has points.
struct SignedDistance {
  Status status = Status::Unknown;
  double distance = std::numeric_limits<double>::quiet_NaN();
  double lower_bound = -std::numeric_limits<double>::infinity();
  double upper_bound = std::numeric_limits<double>::infinity();
  Eigen::Vector3d point_a = Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());
  Eigen::Vector3d point_b = Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());
  Eigen::Vector3d normal = Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());
  bool has_points = false;
  bool unique = true;  ///< false: normal or points are one choice of many (parallel faces, concentric shapes, ...)
  int iterations = 0;  ///< of GJK and EPA together; 0 for a closed form
};

class WarmPolytope;

/// The state at the end of one query, from which the next query of the same two shapes begins. Every value is legal; a
/// good one saves iterations. The default is to begin without knowledge.
struct WarmStart {
  Eigen::Vector3d axis = Eigen::Vector3d::Zero();  ///< separating axis, a's frame, a towards b; 0: none
  struct Pair {
    int a, b;
  };
  std::array<Pair, 3> simplex{};  ///< the last simplex of GJK, by vertex numbers; only of two polytopes
  int simplex_size = 0;
  WarmPolytope* polytope = nullptr;  ///< where EPA keeps its polytope for the next query; nullptr: nowhere
};

/// The polytope with which EPA ended, by the vertex numbers of two polytopes. A series of queries of two hulls in
/// overlap that gives one to its WarmStart needs hardly any expansions. It may come from other shapes or another pose:
/// the next query proves that its surface surrounds the origin, or begins without it.
///
/// It is for programs that follow single pairs in overlap, step by step. It is kept outside of WarmStart, as it takes
/// 3 kB, and most pairs never overlap: neither the scene nor MovingPair has any. It belongs to the caller, must outlive
/// the queries, and must not be shared by threads.
/// Evidence: with 16 of them in a scene, its minimum took 14 % fewer instructions (median; from 37 % fewer to 0.2 %
/// more) on Panda, UR5 and PR2 in contact, in steps of 1 ms, and up to 0.4 % more without contact. But depths got other
/// last digits, and of equally deep directions another one: ten recorded answers changed.
class WarmPolytope {
 public:
  static constexpr int kMaxVertices = 96, kMaxFaces = 2 * kMaxVertices - 4;  ///< a larger polytope is not kept

  int vertexCount() const { return vertex_count_; }
  int faceCount() const { return face_count_; }  ///< 0: nothing is kept
  void forget() { vertex_count_ = face_count_ = 0; }

 private:
  friend class Polytope;  // writes closed surfaces only, so that recall() need not look for their edges again
  struct Triangle {
    std::array<std::uint16_t, 3> vertices;  // counter-clockwise from outside
    std::array<std::uint16_t, 3> twins;     // 4 * face + edge: the same edge in the neighbour, in the other direction
  };
  int vertex_count_ = 0;
  int face_count_ = 0;
  int cold_vertices_ = 0;  // of the last polytope that was begun anew
  std::array<WarmStart::Pair, kMaxVertices> vertices_;
  std::array<Triangle, kMaxFaces> faces_;
};

}  // namespace proximity_server::narrowphase
