#pragma once

#include <optional>

#include "narrowphase/gjk_epa/epa.h"
#include "narrowphase/gjk_epa/gjk.h"
#include "narrowphase/gjk_epa/polytope.h"
#include "proximity_server/narrowphase/gjk_epa/query_trace.h"

namespace proximity_server::narrowphase {

// A query tells an observer what it does. The sources that do so (signed_distance.cpp, gjk.cpp, epa.cpp) are compiled
// twice: as they are, with the observer Unobserved, whose calls are empty and leave no machine code; and with
// PROXIMITY_WATCHED defined, with the Recorder. Two instantiations of a template in one compilation would do the same,
// but the compiler would not inline into both what it inlines into one: 0.7 to 3 % more instructions in a query.

/// Watches nothing.
struct Unobserved {
  void reaches(Rung) const {}
  void endsAtFirst(Rung, const SignedDistance&, const CsoVertex&) const {}
  void supports(const GjkResult&, const CsoVertex&) const {}
  void reduces(const Simplex&, const Nearest&, double) const {}
  void begins() const {}
  void tests(const Polytope&, const Polytope::Face&, const CsoVertex&, const EpaResult&) const {}
  void ends(const Polytope&, const EpaResult&, double) const {}
};

/// Writes down what it sees.
class Recorder {
 public:
  /// `trace` is emptied.
  explicit Recorder(QueryTrace& trace) : trace_(&trace) { trace = QueryTrace(); }

  /// The last rung that a query reaches gives its answer.
  void reaches(Rung rung) const { trace_->rung = rung; }

  /// The query ends with this rung, before GJK. The first vertex proves the lower bound of the result along its normal.
  void endsAtFirst(Rung rung, const SignedDistance& result, const CsoVertex& first) const;
  /// GJK has found w along result.normal, and its lower bound is known.
  void supports(const GjkResult& result, const CsoVertex& w) const;
  /// GJK has reduced the simplex with w to what the nearest point needs. `rounding` [m] is that of the CSO.
  void reduces(const Simplex& simplex, const Nearest& nearest, double rounding) const;

  /// EPA begins with a polytope. The steps with a recalled one that led to no answer are forgotten: their faces name
  /// other vertices.
  void begins() const;
  /// EPA has found w along the normal of the closest face, and its lower bound is known, but it has not compared the
  /// depths yet.
  void tests(const Polytope& polytope, const Polytope::Face& closest, const CsoVertex& w,
             const EpaResult& result) const;
  /// EPA ends with this polytope, and does not have the witness points yet unless Newton's method found them.
  /// `depth_inside` [m]: the lower bound by a solid inside of the CSO, or by the search about an axis; -infinity if
  /// none is known.
  void ends(const Polytope& polytope, const EpaResult& result, double depth_inside) const;

 private:
  std::vector<std::array<int, 3>> facesOf(const Polytope& polytope) const;

  QueryTrace* trace_;
};

/// The observer of this compilation. It is passed by value: an empty one needs no register.
#ifdef PROXIMITY_WATCHED
using Observer = Recorder;
#else
using Observer = Unobserved;
#endif

/// gjk() and epa(), observed.
GjkResult gjkObserved(Cso& cso, const Eigen::Vector3d& normal_guess, const CsoVertex& first, const Options& options,
                      Observer observer);
EpaResult epaObserved(Cso& cso, const Simplex& simplex, const Options& options, Observer observer);

/// The depth by EPA, begun with the polytope that the last query of two polytopes has kept, and without GJK. The warm
/// start must have a WarmPolytope. `w` is the vertex of the CSO farthest along the unit vector `normal`. Returns
/// nullopt if no polytope was kept, if it does not surround the origin in the present pose, or if it leads to no
/// answer; then it is not kept any more.
std::optional<EpaResult> epaRecalled(Cso& cso, const Eigen::Vector3d& normal, const CsoVertex& w,
                                     const Options& options, Observer observer);

}  // namespace proximity_server::narrowphase
