#pragma once

#include "scene/query/closest_pieces.h"

namespace proximity_server::scene {

/// Whether interiors belong to the distance of two parts.
inline bool haveInterior(const Part& a, const Part& b) { return a.whole().has_interior || b.whole().has_interior; }

/// Finds how deep pieces of one part lie in the interiors of the other, see Interior, where the pieces of both may be
/// apart.
///
/// 1. The surface of an interior is in the pieces of its part. So where no pieces meet, what hangs together of a
///    part lies wholly inside the interior of the other, or wholly outside; one anchor of each such component tells which.
/// 2. Walk from each interior through the volumes of the other part to the anchors, without what is outside of the
///    box of the interior.
/// 3. The answer about an anchor is the signed distance of the ball at its centre, see Shape::innerRadius(), from the
///    solid: no shorter translation takes the ball out of it, so the depth of the whole is not less.
///
/// That distance changes by no more than the two move, and where it is 0 the pieces meet. So the smaller one of it and
/// the distance of the pieces may be kept and bounded by motion as the latter alone.
///
/// Offers to `closest`, in the frame of a, all that is deeper than what it has, closer than `limit` [m] and, without the
/// padding of the pair, than `within` [m]: 0, unless the two may still move. The pair of leaves is the piece that has the interior, and the anchor. Points: on the surface of the interior, and in the other.
void offerInterior(const PlacedRobot& robot, const Visit& pair, const RelativePose& a_T_b, double limit,
                   const Question& question, Skipping skipping, double within, ClosestPieces& closest);

}  // namespace proximity_server::scene
