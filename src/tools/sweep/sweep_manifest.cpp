#include "tools/sweep/sweep_manifest.h"

#include "system/whole_file.h"
#include "tools/robot/robot_files.h"
#include "tools/text/naming.h"

#include <stdexcept>

namespace proximity_server::tools {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kSweepKeys[] = {"program", "model", "question", "states", "output", "pairs"};

// A URDF may contain any bytes: those that are not UTF-8 are replaced, because dump() would throw for them.
std::string dumped(const Json& json, int indent = -1) {
  return json.dump(indent, ' ', false, Json::error_handler_t::replace);
}

/// The sweep as it is read back, where bytes that are not UTF-8 were replaced.
Json written(const Json& json) { return Json::parse(dumped(json)); }

void compare(const Json& there, const Json& here, const std::string& name, std::string& text) {
  if (there == here) return;
  if (there.is_object() && here.is_object()) {
    for (const auto& [key, value] : here.items())
      compare(there.contains(key) ? there[key] : Json(), value, name.empty() ? key : name + "." + key, text);
    return;
  }
  text += (text.empty() ? "" : ", ") + name;
  text += here.is_array() ? " differ" : " is " + dumped(there) + " there and " + dumped(here) + " here";
}

}  // namespace

std::string SweepManifest::toText() const {
  Json json = sweep;
  json["range"] = {range.begin, range.end};
  json["rows"] = rows;
  json["bytes"] = bytes;
  json["hash"] = hash;
  json["summary"] = summary.toJson();
  return dumped(json, 1) + "\n";
}

std::string manifestPath(const std::string& file) { return file + ".manifest"; }

SweepManifest readManifest(const std::string& path) {
  return naming(path, [&] {
    try {
      const Json json = Json::parse(readTextFile(path));
      SweepManifest manifest;
      for (const char* key : kSweepKeys) manifest.sweep[key] = json.at(key);
      manifest.range = {json.at("range").at(0), json.at("range").at(1)};
      manifest.rows = json.at("rows");
      manifest.bytes = json.at("bytes");
      manifest.hash = json.at("hash");
      manifest.summary = SweepSummary::fromJson(json.at("summary"));
      if (manifest.range.begin > manifest.range.end || manifest.range.end > manifest.statesOfSweep())
        throw std::invalid_argument("its range is " + textOf(manifest.range));
      return manifest;
    } catch (const nlohmann::json::exception& error) {
      throw std::invalid_argument(std::string("no manifest of a sweep: ") + error.what());
    }
  });
}

void writeManifest(const SweepManifest& manifest, const std::string& file) {
  system::replaceFile(manifestPath(file), manifest.toText());
}

std::string differences(const Json& there, const Json& here) {
  std::string text;
  compare(written(there), written(here), "", text);
  return text;
}

}  // namespace proximity_server::tools
