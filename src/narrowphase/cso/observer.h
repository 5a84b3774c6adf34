#pragma once

#include "narrowphase/cso/polytope.h"
#include "narrowphase/cso/simplex.h"
#include "proximity_server/narrowphase/cso/query_trace.h"

namespace proximity_server::narrowphase {

// A query tells an observer what it does: signedDistance(), gjk() and epa() are templates of its type, which their
// sources instantiate for both observers. An observer is passed by value: an empty one needs no register, and its calls
// leave no machine code.

/// [m] The bounds of the depth that EPA knows.
struct DepthBounds {
  double lower;
  double upper;  ///< the depth along the shallowest direction; infinite if there is none yet
};

/// An observer that does nothing.
struct Unobserved {
  Unobserved anew() const { return {}; }
  void reaches(Algorithm) const {}
  template <typename First>
  void endsAtFirst(Algorithm, const Eigen::Vector3d&, double, const First&) const {}
  void supports(const CsoVertex&, const Eigen::Vector3d&, double) const {}
  void reduces(const Simplex&, const Nearest&, double) const {}
  void begins() const {}
  void tests(const Polytope&, const Polytope::Face&, const CsoVertex&, const DepthBounds&) const {}
  void ends(const Polytope&, double) const {}
  void endsWithPoints(const Polytope&, const DepthBounds&) const {}
};

/// An observer that records what it sees.
class Recorder {
 public:
  /// `trace` is emptied.
  explicit Recorder(QueryTrace& trace) : trace_(&trace) { trace = QueryTrace(); }

  /// The recorder of a query that is made again: the trace is emptied.
  Recorder anew() const { return Recorder(*trace_); }

  /// The last algorithm that a query reaches gives its answer.
  void reaches(Algorithm algorithm) const { trace_->algorithm = algorithm; }

  /// The query ends with this algorithm, before GJK. The first vertex, which `first` returns, proves the lower bound of
  /// the cores along the normal.
  template <typename First>
  void endsAtFirst(Algorithm algorithm, const Eigen::Vector3d& normal, double lower_bound, const First& first) const {
    reaches(algorithm);
    supports(first(), normal, lower_bound);
  }
  /// GJK has found w along the normal, which proves the lower bound.
  void supports(const CsoVertex& w, const Eigen::Vector3d& normal, double lower_bound) const;
  /// GJK has reduced the simplex with w to what the nearest point needs. `rounding` [m] is the rounding of the CSO.
  void reduces(const Simplex& simplex, const Nearest& nearest, double rounding) const;

  /// EPA begins with a polytope. The steps with a recalled one that led to no answer are forgotten: their faces name
  /// other vertices.
  void begins() const;
  /// EPA has found w along the normal of the closest face. The bounds are those before it compares the depths.
  void tests(const Polytope& polytope, const Polytope::Face& closest, const CsoVertex& w,
             const DepthBounds& bounds) const;
  /// EPA ends with this polytope and depth [m], which is infinite if it knows none.
  void ends(const Polytope& polytope, double depth) const;
  /// After that: Newton's method has found the witness points. The lower bound is that by a solid inside of the CSO, or
  /// by the search about an axis; -infinity if there is none.
  void endsWithPoints(const Polytope& polytope, const DepthBounds& bounds) const;

 private:
  std::vector<std::array<int, 3>> facesOf(const Polytope& polytope) const;

  QueryTrace* trace_;
};

}  // namespace proximity_server::narrowphase
