#include "proximity_server/scene/files/file_value.h"
#include "proximity_server/scene/levels/level_thresholds.h"
#include "scene/files/field.h"

#include <string>
#include <vector>

namespace proximity_server::scene {
namespace {

double distanceIn(const Field& field) {
  const double distance = field.number();
  if (distance < 0.0) field.refuse("must not be negative");
  return distance;
}

void read(const Field& file, const std::string& name, double& distance) {
  if (const auto field = file.find(name)) distance = distanceIn(*field);
}

void read(const Field& file, const std::string& name, std::map<std::string, double>& distances) {
  const auto field = file.find(name);
  if (!field) return;
  for (const std::string& key : field->members()) distances[key] = distanceIn(field->member(key));
}

void read(const Field& file, const std::string& name,
          std::vector<std::pair<PairFilterOptions::Names, double>>& distances) {
  const auto field = file.find(name);
  if (!field) return;
  for (const Field& entry : field->entries()) {
    entry.requireMembers({"links", "distance"});
    const Field names = entry.member("links");
    const std::vector<std::string> links = names.texts();
    if (links.size() != 2) names.refuse("must name two links");
    distances.push_back({{links[0], links[1]}, distanceIn(entry.member("distance"))});
  }
}

void readLevel(const Field& file, const std::string& name, PairDistances& defaults, DistanceRules& rules) {
  read(file, name, defaults.links);
  read(file, "object_" + name, defaults.objects);
  read(file, "pair_" + name, rules.of_pairs);
  read(file, "link_" + name, rules.of_links);
  read(file, "group_" + name, rules.of_groups);
}

}  // namespace

ThresholdFile thresholdsFrom(const std::string& yaml, const std::string& source) {
  const FileValue value = readYaml(yaml, source);
  const Field file(value, source);
  std::vector<std::string> names;
  for (const std::string level : {"stop_distance", "warn_distance"})
    for (const std::string of : {"", "object_", "pair_", "link_", "group_"}) names.push_back(of + level);
  file.requireMembers(names);
  ThresholdFile thresholds;
  readLevel(file, "stop_distance", thresholds.defaults.stop, thresholds.rules.stop);
  readLevel(file, "warn_distance", thresholds.defaults.warn, thresholds.rules.warn);
  return thresholds;
}

}  // namespace proximity_server::scene
