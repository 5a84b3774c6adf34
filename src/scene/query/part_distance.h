#pragma once

#include "scene/query/closest_pieces.h"

namespace proximity_server::scene {

/// Finds the closest of all pieces, half-spaces and interiors of two parts, if they are closer than `limit` [m].
/// `guess`: see PieceSearch::between().
ClosestPieces closestOf(PieceSearch& search, const PlacedPair& pair, const LeafPair& guess, double limit,
                        const Question& question);

/// True if no translation shorter than the depth of the closest pieces separates two parts in overlap.
bool depthIsExact(const Part& a, const Part& b);

/// The answer without computing anything, if bounds prove this distance [m] of two parts.
PairProximity proofOf(const Part& a, const Part& b, double lower_bound);

/// The answer about what closestOf() found with the same limit and question, in the frame of the body of a; it names no
/// parts. If all pieces are beyond the limit, it has only the proof.
PairProximity answerOf(const RobotModel& robot, const PlacedPair& pair, const ClosestPieces& closest, double limit,
                       const Question& question);

}  // namespace proximity_server::scene
