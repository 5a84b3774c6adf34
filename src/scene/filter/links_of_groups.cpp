#include "proximity_server/scene/filter/links_of_groups.h"

#include "proximity_server/scene/filter/pair_filter.h"
#include "proximity_server/scene/model/names.h"

#include <algorithm>
#include <stdexcept>

namespace proximity_server::scene {

ModelOptions withLinksOfGroups(ModelOptions options, const std::vector<NamedUrdf>& robots,
                               const std::vector<std::string>& srdf_xmls) {
  const std::vector<std::string> names = options.collision_from_visual;
  const auto is_all = [](const std::string& name) { return name == kAllLinks; };
  if (std::all_of(names.begin(), names.end(), is_all)) return options;
  options.collision_from_visual.clear();
  ModelOptions quick = options;
  quick.allow_missing_meshes = true;
  quick.progress = nullptr;
  const MeshResolver no_mesh = [](const std::string& uri) -> std::string { throw std::invalid_argument(uri); };
  const RobotModel model = loadRobots(robots, no_mesh, quick);
  for (const std::string& name : names) {
    if (is_all(name) || model.findLink(name) >= 0) {
      options.collision_from_visual.push_back(name);
      continue;
    }
    const std::vector<bool> moved = bodiesMovedBy(
        model, srdf_xmls, name, "collision_from_visual: no link " + unknownName(name, namesOf(model.links)));
    for (const Link& link : model.links)
      if (moved[link.body]) options.collision_from_visual.push_back(link.name);
  }
  return options;
}

}  // namespace proximity_server::scene
