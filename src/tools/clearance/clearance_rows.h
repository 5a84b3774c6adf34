#pragma once

#include <string>

#include "proximity_server/scene/query/question.h"
#include "tools/clearance/trajectory_run.h"

namespace proximity_server::tools {

enum class RowFormat : unsigned char { Csv, Json };

/// What the rows are about.
enum class RowKind : unsigned char { State, Segment };

/// What stands before the first row: the header of the CSV, the opening bracket of the JSON array.
std::string rowsBegin(RowKind kind, RowFormat format);

// Rows are in the root link's frame, without separator or line end. A number that is not known is nan in CSV and null
// in JSON.

/// One pair in one state.
std::string rowText(long state, const scene::PairProximity& pair, const scene::RobotModel& robot, RowFormat format);

/// One segment: the closest pair where it is closest, with the bounds of the whole segment, then the first contact; all
/// times on the trajectory's clock. Where contact is not known it is `unknown` in CSV and null in JSON. JSON has the
/// positions of the joints at contact, too; followers are not listed.
std::string rowText(const SegmentClearance& answer, const scene::RobotModel& robot, RowFormat format);

/// Between two rows, and after the last one.
std::string rowsSeparator(RowFormat format);
std::string rowsEnd(RowFormat format);

}  // namespace proximity_server::tools
