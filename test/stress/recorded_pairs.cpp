#include "stress/recorded_pairs.h"

#include <cmath>
#include <fstream>
#include <stdexcept>

#include "narrowphase/from_json.h"

namespace proximity_server {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;
using nlohmann::json;

const char* nameOf(Shape::Kind kind) {
  const char* names[] = {"point", "segment", "box", "cylinder", "cone", "ellipsoid", "hull", "sweep"};
  return names[static_cast<std::size_t>(kind)];
}

/// JSON has no word for what is not finite.
json toJson(double number) {
  if (std::isnan(number)) return "nan";
  if (std::isinf(number)) return number > 0.0 ? "inf" : "-inf";
  return number;
}

json toJson(const Vector3d& v) { return {toJson(v.x()), toJson(v.y()), toJson(v.z())}; }

json toJson(const Shape& shape) {
  json j = {{"kind", nameOf(shape.kind())}, {"margin", shape.margin()}};
  if (shape.kind() != Shape::Kind::Hull) {
    j["half_extents"] = toJson(shape.halfExtents());
    return j;
  }
  j["vertices"] = json::array();
  for (const Vector3d& vertex : shape.hull().vertices()) j["vertices"].push_back(toJson(vertex));
  return j;
}

Shape shape(const json& j) {
  const double margin = j.value("margin", 0.0);
  const std::string kind = j["kind"];
  if (kind == "point") return Sphere{margin};
  if (kind == "hull") {
    std::vector<Vector3d> points;
    for (const json& vertex : j["vertices"]) points.push_back(vectorFrom(vertex));
    return Shape(ConvexHull(points)).padded(margin);
  }
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

json toJson(const Options& options) {
  return {{"distance_tolerance", options.distance_tolerance},
          {"max_iterations", options.max_iterations},
          {"stop_above", toJson(options.stop_above)},
          {"stop_below", toJson(options.stop_below)}};
}

Options options(const json& j) {
  return {numberFrom(j["distance_tolerance"]), j["max_iterations"], numberFrom(j["stop_above"]),
          numberFrom(j["stop_below"])};
}

json toJson(const WarmStart& warm_start) {
  json simplex = json::array();
  for (const WarmStart::Pair& pair : warm_start.simplex) simplex.push_back({pair.a, pair.b});
  return {{"axis", toJson(warm_start.axis)},
          {"vertex_a", warm_start.vertex_a},
          {"vertex_b", warm_start.vertex_b},
          {"simplex", simplex},
          {"simplex_size", warm_start.simplex_size}};
}

WarmStart warmStart(const json& j) {
  WarmStart result{vectorFrom(j["axis"]), j["vertex_a"], j["vertex_b"]};
  result.simplex_size = j.value("simplex_size", 0);
  for (std::size_t i = 0; i < result.simplex.size() && j.contains("simplex"); ++i)
    result.simplex[i] = {j["simplex"][i][0], j["simplex"][i][1]};
  return result;
}

}  // namespace

std::string toJsonLine(const RecordedPair& recorded) {
  json j = {{"name", recorded.name},
            {"a", toJson(recorded.pair.a)},
            {"b", toJson(recorded.pair.b)},
            {"a_T_b", toJson(recorded.pair.a_T_b)},
            {"options", toJson(recorded.pair.options)},
            {"warm_start", toJson(recorded.pair.warm_start)}};
  if (recorded.expected) j["expected_signed_distance"] = *recorded.expected;
  return j.dump();
}

RecordedPair fromJsonLine(const std::string& line) {
  const json j = json::parse(line);
  RecordedPair recorded{j["name"], {shape(j["a"]), shape(j["b"]), poseFrom(j["a_T_b"]), {}, {}}, {}};
  if (j.contains("options")) recorded.pair.options = options(j["options"]);
  if (j.contains("warm_start")) recorded.pair.warm_start = warmStart(j["warm_start"]);
  if (j.contains("expected_signed_distance")) recorded.expected = j["expected_signed_distance"];
  return recorded;
}

std::vector<RecordedPair> readRecordedPairs(const std::string& path) {
  std::ifstream file(path);
  if (!file) throw std::runtime_error("cannot read " + path);
  std::vector<RecordedPair> pairs;
  for (std::string line; std::getline(file, line);) pairs.push_back(fromJsonLine(line));
  return pairs;
}

}  // namespace proximity_server
