#pragma once

#include <string>

#include "proximity_server/scene/levels/level_thresholds.h"
#include "proximity_server/scene/objects/objects.h"
#include "proximity_server/scene/query/question.h"
#include "tools/clearance/trajectory_run.h"

namespace proximity_server::tools {

enum class RowFormat : unsigned char { Csv, Json, Npy };

/// A row describes one pair in a state, or one segment of a trajectory.
enum class RowKind : unsigned char { State, Segment };

/// Whether the rows of states say the level of their pair.
enum class LevelColumn : unsigned char { Without, With };

/// The text before the first row: the header of the CSV, or the opening bracket of the JSON array.
std::string rowsBegin(RowKind kind, RowFormat format, LevelColumn levels = LevelColumn::Without);

// Rows are in the root link's frame and have neither separator nor line end. An unknown number is nan in CSV and null
// in JSON.

/// The level of a pair by its own thresholds: "STOP"; "INVALID" without an answer.
std::string levelText(const scene::PairProximity& pair, const scene::LevelThresholds& thresholds);

/// One pair in one state. Without objects `objects` is nullptr. With thresholds the row has a level.
std::string rowText(long state, const scene::PairProximity& pair, const scene::RobotModel& robot,
                    const scene::Objects* objects, RowFormat format, const scene::LevelThresholds* thresholds);

/// One segment: the closest pair at the time when it is closest, with the bounds of the whole segment, then the first
/// contact; all times are those of the trajectory. A contact that is not decided is `unknown` in CSV and null in JSON.
/// JSON also has the positions of the joints at contact, without mimic joints.
std::string rowText(const SegmentClearance& answer, const scene::RobotModel& robot, RowFormat format);

/// The text between two rows, and that after the last row.
std::string rowsSeparator(RowFormat format);
std::string rowsEnd(RowFormat format);

}  // namespace proximity_server::tools
