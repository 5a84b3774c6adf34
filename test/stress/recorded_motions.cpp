#include "stress/recorded_motions.h"

#include <fstream>
#include <stdexcept>

#include "narrowphase/from_json.h"
#include "stress/shape_json.h"

namespace proximity_server::narrowphase {
namespace {

using nlohmann::json;

json chainJson(const MotionChain& chain) {
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

json questionJson(const ContactOptions& options) {
  return {{"contact_distance", toJson(options.contact_distance)},
          {"tolerance", options.tolerance},
          {"begin", options.begin},
          {"end", options.end},
          {"max_queries", options.max_queries}};
}

ContactOptions questionFrom(const json& j) {
  return {numberFrom(j["contact_distance"]), j["tolerance"], j["begin"], j["end"], j["max_queries"]};
}

}  // namespace

std::string toJsonLine(const RecordedMotion& recorded) {
  const StressMotion& m = recorded.motion;
  const json j = {{"name", recorded.name},
                  {"a", toJson(m.a)},
                  {"a_motion", chainJson(m.a_motion)},
                  {"b", toJson(m.b)},
                  {"b_motion", chainJson(m.b_motion)},
                  {"options", questionJson(m.options)},
                  {"suspects", m.suspects}};
  return j.dump();
}

RecordedMotion motionFromJsonLine(const std::string& line) {
  const json j = json::parse(line);
  return {j["name"],
          {shapeFrom(j["a"]), chainFrom(j["a_motion"]), shapeFrom(j["b"]), chainFrom(j["b_motion"]),
           questionFrom(j["options"]), j["suspects"]}};
}

std::vector<RecordedMotion> readRecordedMotions(const std::string& path) {
  std::ifstream file(path);
  if (!file) throw std::runtime_error("cannot read " + path);
  std::vector<RecordedMotion> motions;
  for (std::string line; std::getline(file, line);) motions.push_back(motionFromJsonLine(line));
  return motions;
}

}  // namespace proximity_server::narrowphase
