#include "proximity_server/scene/configuration/robot_config.h"

#include "proximity_server/scene/inequalities/joint_inequalities.h"
#include "proximity_server/scene/model/names.h"
#include "proximity_server/scene/pieces/convex_pieces.h"

#include <stdexcept>
#include <utility>
#include <variant>

namespace proximity_server::scene {

std::string contradictionIn(const LevelDistances& distances) {
  const auto contradiction = [](const std::string& kind, double stop, double warn) {
    if (stop <= warn) return std::string();
    return kind + "stop_distance is " + shortest(stop) + ", above " + kind + "warn_distance, which is " +
           shortest(warn) + ": the level WARN comes before STOP";
  };
  const std::string of_links = contradiction("", distances.stop_distance, distances.warn_distance);
  if (!of_links.empty()) return of_links;
  const std::string of_objects =
      contradiction("object_", distances.object_stop_distance, distances.object_warn_distance);
  if (!of_objects.empty()) return of_objects;
  const std::string of_tracked =
      contradiction("tracked_", distances.tracked_stop_distance, distances.tracked_warn_distance);
  if (!of_tracked.empty()) return of_tracked;
  return contradiction("sensed_", distances.sensed_stop_distance, distances.sensed_warn_distance);
}

void assignDefaults(LevelThresholds& thresholds, const LevelDistances& distances) {
  thresholds.stop.links = distances.stop_distance;
  thresholds.stop.objects = distances.object_stop_distance;
  thresholds.warn.links = distances.warn_distance;
  thresholds.warn.objects = distances.object_warn_distance;
}

void RobotConfig::useMeshCache() { model.mesh_cache = mesh_cache == "user" ? userMeshCache() : mesh_cache; }

MeshResolver RobotConfig::meshResolver(const std::string& folder) const {
  std::vector<std::string> roots = mesh_roots;
  for (std::string& root : rosPackagePath()) roots.push_back(std::move(root));
  return withinRoots(packageResolver(roots, folder), allowed_mesh_roots);
}

void RobotConfig::setInequalities(RobotModel& robot) const {
  const std::string source = "parameter joint_inequalities";
  const auto* const path = std::get_if<std::string>(&joint_inequalities.content);
  if (!path) return setJointInequalities(joint_inequalities, source, robot);
  if (path->empty()) return;
  if (path->front() != '/') throw std::invalid_argument(source + " is '" + *path + "', no absolute path");
  readJointInequalities(*path, robot);
}

Uncertainty RobotConfig::uncertaintyOf(const RobotModel& robot, const std::string& source) const {
  return uncertaintyFrom(FileValue{FileValue::Map{{"joint_uncertainty", uncertainty.joint},
                                                  {"joint_frame_uncertainty", uncertainty.joint_frame},
                                                  {"base_uncertainty", uncertainty.base},
                                                  {"object_uncertainty", uncertainty.object},
                                                  {"link_uncertainty", uncertainty.link}}},
                         source, robot);
}

LevelThresholds RobotConfig::thresholdsOf(const RobotModel& robot, const std::vector<std::string>& srdf_xmls,
                                          const LevelDistances& defaults) const {
  LevelThresholds assigned;
  assignDefaults(assigned, defaults);
  return levelThresholds(robot, srdf_xmls, thresholds, assigned);
}

}  // namespace proximity_server::scene
