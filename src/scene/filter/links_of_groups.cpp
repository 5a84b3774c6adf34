#include "proximity_server/scene/filter/links_of_groups.h"

#include "proximity_server/scene/filter/pair_filter.h"
#include "proximity_server/scene/model/names.h"

#include <stdexcept>
#include <utility>

namespace proximity_server::scene {

ModelOptions withLinksOfGroups(ModelOptions options, const std::vector<NamedUrdf>& robots,
                               const std::vector<std::string>& srdf_xmls) {
  const std::vector<std::string> names = std::exchange(options.collision_from_visual, {});
  if (names.empty()) return options;
  ModelOptions quick = options;
  quick.allow_missing_meshes = true;
  quick.progress = nullptr;
  const MeshResolver no_mesh = [](const std::string& uri) -> std::string { throw std::invalid_argument(uri); };
  const RobotModel model = loadRobots(robots, no_mesh, quick);
  for (const std::string& name : names) {
    if (name == kAllLinks || model.findLink(name) >= 0) {
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
