#pragma once

#include "proximity_server/scene/points/point_search.h"

#include <string>

namespace proximity_server::tools {

/// Reads the points of --points, in the frame of the root link: CSV with the columns x, y and z, and radius if they have
/// one; or a .npy of as many columns.
/// Failure: throws std::invalid_argument naming the file, and the line or the number of a point, for a text that is no
///          finite number, for other columns, and as scene::requireValid().
scene::Points readPoints(const std::string& file);

}  // namespace proximity_server::tools
