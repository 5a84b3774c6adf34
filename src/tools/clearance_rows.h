#pragma once

#include <string>

#include "proximity_server/scene/scene.h"

namespace proximity_server {

enum class RowFormat : unsigned char { Csv, Json };

/// What stands before the first row: the header of the CSV, the opening bracket of the JSON array.
std::string rowsBegin(RowFormat format);

/// One pair in one state, in the root link's frame, without separator or line end. A number that is not known is nan
/// in CSV and null in JSON.
std::string rowText(long state, const PairProximity& pair, const RobotModel& robot, RowFormat format);

/// Between two rows, and after the last one.
std::string rowsSeparator(RowFormat format);
std::string rowsEnd(RowFormat format);

}  // namespace proximity_server
