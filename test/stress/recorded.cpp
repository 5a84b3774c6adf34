#include "stress/recorded.h"

#include "narrowphase/from_json.h"

#include <nlohmann/json.hpp>

#include <cmath>
#include <fstream>
#include <stdexcept>

namespace proximity_server::narrowphase {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;
using nlohmann::json;

constexpr const char* kKinds[] = {"point", "segment", "box", "cylinder", "cone", "ellipsoid", "hull", "sweep"};

json toJson(double number) {
  if (std::isnan(number)) return "nan";
  if (std::isinf(number)) return number > 0.0 ? "inf" : "-inf";
  return number;
}

json toJson(const Vector3d& v) { return {toJson(v.x()), toJson(v.y()), toJson(v.z())}; }

json toJson(const Isometry3d& pose) {
  json rows = json::array();
  for (int row = 0; row < 3; ++row) rows.push_back({pose(row, 0), pose(row, 1), pose(row, 2), pose(row, 3)});
  return rows;
}

json toJson(const Shape& shape) {
  json j = {{"kind", kKinds[static_cast<std::size_t>(shape.kind())]}, {"margin", shape.margin()}};
  if (shape.kind() == Shape::Kind::Sweep) {
    j["swept"] = toJson(shape.sweep().shape.padded(shape.margin()));
    j["end"] = toJson(shape.sweep().end);
  } else if (shape.kind() == Shape::Kind::Hull) {
    j["vertices"] = json::array();
    for (const Vector3d& vertex : shape.hull().vertices()) j["vertices"].push_back(toJson(vertex));
  } else {
    j["half_extents"] = toJson(shape.halfExtents());
  }
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

json toJson(const Options& options) {
  return {{"distance_tolerance", options.distance_tolerance},
          {"max_iterations", options.max_iterations},
          {"stop_above", toJson(options.stop_above)},
          {"stop_below", toJson(options.stop_below)}};
}

Options optionsFrom(const json& j) {
  return {numberFrom(j["distance_tolerance"]), j["max_iterations"], numberFrom(j["stop_above"]),
          numberFrom(j["stop_below"])};
}

json toJson(const WarmStart& warm_start) {
  json simplex = json::array();
  for (const WarmStart::Pair& pair : warm_start.simplex) simplex.push_back({pair.a, pair.b});
  return {{"axis", toJson(warm_start.axis)}, {"simplex", simplex}, {"simplex_size", warm_start.simplex_size}};
}

WarmStart warmStartFrom(const json& j) {
  WarmStart result{vectorFrom(j["axis"])};
  result.simplex_size = j.value("simplex_size", 0);
  for (std::size_t i = 0; i < result.simplex.size() && j.contains("simplex"); ++i)
    result.simplex[i] = {j["simplex"][i][0], j["simplex"][i][1]};
  return result;
}

json toJson(const MotionChain& chain) {
  json screws = json::array();
  for (const ScrewMotion& screw : chain)
    screws.push_back(
        {{"start", toJson(screw.start)}, {"linear", toJson(screw.linear)}, {"angular", toJson(screw.angular)}});
  return screws;
}

MotionChain chainFrom(const json& screws) {
  MotionChain chain;
  for (const json& j : screws)
    chain.push_back({poseFrom(j["start"]), vectorFrom(j["linear"]), vectorFrom(j["angular"])});
  return chain;
}

json toJson(const ContactOptions& options) {
  return {{"contact_distance", toJson(options.contact_distance)},
          {"tolerance", options.tolerance},
          {"begin", options.begin},
          {"end", options.end},
          {"max_queries", options.max_queries}};
}

ContactOptions contactOptionsFrom(const json& j) {
  return {numberFrom(j["contact_distance"]), j["tolerance"], j["begin"], j["end"], j["max_queries"]};
}

template <class Recorded>
std::vector<Recorded> readLines(const std::string& file, Recorded (*read)(const std::string& line)) {
  const std::string path = PROXIMITY_SOURCE_DIR "/test/data/" + file;
  std::ifstream stream(path);
  if (!stream) throw std::runtime_error("cannot read " + path);
  std::vector<Recorded> all;
  for (std::string line; std::getline(stream, line);) all.push_back(read(line));
  return all;
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
  if (recorded.most_iterations) j["most_iterations"] = *recorded.most_iterations;
  return j.dump();
}

std::string toJsonLine(const RecordedMotion& recorded) {
  const StressMotion& m = recorded.motion;
  const json j = {{"name", recorded.name},          {"a", toJson(m.a)},
                  {"a_motion", toJson(m.a_motion)}, {"b", toJson(m.b)},
                  {"b_motion", toJson(m.b_motion)}, {"options", toJson(m.options)},
                  {"suspects", m.suspects}};
  return j.dump();
}

RecordedPair pairFromJsonLine(const std::string& line) {
  const json j = json::parse(line);
  RecordedPair recorded{j["name"], {shapeFrom(j["a"]), shapeFrom(j["b"]), poseFrom(j["a_T_b"]), {}, {}}, {}, {}};
  if (j.contains("options")) recorded.pair.options = optionsFrom(j["options"]);
  if (j.contains("warm_start")) recorded.pair.warm_start = warmStartFrom(j["warm_start"]);
  if (j.contains("expected_signed_distance")) recorded.expected = j["expected_signed_distance"];
  if (j.contains("most_iterations")) recorded.most_iterations = j["most_iterations"];
  return recorded;
}

RecordedMotion motionFromJsonLine(const std::string& line) {
  const json j = json::parse(line);
  return {j["name"],
          {shapeFrom(j["a"]), chainFrom(j["a_motion"]), shapeFrom(j["b"]), chainFrom(j["b_motion"]),
           contactOptionsFrom(j["options"]), j["suspects"]}};
}

std::vector<RecordedPair> readRecordedPairs() { return readLines("recorded_pairs.jsonl", pairFromJsonLine); }
std::vector<RecordedMotion> readRecordedMotions() { return readLines("recorded_motions.jsonl", motionFromJsonLine); }

}  // namespace proximity_server::narrowphase
