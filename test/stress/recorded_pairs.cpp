#include "stress/recorded_pairs.h"

#include <fstream>
#include <stdexcept>

#include "narrowphase/from_json.h"
#include "stress/shape_json.h"

namespace proximity_server::narrowphase {
namespace {

using nlohmann::json;

json optionsJson(const Options& options) {
  return {{"distance_tolerance", options.distance_tolerance},
          {"max_iterations", options.max_iterations},
          {"stop_above", toJson(options.stop_above)},
          {"stop_below", toJson(options.stop_below)}};
}

Options options(const json& j) {
  return {numberFrom(j["distance_tolerance"]), j["max_iterations"], numberFrom(j["stop_above"]),
          numberFrom(j["stop_below"])};
}

json warmStartJson(const WarmStart& warm_start) {
  json simplex = json::array();
  for (const WarmStart::Pair& pair : warm_start.simplex) simplex.push_back({pair.a, pair.b});
  return {{"axis", toJson(warm_start.axis)}, {"simplex", simplex}, {"simplex_size", warm_start.simplex_size}};
}

WarmStart warmStart(const json& j) {
  WarmStart result{vectorFrom(j["axis"])};
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
            {"options", optionsJson(recorded.pair.options)},
            {"warm_start", warmStartJson(recorded.pair.warm_start)}};
  if (recorded.expected) j["expected_signed_distance"] = *recorded.expected;
  if (recorded.most_iterations) j["most_iterations"] = *recorded.most_iterations;
  return j.dump();
}

RecordedPair fromJsonLine(const std::string& line) {
  const json j = json::parse(line);
  RecordedPair recorded{j["name"], {shapeFrom(j["a"]), shapeFrom(j["b"]), poseFrom(j["a_T_b"]), {}, {}}, {}, {}};
  if (j.contains("options")) recorded.pair.options = options(j["options"]);
  if (j.contains("warm_start")) recorded.pair.warm_start = warmStart(j["warm_start"]);
  if (j.contains("expected_signed_distance")) recorded.expected = j["expected_signed_distance"];
  if (j.contains("most_iterations")) recorded.most_iterations = j["most_iterations"];
  return recorded;
}

std::vector<RecordedPair> readRecordedPairs(const std::string& path) {
  std::ifstream file(path);
  if (!file) throw std::runtime_error("cannot read " + path);
  std::vector<RecordedPair> pairs;
  for (std::string line; std::getline(file, line);) pairs.push_back(fromJsonLine(line));
  return pairs;
}

}  // namespace proximity_server::narrowphase
