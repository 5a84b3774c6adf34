#include "stress/shape_json.h"

#include <cmath>
#include <stdexcept>
#include <string>
#include <vector>

#include "narrowphase/from_json.h"

namespace proximity_server::narrowphase {

using Eigen::Isometry3d;
using Eigen::Vector3d;
using nlohmann::json;

namespace {

const char* nameOf(Shape::Kind kind) {
  const char* names[] = {"point", "segment", "box", "cylinder", "cone", "ellipsoid", "hull", "sweep"};
  return names[static_cast<std::size_t>(kind)];
}

}  // namespace

json toJson(double number) {
  if (std::isnan(number)) return "nan";
  if (std::isinf(number)) return number > 0.0 ? "inf" : "-inf";
  return number;
}

json toJson(const Vector3d& v) { return {toJson(v.x()), toJson(v.y()), toJson(v.z())}; }

json toJson(const Shape& shape) {
  json j = {{"kind", nameOf(shape.kind())}, {"margin", shape.margin()}};
  if (shape.kind() == Shape::Kind::Sweep) {
    j["swept"] = toJson(shape.sweep().shape.padded(shape.margin()));
    j["end"] = toJson(shape.sweep().end);
    return j;
  }
  if (shape.kind() != Shape::Kind::Hull) {
    j["half_extents"] = toJson(shape.halfExtents());
    return j;
  }
  j["vertices"] = json::array();
  for (const Vector3d& vertex : shape.hull().vertices()) j["vertices"].push_back(toJson(vertex));
  return j;
}

Shape shapeFrom(const json& j) {
  const double margin = j.value("margin", 0.0);
  const std::string kind = j["kind"];
  if (kind == "point") return Sphere{margin};
  if (kind == "hull") {
    std::vector<Vector3d> points;
    for (const json& vertex : j["vertices"]) points.push_back(vectorFrom(vertex));
    return Shape(ConvexHull(points)).padded(margin);
  }
  if (kind == "sweep") return shapeFrom(j["swept"]).sweptTo(poseFrom(j["end"]));
  const Vector3d half = vectorFrom(j["half_extents"]);
  if (kind == "segment") return Capsule{margin, 2.0 * half.z()};
  if (kind == "box") return Shape(Box{2.0 * half}).padded(margin);
  if (kind == "cylinder") return Shape(Cylinder{half.x(), 2.0 * half.z()}).padded(margin);
  if (kind == "cone") return Shape(Cone{half.x(), 2.0 * half.z()}).padded(margin);
  if (kind == "ellipsoid") return Shape(Ellipsoid{half}).padded(margin);
  throw std::runtime_error("no shape is a " + kind);
}

json toJson(const Isometry3d& pose) {
  json rows = json::array();
  for (int row = 0; row < 3; ++row) rows.push_back({pose(row, 0), pose(row, 1), pose(row, 2), pose(row, 3)});
  return rows;
}

}  // namespace proximity_server::narrowphase
