#pragma once

#include <string>
#include <vector>

#include "proximity_server/scene/filter/scene_model.h"

namespace proximity_server::scene {

/// The robot with its pairs, see filterPairs(), and one more warning: the checked pairs that one joint moves against
/// each other, but that are in contact all over its range. That is nearly always an overlap of the model itself.
///
/// Failure: throws as filterPairs() does.
SceneModel makeSceneModel(RobotModel robot, const std::string& srdf_xml, const PairFilterOptions& options = {});

/// The same with an SRDF for each of RobotModel::robots.
SceneModel makeSceneModel(RobotModel robot, const std::vector<std::string>& srdf_xmls,
                          const PairFilterOptions& options = {});

}  // namespace proximity_server::scene
