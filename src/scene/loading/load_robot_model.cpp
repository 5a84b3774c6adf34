#include "proximity_server/scene/loading/load_robot_model.h"

#include "proximity_server/scene/model/names.h"
#include "scene/loading/kinematic_tree.h"
#include "scene/loading/link_geometry.h"
#include "scene/loading/urdf_document.h"

namespace proximity_server::scene {
namespace {

/// The value of a link: its own, or the default.
double valueOf(const std::string& link, const std::map<std::string, double>& own_values, double default_value) {
  const auto own = own_values.find(link);
  return own == own_values.end() ? default_value : own->second;
}

std::string seenOnlyText(const FromVisual& visuals) {
  return kSeenOnly + std::string(", as they have no <collision>: ") + std::to_string(visuals.only_seen.size()) +
         " of " + std::to_string(visuals.seen) + " links with a <visual>: " + listed(visuals.only_seen) +
         ". The parameter collision_from_visual makes them count.";
}

}  // namespace

double ModelOptions::paddingOf(const std::string& link) const { return valueOf(link, link_padding, default_padding); }

double ModelOptions::meshToleranceOf(const std::string& link) const {
  return valueOf(link, link_mesh_tolerance, mesh_tolerance);
}

RobotModel loadRobotModel(const std::string& urdf_xml, const MeshResolver& resolve, const ModelOptions& options) {
  RobotModel model;
  FromVisual visuals{options.collision_from_visual};
  const urdf::ModelInterfaceSharedPtr urdf = readUrdf(urdf_xml, visuals, model.warnings);
  model.name = urdf->getName();
  model.robots.front().urdf_name = model.name;
  addKinematicTree(*urdf, options, model);
  requireLinks(options, model);
  addGeometry(*urdf, resolve, options, visuals, model);
  if (!visuals.only_seen.empty()) model.warnings.push_back(seenOnlyText(visuals));
  return model;
}

}  // namespace proximity_server::scene
