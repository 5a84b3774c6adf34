#pragma once

#include "proximity_server/scene/loading/joined_robots.h"
#include "proximity_server/scene/loading/model_options.h"

#include <string>
#include <vector>

namespace proximity_server::scene {

/// The options for loadRobots(), in which each SRDF group of ModelOptions::collision_from_visual is replaced by its
/// links: those that move when the joints of the group do, see bodiesMovedBy(). There is an SRDF for each robot; groups
/// have names like "left/arm" if the robots have names. A name of both a link and a group means the link.
///
/// Failure: throws std::invalid_argument for a name that is neither, and as loadRobots() and filterPairs() do.
ModelOptions withLinksOfGroups(ModelOptions options, const std::vector<NamedUrdf>& robots,
                               const std::vector<std::string>& srdf_xmls);

}  // namespace proximity_server::scene
