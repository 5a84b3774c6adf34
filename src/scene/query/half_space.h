#pragma once

#include "scene/query/closest_pieces.h"

namespace proximity_server::scene {

/// The signed distance of a piece from a half-space, in closed form. The normal of the plane gives the point of the
/// piece that is lowest above the plane. The way out is along the normal, because no other way is shorter. The normal
/// of the result points from the piece into the half-space.
/// Frame: the frame of the body of the piece; a_T_b maps coordinates of the half-space into it. Metres.
/// Error: `rounding` [m], see PlacedRobot::rounding(); the bounds include it.
narrowphase::SignedDistance halfSpaceDistance(const Piece& piece, const PlacedHalfSpace& half_space,
                                              const RelativePose& a_T_b, double rounding, double tolerance);

/// [m] A lower bound of the signed distance from a half-space to the content of a volume.
double halfSpaceGap(const Volume& a, const PlacedHalfSpace& half_space, const RelativePose& a_T_b, double rounding);

/// Finds the pieces of a that are closest to the half-spaces of b, if they are closer than `limit` [m].
ClosestPieces closestToHalfSpaces(const PlacedPair& pair, double limit, const Question& question, Skipping skipping);

}  // namespace proximity_server::scene
