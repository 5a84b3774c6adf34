#pragma once

#include "scene/query/closest_pieces.h"

namespace proximity_server::scene {

/// The signed distance of a piece from a half-space, in closed form: the plane's normal tells the point of the piece
/// that is lowest above the plane, and the way out is along the normal, as no other way is shorter. The normal of the
/// result points from the piece into the half-space.
///
/// Frame: that of the body of the piece; a_T_b maps coordinates of the half-space into it. Metres.
/// Error: `rounding` [m], see PlacedRobot::rounding(); the bounds hold it.
narrowphase::SignedDistance halfSpaceDistance(const Piece& piece, const PlacedHalfSpace& half_space,
                                              const RelativePose& a_T_b, double rounding, double tolerance);

/// A lower bound [m] of the signed distance of what a volume contains.
double halfSpaceGap(const Volume& a, const PlacedHalfSpace& half_space, const RelativePose& a_T_b, double rounding);

/// The pieces of a that are closest to the half-spaces of b, if they are closer than `limit` [m].
ClosestPieces closestToHalfSpaces(const PlacedRobot& robot, const Visit& pair, const RelativePose& a_T_b, double limit,
                                  const Question& question, Skipping skipping);

}  // namespace proximity_server::scene
