#include "proximity_server/narrowphase/shape/convex_hull.h"
#include "proximity_server/narrowphase/shape/support.h"
#include "tools/explain/explanation.h"
#include "tools/explain/vertex_names.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace proximity_server::tools {
namespace {

using Eigen::Vector3d;
using narrowphase::CsoVertex;
using narrowphase::QueryTrace;
using Json = nlohmann::ordered_json;

Json numberJson(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

Json pointJson(const Vector3d& point) {
  return Json::array({numberJson(point.x()), numberJson(point.y()), numberJson(point.z())});
}

/// The answer and the steps; a vertex of the CSO is an index into the list `vertices`.
class StepsJson {
 public:
  explicit StepsJson(const Explanation& explanation)
      : explanation_(explanation),
        names_(explanation.pair),
        margins_(explanation.pair.a.shape.margin() + explanation.pair.b.shape.margin()) {}

  Json json() {
    const narrowphase::SignedDistance& answer = explanation_.answer;
    Json gjk = Json::array(), epa = Json::array(), final_faces = Json::array();
    for (const QueryTrace::GjkStep& step : explanation_.trace.gjk) gjk.push_back(stepJson(step));
    for (const QueryTrace::EpaStep& step : explanation_.trace.epa) epa.push_back(stepJson(step));
    for (const std::array<int, 3>& face : explanation_.trace.final_faces) final_faces.push_back(faceJson(face));
    return {{"a", explanation_.pair.a.description},
            {"b", explanation_.pair.b.description},
            {"margins", margins_},
            {"by", algorithmText(explanation_.trace.algorithm)},
            {"status", statusText(answer.status)},
            {"distance", numberJson(answer.distance)},
            {"lower", numberJson(answer.lower_bound)},
            {"upper", numberJson(answer.upper_bound)},
            {"normal", pointJson(answer.normal)},
            {"point_a", pointJson(answer.point_a)},
            {"point_b", pointJson(answer.point_b)},
            {"unique", answer.unique},
            {"iterations", answer.iterations},
            {"gjk", gjk},
            {"epa", epa},
            {"final_faces", final_faces},
            {"vertices", vertices_}};
  }

 private:
  int vertexJson(const CsoVertex& vertex) {
    const auto found = std::find(points_.begin(), points_.end(), vertex.point);
    const auto index = static_cast<int>(found - points_.begin());
    if (found != points_.end()) return index;
    points_.push_back(vertex.point);
    vertices_.push_back({{"name", names_.nameOf(vertex)},
                         {"point", pointJson(vertex.point)},
                         {"on_a", pointJson(vertex.on_a)},
                         {"on_b", pointJson(vertex.onB())}});
    return index;
  }

  Json faceJson(const std::array<int, 3>& face) {
    Json corners = Json::array();
    for (const int v : face) corners.push_back(vertexJson(explanation_.trace.polytope[v]));
    return corners;
  }

  Json stepJson(const QueryTrace::GjkStep& step) {
    const int w = vertexJson(step.w);
    Json simplex = Json::array();
    for (const CsoVertex& vertex : step.simplex) simplex.push_back(vertexJson(vertex));
    return {{"direction", pointJson(step.normal)},
            {"vertex", w},
            {"simplex", simplex},
            {"has_progress", step.has_progress},
            {"nearest", pointJson(step.nearest)},
            {"lower", numberJson(step.lower_bound - margins_)},
            {"upper", numberJson(step.upper_bound - margins_)}};
  }

  Json stepJson(const QueryTrace::EpaStep& step) {
    Json faces = Json::array();
    for (const std::array<int, 3>& face : step.faces) faces.push_back(faceJson(face));
    return {{"faces", faces},
            {"closest", faceJson(step.closest)},
            {"normal", pointJson(step.normal)},
            {"vertex", vertexJson(step.w)},
            {"lower", numberJson(-step.depth - margins_)},
            {"upper", numberJson(-step.lower_bound - margins_)}};
  }

  const Explanation& explanation_;
  VertexNames names_;
  double margins_;  // [m]
  std::vector<Vector3d> points_;
  Json vertices_ = Json::array();
};

/// Evenly spread over the sphere (Fibonacci's spiral).
std::vector<Vector3d> evenDirections() {
  constexpr int kCount = 2000;
  const double golden_angle = M_PI * (3.0 - std::sqrt(5.0));
  std::vector<Vector3d> directions;
  for (int i = 0; i < kCount; ++i) {
    const double z = 1.0 - (2.0 * i + 1.0) / kCount, radius = std::sqrt(1.0 - z * z);
    directions.emplace_back(radius * std::cos(golden_angle * i), radius * std::sin(golden_angle * i), z);
  }
  return directions;
}

/// The points that a support mapping has in all directions. The vertices of a polytope that these miss are added: while
/// a vertex lies beyond a face of the hull of the others, the face is none of the polytope.
template <typename Support>
std::vector<Vector3d> surfacePoints(const Support& support, bool is_polytope, double rounding) {
  constexpr int kMostRounds = 20;
  std::vector<Vector3d> points;
  for (const Vector3d& direction : evenDirections()) points.push_back(support(direction));
  for (int round = 0; is_polytope && round < kMostRounds; ++round) {
    const narrowphase::ConvexHull hull(points);
    const std::size_t before = points.size();
    for (const std::array<int, 3>& triangle : hull.triangles()) {
      const auto corner = [&](int i) { return hull.vertices()[triangle[i]]; };
      const Vector3d normal = (corner(1) - corner(0)).cross(corner(2) - corner(0)).normalized();
      const Vector3d w = support(normal);
      if (normal.dot(w - corner(0)) > rounding) points.push_back(w);
    }
    if (points.size() == before) break;
  }
  return points;
}

/// A body as its hull: corners and triangles.
Json hullJson(const narrowphase::ConvexHull& hull, bool is_polytope) {
  Json corners = Json::array();
  for (const Vector3d& corner : hull.vertices()) corners.push_back(pointJson(corner));
  return {{"dimension", hull.dimension()},
          {"is_polytope", is_polytope},
          {"points", corners},
          {"triangles", hull.triangles()}};
}

/// A shape with its margin, in the frame of a.
Json shapeJson(const narrowphase::Shape& shape, const Eigen::Isometry3d& a_T_shape, double rounding) {
  const bool is_polytope = shape.isPolytope() && shape.margin() == 0.0;
  const auto support = [&](const Vector3d& direction) -> Vector3d {
    int vertex = 0;
    return supportPoint(shape, direction, vertex) + shape.margin() * direction;
  };
  std::vector<Vector3d> points = surfacePoints(support, is_polytope, rounding);
  for (Vector3d& point : points) point = a_T_shape * point;
  return hullJson(narrowphase::ConvexHull(points), is_polytope);
}

/// The shapes, and the CSO of their cores.
void addSurfaces(const Explanation& explanation, Json& json) {
  const ExplainedPair& pair = explanation.pair;
  const double rounding = csoRounding(pair.a.shape, pair.b.shape, pair.a_T_b), beyond = 16.0 * rounding;
  narrowphase::WarmStart warm_start;
  narrowphase::Cso cso(pair.a.shape, pair.b.shape, pair.a_T_b, rounding, warm_start);
  const auto vertex = [&](const Vector3d& direction) { return cso.vertex(direction).point; };
  std::vector<Vector3d> points = surfacePoints(vertex, cso.isPolytope(), beyond);
  for (const QueryTrace::GjkStep& step : explanation.trace.gjk) points.push_back(step.w.point);
  for (const CsoVertex& corner : explanation.trace.polytope) points.push_back(corner.point);
  Json& surface = json["cso"] = hullJson(narrowphase::ConvexHull(points), cso.isPolytope());
  points.emplace_back(Vector3d::Zero());
  surface["dimension_with_origin"] = narrowphase::ConvexHull(points).dimension();
  surface["named"] = Json::array();
  for (const NamedPoint& point : namedPoints(pair))
    surface["named"].push_back({{"name", point.name}, {"point", pointJson(point.point)}});
  json["shapes"] = {shapeJson(pair.a.shape, Eigen::Isometry3d::Identity(), beyond),
                    shapeJson(pair.b.shape, pair.a_T_b, beyond)};
}

}  // namespace

std::string jsonOf(const Explanation& explanation, CsoSurface surface) {
  Json json = StepsJson(explanation).json();
  if (surface == CsoSurface::Added) addSurfaces(explanation, json);
  return json.dump() + "\n";
}

}  // namespace proximity_server::tools
