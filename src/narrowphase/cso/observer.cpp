#include "narrowphase/cso/observer.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace proximity_server::narrowphase {

using Eigen::Vector3d;

namespace {

/// A step that has found w, and has no simplex yet.
QueryTrace::GjkStep foundVertex(const CsoVertex& w, const Vector3d& normal, double lower_bound) {
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN(), kInfinity = std::numeric_limits<double>::infinity();
  return {normal, w, lower_bound, kInfinity, {}, Vector3d::Constant(kNaN), false};
}

}  // namespace

void Recorder::supports(const CsoVertex& w, const Vector3d& normal, double lower_bound) const {
  QueryTrace::GjkStep step = foundVertex(w, normal, lower_bound);
  if (!trace_->gjk.empty()) {
    const QueryTrace::GjkStep& last = trace_->gjk.back();
    step.upper_bound = last.upper_bound;
    step.simplex = last.simplex;
    step.nearest = last.nearest;
  }
  trace_->gjk.push_back(std::move(step));
}

void Recorder::reduces(const Simplex& simplex, const Nearest& nearest, double rounding) const {
  QueryTrace::GjkStep& step = trace_->gjk.back();
  step.has_progress = true;
  step.simplex.clear();
  for (int place = 0; place < 4; ++place)
    if (simplex.has(place)) step.simplex.push_back(simplex[place]);
  step.nearest = nearest.encloses_origin ? Vector3d::Zero() : Vector3d(-nearest.distance * nearest.normal());
  step.upper_bound = (nearest.encloses_origin ? 0.0 : nearest.distance) + rounding;
}

void Recorder::begins() const {
  trace_->epa.clear();
  trace_->polytope.clear();
}

void Recorder::tests(const Polytope& polytope, const Polytope::Face& closest, const CsoVertex& w,
                     const DepthBounds& bounds) const {
  const Vector3d normal = closest.normal();
  const double depth = std::min(bounds.upper, normal.dot(w.point));
  trace_->epa.push_back({facesOf(polytope), closest.vertices, normal, w, bounds.lower, depth});
}

void Recorder::ends(const Polytope& polytope, double depth) const {
  trace_->final_faces = facesOf(polytope);
  if (!trace_->epa.empty() && std::isfinite(depth)) trace_->epa.back().depth = depth;
}

void Recorder::endsWithPoints(const Polytope& polytope, const DepthBounds& bounds) const {
  const Polytope::Face* closest = polytope.closest();
  const double reach = closest != nullptr ? closest->distance() : bounds.upper;
  reaches(bounds.lower >= reach ? Algorithm::EpaEllipsoid : Algorithm::EpaNewton);
}

/// The faces as indices into trace_->polytope, which receives the vertices that it does not have yet.
std::vector<std::array<int, 3>> Recorder::facesOf(const Polytope& polytope) const {
  std::vector<std::array<int, 3>> faces;
  polytope.forEachFace([&](const Polytope::Face& face) {
    faces.push_back(face.vertices);
    const int last = std::max({face.vertices[0], face.vertices[1], face.vertices[2]});
    while (static_cast<int>(trace_->polytope.size()) <= last)
      trace_->polytope.push_back(polytope.vertex(static_cast<int>(trace_->polytope.size())));
  });
  return faces;
}

}  // namespace proximity_server::narrowphase
